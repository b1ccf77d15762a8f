"""What a scene would run into later, found before the first step: values of a signal that make no sense."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, MacroSolid, Signal

__all__ = ["check_activation", "check_prescribed_stretch", "memory_of_this_machine"]

# Jumps and kinks are looked at exactly; between them a signal is sampled.
_SAMPLES = 1000


def memory_of_this_machine() -> float:
    """Bytes of memory that the machine has; infinite where it does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def check_activation(signal: Signal, n_sites: int, duration: float) -> None:
    """Activation has one value, or one a site, within [0, 1] at all times.

    Raises
    ------
    ParameterError
    """
    shape = np.shape(signal.value(0.0))
    if shape not in ((), (1,), (n_sites,)):
        raise ParameterError("activation", f"has {shape[0]} values; expected 1 or {n_sites}, one for each site")
    _check("activation", signal.value, signal.jumps(), duration, 0.0, 1.0, "values in [0, 1]")


def check_prescribed_stretch(solid: MacroSolid, duration: float) -> None:
    """A prescribed stretch is positive at all times.

    Raises
    ------
    ParameterError
    """
    nothing = np.empty(0)
    tiny = float(np.finfo(float).tiny)
    _check(
        "solid",
        lambda time: solid.stretch(nothing, time),
        solid.jumps(),
        duration,
        tiny,
        np.inf,
        "a stretch in (0, inf)",
    )


def _check(
    key: str,
    value: Callable[[float], Array],
    jumps: tuple[float, ...],
    duration: float,
    low: float,
    high: float,
    allowed: str,
) -> None:
    # Many sites at once make a look dear: then fewer times, and the jumps all the same.
    samples = int(np.clip(10_000_000 // max(np.size(value(0.0)), 1), 10, _SAMPLES))
    times = np.union1d(np.linspace(0.0, duration, samples + 1), [time for time in jumps if 0.0 <= time <= duration])
    for time in times.tolist():
        here = np.asarray(value(time))
        # Written so that nan is caught too.
        if not (here.min() >= low and here.max() <= high):
            worst = here.max() if here.max() > high else here.min()
            raise ParameterError(key, f"is {worst:g} at t = {time:g} s; expected {allowed}")
