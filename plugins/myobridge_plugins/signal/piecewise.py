r"""Piecewise-linear functions of time: value, slope and exact mean, shared by the signals that are made of pieces.

.. math:: \bar s = \frac{1}{b-a} \sum_j (t_{j+1} - t_j)\, s\big(\tfrac12 (t_j + t_{j+1})\big)

with the :math:`t_j` the ends a, b and the breaks between them: exact, since s is linear on each piece, and without the
cancellation that a difference of primitives suffers on short intervals.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from myobridge.interfaces import Array

__all__ = ["interpolate", "mean_over_pieces", "slope"]


def mean_over_pieces(value: Callable[[float], Array], breaks: Sequence[float], start: float, end: float) -> Array:
    """Mean of `value` over ``start <= t <= end``; `value` is linear between consecutive `breaks` (increasing)."""
    if end <= start:
        return value(start)
    first, last = bisect_right(breaks, start), bisect_left(breaks, end)
    ends = [start, *breaks[first:last], end]
    total = np.float64(0.0)
    for left, right in pairwise(ends):
        # A midpoint that rounding puts on the right end of a piece two ulps long would see the value after the jump.
        middle = min(left + 0.5 * (right - left), np.nextafter(right, left))
        total = total + (right - left) * value(float(middle))
    return np.asarray(total / (end - start))


def interpolate(times: Sequence[float], values: Array, time: float) -> Array:
    """Linear interpolation of `values`, shape (n_times,) or (n_times, n_sites); constant beyond both ends."""
    right = bisect_right(times, time)
    if right == 0:
        return np.asarray(values[0])
    if right == len(times):
        return np.asarray(values[-1])
    weight = (time - times[right - 1]) / (times[right] - times[right - 1])
    return np.asarray((1.0 - weight) * values[right - 1] + weight * values[right])


def slope(times: Sequence[float], values: Array, time: float) -> Array:
    """Derivative after `time` of `interpolate`."""
    right = bisect_right(times, time)
    if right in (0, len(times)):
        return np.zeros(values.shape[1:])
    return np.asarray((values[right] - values[right - 1]) / (times[right] - times[right - 1]))
