"""Hypothesis strategies for what a model is given: activations, stretches, steps, histories, deformations."""

from __future__ import annotations

import attrs
import hypothesis.strategies as st
import numpy as np

from myobridge.interfaces import Array, CrossBridgeModel
from myobridge.testing.material_samples import random_deformations

__all__ = ["History", "activations", "deformations", "displacements", "histories", "steps", "stretches"]


@attrs.frozen(eq=False)
class History:
    """Random path of a batch of sites, all steps of one length [s].

    `activation` and `stretch` have shape (n_steps, n_sites), `displacement` [reach] likewise.
    """

    dt: float
    activation: Array
    stretch: Array
    displacement: Array

    def states(self, model: CrossBridgeModel, state: Array) -> list[Array]:
        """States after each reaction and each slide, from `state` on."""
        found = []
        for activation, stretch, displacement in zip(self.activation, self.stretch, self.displacement, strict=True):
            state, _ = model.react(state, activation, stretch, self.dt)
            found.append(state)
            state = model.slide(state, displacement)
            found.append(state)
        return found


def activations() -> st.SearchStrategy[float]:
    """Activation in [0, 1], its ends and tiny values included."""
    return st.one_of(st.sampled_from([0.0, 1e-12, 1.0]), st.floats(0.0, 1.0))


def stretches(low: float = 0.6, high: float = 1.6) -> st.SearchStrategy[float]:
    """Stretch that tissue survives."""
    return st.floats(low, high)


def steps(longest: float = 0.05) -> st.SearchStrategy[float]:
    """Step [s] from a microsecond to `longest`, spread over the decades."""
    return st.floats(-6.0, float(np.log10(longest))).map(lambda power: 10.0**power)


def displacements(fastest: float, dt: float) -> st.SearchStrategy[float]:
    """Displacement [reach] of a step `dt` [s] at up to `fastest` [1/s]."""
    return st.floats(-fastest * dt, fastest * dt)


@st.composite
def histories(
    draw: st.DrawFn, n_sites: int = 8, n_steps: int = 4, fastest: float = 2000.0, longest: float = 0.05
) -> History:
    """Random `History`: one step length, and for every step and site an activation, a stretch and a speed.

    Hypothesis draws the step, the extremes and the seed; the bulk of the numbers comes from the seed, so that many
    sites cost no more than one.
    """
    dt = draw(steps(longest))
    speed = draw(st.floats(0.0, fastest))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = (n_steps, n_sites)
    activation = generator.uniform(0.0, 1.0, shape)
    activation[generator.random(shape) < 0.2] = draw(activations())
    displacement = generator.uniform(-1.0, 1.0, shape) * speed * dt
    displacement[generator.random(shape) < 0.1] = 0.0
    return History(dt, activation, generator.uniform(0.6, 1.6, shape), displacement)


@st.composite
def deformations(
    draw: st.DrawFn, n: int = 8, low: float = 0.6, high: float = 1.5, gap: float = 0.0
) -> tuple[Array, Array]:
    """Deformation gradients (n, 3, 3) with principal stretches from `low` to `high`, and fibre directions (n, 3).

    Hypothesis draws the extremes and the seed; `gap` keeps fibres away from their length at rest (see
    `myobridge.testing.material_samples.random_deformations`).
    """
    extremes = draw(st.tuples(st.floats(low, 1.0), st.floats(1.0, high)))
    return random_deformations(np.random.default_rng(draw(st.integers(0, 2**32 - 1))), n, *extremes, gap)
