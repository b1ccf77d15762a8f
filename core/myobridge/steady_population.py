"""Steady population: what heads at rest come to when the filaments are held for long."""

from __future__ import annotations

import numpy as np

from myobridge.errors import SceneError
from myobridge.interfaces import Array, CrossBridgeModel

__all__ = ["steady_population"]

# [s] One long step, which is enough for a model that reacts exactly, and short ones for the others.
_LONG, _SHORT = 1e3, 1e-3
_MOST = 20_000
# Change in a short step, relative to the largest value, that is none.
_STILL = 1e-12


def steady_population(model: CrossBridgeModel, activation: Array, stretch: Array) -> Array:
    """Isometric steady state of a model, shape (n_sites, m).

    Parameters
    ----------
    activation : ndarray, shape (n_sites,)
        Activation [-].
    stretch : ndarray, shape (n_sites,)
        Stretch at which the filaments are held [-].

    Raises
    ------
    SceneError
        If the population does not come to rest.
    """
    start = model.initial_state(stretch.size)
    if start.shape[1] == 0:
        return start
    state, _ = model.react(start, activation, stretch, _LONG)
    if np.all(np.isfinite(state)):
        again, _ = model.react(state, activation, stretch, _SHORT)
        if _apart(again, state) <= _STILL:
            return state
    state = start
    for _ in range(_MOST):
        again, _ = model.react(state, activation, stretch, _SHORT)
        if _apart(again, state) <= _STILL:
            return again
        state = again
    raise SceneError(
        f"cross_bridges: the population of {type(model).__name__} has not come to rest after {_MOST * _SHORT:g} s with "
        "the filaments held; start as given"
    )


def _apart(state: Array, other: Array) -> float:
    return float(np.abs(state - other).max(initial=0.0)) / max(float(np.abs(other).max(initial=0.0)), 1e-300)
