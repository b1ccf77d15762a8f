"""States, activations and stretches on which the checks of a cross-bridge model run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from myobridge.interfaces import Array, CrossBridgeModel

__all__ = ["Sample", "sample"]


class Sample(NamedTuple):
    """State reached by a random history, and what comes next."""

    state: Array
    activation: Array
    stretch: Array
    displacement: Array
    dt: float


def sample(model: CrossBridgeModel, n_sites: int, seed: int = 0, n_steps: int = 6) -> Sample:
    """State after `n_steps` random reactions and slides, different at each site, with a random step to do next.

    The steps are such that every method keeps what it promises: 0.1 to 2 ms, at most 0.2 of the reach each.
    """
    generator = np.random.default_rng(seed)
    state = model.initial_state(n_sites)
    dt = min(float(10.0 ** generator.uniform(-4.0, -2.7)), model.promises.largest_step)
    for _ in range(n_steps):
        state, _ = model.react(state, generator.uniform(0.2, 1.0, n_sites), np.ones(n_sites), dt)
        state = model.slide(state, generator.uniform(-0.2, 0.2, n_sites))
    return Sample(
        state,
        generator.uniform(0.0, 1.0, n_sites),
        generator.uniform(0.85, 1.3, n_sites),
        generator.uniform(-0.2, 0.2, n_sites),
        dt,
    )
