"""Largest step at which a case holds, by doubling or halving and then by bisection."""

from __future__ import annotations

import math
from collections.abc import Callable

from myobridge.scene import Scene

__all__ = ["largest_step"]

# How far from the nominal step it is looked for, and how closely.
_RANGE = 64.0
_CLOSE = 1.05


def largest_step(scene: Scene, holds: Callable[[Scene], bool], nominal: bool) -> tuple[float | None, bool]:
    """Largest step [s] that holds, and whether even the largest that was tried does.

    Parameters
    ----------
    holds : callable
        Tries a scene.
    nominal : bool
        Whether the scene's own step holds.

    Returns
    -------
    tuple
        (None, False) where no step down to a 64th of the nominal one holds.
    """
    # At least four steps: a run of one step shows nothing.
    step, highest = scene.step, min(_RANGE * scene.step, 0.25 * scene.duration)

    def good(dt: float) -> bool:
        return holds(scene.with_settings({"scene.step": dt}))

    low, high = (step, math.inf) if nominal else (0.0, step)
    while nominal and low < highest:
        trial = min(2.0 * low, highest)
        if not good(trial):
            high = trial
            break
        low = trial
    if nominal and math.isinf(high):
        return low, True
    while not nominal and low == 0.0:
        if high <= step / _RANGE:
            return None, False
        if good(0.5 * high):
            low = 0.5 * high
        else:
            high *= 0.5
    while high / low > _CLOSE:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if good(middle) else (low, middle)
    return low, False
