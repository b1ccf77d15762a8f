"""A Python function as a signal."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.interfaces import Array, Signal

__all__ = ["Function"]


@final
@attrs.frozen
class Function(Signal):
    """A Python function of time, for composition without a file (a scene is data, and names no code).

    Parameters
    ----------
    of_time : callable
        Value at a time [s], a number or one number a site.
    kinks : tuple of float
        Times at which value or slope jumps; steps end there, and means are taken piecewise.

    Departures
    ----------
    The mean is that of 8 Gauss points between kinks: exact for polynomials of degree 15, not for every function.
    """

    summary: ClassVar[str] = "a Python function of time"

    of_time: Callable[[float], Any]
    kinks: tuple[float, ...] = ()

    @cached_property
    def _rule(self) -> tuple[Array, Array]:
        nodes, weights = np.polynomial.legendre.leggauss(8)
        return 0.5 * (nodes + 1.0), 0.5 * weights

    def value(self, time: float) -> Array:
        return np.asarray(self.of_time(time), dtype=np.float64)

    def mean(self, start: float, end: float) -> Array:
        if end == start:
            return self.value(start)
        corners = [start, *(kink for kink in sorted(self.kinks) if start < kink < end), end]
        nodes, weights = self._rule
        total = np.zeros_like(self.value(start))
        for left, right in itertools.pairwise(corners):
            values = np.array([self.value(left + (right - left) * node) for node in nodes])
            total = total + (right - left) * np.tensordot(weights, values, axes=1)
        return total / (end - start)

    def jumps(self) -> tuple[float, ...]:
        return tuple(sorted(self.kinks))
