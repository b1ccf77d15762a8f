"""Checks of what a model promises: bounds, conservation, realizability, order."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from myobridge.interfaces import Array, CrossBridgeModel
from myobridge.testing.cross_bridge_samples import sample
from myobridge.testing.fitted_order import fitted_order

__all__ = [
    "check_bounds",
    "check_conserves_heads",
    "check_no_step",
    "check_order",
    "check_realizable",
    "check_zero_activation",
    "path_states",
]


def check_no_step(model: CrossBridgeModel) -> None:
    """A reaction of no time and a slide of no distance change nothing."""
    state, activation, stretch, _, _ = sample(model, 4)
    moments = model.moments(state)
    after, fluxes = model.react(state, activation, stretch, 0.0)
    assert np.allclose(model.moments(after), moments, rtol=1e-12, atol=1e-13), "a reaction of 0 s changes the moments"
    assert max(float(np.max(np.abs(item))) for item in fluxes) <= 1e-13, "a reaction of 0 s has fluxes"
    after = model.slide(state, np.zeros(4))
    assert np.allclose(model.moments(after), moments, rtol=1e-13, atol=1e-14), "a slide by 0 changes the moments"


def check_zero_activation(model: CrossBridgeModel) -> None:
    """Without activation the population dies out quietly: all finite, energy not negative, then it comes back."""
    state = model.initial_state(2)
    off, on, stretch = np.zeros(2), np.ones(2), np.array([1.0, 1.1])
    dt = min(2e-3, 0.5 * model.promises.largest_step)
    for activation in (off, on):
        for _ in range(600):
            state, fluxes = model.react(state, activation, stretch, dt)
            assert all(np.all(np.isfinite(item)) for item in (state, *fluxes)), "not finite"
            assert np.all(model.energy(state) >= 0.0), "negative energy"


def _shaken(model: CrossBridgeModel) -> list[Array]:
    """States of histories with steps up to 50 ms and displacements up to 100 reaches."""
    found = []
    for seed in range(12):
        generator = np.random.default_rng(seed)
        dt = min(float(10.0 ** generator.uniform(-5.0, np.log10(0.05))), model.promises.largest_step)
        state = model.initial_state(16)
        for _ in range(12):
            activation = np.where(generator.random(16) < 0.3, 0.0, generator.random(16))
            state, _ = model.react(state, activation, generator.uniform(0.6, 1.6, 16), dt)
            found.append(state)
            state = model.slide(state, generator.uniform(-2000.0, 2000.0, 16) * dt * generator.random())
            found.append(state)
    return found


def check_realizable(model: CrossBridgeModel) -> None:
    """Q0 >= 0 and Q0 Q2 >= Q1^2 (to round-off) for every step, speed and activation."""
    for state in _shaken(model):
        moments = model.moments(state)
        assert np.all(np.isfinite(moments)), "moments are not finite"
        q0, q1, q2 = moments.T
        assert np.all(q0 >= 0.0), f"Q0 = {np.min(q0)}"
        gap = q0 * q2 - q1 * q1
        assert np.all(gap >= -1e-13 * (q0 * q2 + q1 * q1)), f"Q0 Q2 - Q1^2 = {np.min(gap)}"


def check_bounds(model: CrossBridgeModel) -> None:
    """The attached fraction stays in [0, 1], where the model can show it; else Q0 is not negative."""
    for state in _shaken(model):
        picture = model.density(state)
        if picture is None:
            assert np.all(model.moments(state)[:, 0] >= 0.0), "Q0 is negative"
        else:
            low, high = float(np.min(picture[1])), float(np.max(picture[1]))
            assert low >= -1e-14, f"attached fraction {low}"
            assert high <= 1.0 + 1e-12, f"attached fraction {high}"


def check_conserves_heads(model: CrossBridgeModel) -> None:
    """`slide` keeps Q0."""
    for seed in range(5):
        state, _, _, displacement, _ = sample(model, 8, seed)
        before, after = model.moments(state)[:, 0], model.moments(model.slide(state, displacement))[:, 0]
        error = float(np.max(np.abs(after - before)))
        assert error <= 1e-13, f"sliding changes Q0 by {error}"


def path_states(model: CrossBridgeModel, n_steps: int, duration: float = 0.04) -> Array:
    """Moments and tension after `n_steps` of `advance` along a smooth path of the stretch, shape (4,)."""
    state = model.initial_state(1)
    times = np.linspace(0.0, duration, n_steps + 1)
    # Shortening by 1.5 reaches, ever more slowly. No reversal: after one, a density with jumps carries them across its
    # grid, and what converges slowly then is the grid, not the step.
    stretches = 1.0 - 1.5 * np.sin(0.45 * np.pi * times / duration) / model.gear
    activation = np.ones(1)
    for before, after in pairwise(stretches):
        state, _ = model.advance(state, activation, np.array([before]), np.array([after]), duration / n_steps, state)
    end = stretches[-1:]
    tension = model.active_law(state, activation, end).evaluate(end, np.zeros(1)).tension
    return np.concatenate([model.moments(state)[0], tension])


def check_order(model: CrossBridgeModel) -> None:
    """`advance` converges in the step with the order promised (0.15 less is taken), or is exact."""
    counts = (20, 40, 80, 160, 320)
    found = [path_states(model, n) for n in (*counts, 4 * counts[-1], 8 * counts[-1])]
    # The last two give the limit; a floor that does not depend on the step (the grid's error) drops out of it.
    limit = found[-1] + (found[-1] - found[-2]) / (2.0**model.promises.order - 1.0)
    errors = [float(np.max(np.abs(item - limit))) for item in found[: len(counts)]]
    if max(errors) <= 1e-11:
        return
    order = fitted_order([1.0 / n for n in counts], np.maximum(errors, 1e-16).tolist())
    message = f"observed order {order:.2f}, promised {model.promises.order}; errors {errors} for {counts} steps"
    print(message)
    assert order >= model.promises.order - 0.15, message
