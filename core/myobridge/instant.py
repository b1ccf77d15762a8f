"""Instants: the end of a step lies before what happens there, the beginning of the next one after it."""

from __future__ import annotations

__all__ = ["just_before"]


def just_before(time: float, dt: float) -> float:
    """The end `time` of a step of `dt`, before any jump that happens there.

    Signals have at a jump the value after it, and steps end at jumps: what a step sees at its end is the value before.
    Earlier than `time` by a millionth of a millionth of the step, and by a few units of the last place.
    """
    return time * (1.0 - 1e-15) - 1e-12 * dt
