"""Single activation pulse with the shape of a twitch."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import number, numbers

__all__ = ["Twitch"]


@final
@attrs.frozen
class Twitch(Signal):
    r"""Impulse response of a critically damped system of second order, the usual shape of a twitch.

    .. math:: s(t) = a\,x\,e^{1-x}, \quad x = (t - t_0)/\tau \ge 0; \qquad
              \int_{x_0}^{x_1} x e^{1-x} dx = e^{1-x_0} \left[(1 + x_0)(1 - e^{-d}) - d e^{-d}\right],
              \quad d = x_1 - x_0

    It peaks with the value a at :math:`t_0 + \tau`.

    Parameters
    ----------
    amplitude : float or sequence of float, shape () or (n_sites,)
        Value at the peak.
    time_to_peak : float
        From the start to the peak [s].
    start : float
        When the pulse begins [s].

    References
    ----------
    .. [1] H. S. Milner-Brown, R. B. Stein, R. Yemm, J. Physiol. 230 (1973) 359-370: the second-order shape.
    """

    summary: ClassVar[str] = "one pulse x exp(1 - x) with its peak at x = 1"

    amplitude: float | tuple[float, ...] = numbers(1.0, doc="value at the peak")
    time_to_peak: float = number(unit="s", within="(0, inf)", doc="time from the start to the peak")
    start: float = number(0.0, unit="s", doc="when the pulse begins")

    @cached_property
    def _amplitude(self) -> Array:
        return np.asarray(self.amplitude, dtype=np.float64)

    def value(self, time: float) -> Array:
        x = max(time - self.start, 0.0) / self.time_to_peak
        return np.asarray(self._amplitude * (x * math.exp(1.0 - x)))

    def mean(self, start: float, end: float) -> Array:
        if end <= start:
            return self.value(start)
        # d from the times, not as a difference of x, which would lose the digits of a short interval.
        first, last = max(start, self.start), max(end, self.start)
        x0 = (first - self.start) / self.time_to_peak
        d = (last - first) / self.time_to_peak
        integral = math.exp(1.0 - x0) * (-(1.0 + x0) * math.expm1(-d) - d * math.exp(-d))
        return np.asarray(self._amplitude * (integral * self.time_to_peak / (end - start)))

    def rate(self, time: float) -> Array:
        if time < self.start:
            return np.zeros_like(self._amplitude)
        x = (time - self.start) / self.time_to_peak
        return np.asarray(self._amplitude * ((1.0 - x) * math.exp(1.0 - x) / self.time_to_peak))

    def jumps(self) -> tuple[float, ...]:
        return (self.start,)


@hookimpl
def myobridge_signals():
    return {"twitch": Twitch}
