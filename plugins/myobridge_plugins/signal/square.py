"""Train of rectangular pulses."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import integer, number, numbers
from myobridge_plugins.signal.piecewise import mean_over_pieces

__all__ = ["Square"]


@final
@attrs.frozen
class Square(Signal):
    r"""Train of `pulses` rectangular pulses.

    .. math:: s(t) = s_h \text{ for } t_0 + k/f \le t < t_0 + (k + d)/f,\; k = 0 \ldots n-1; \qquad s(t) = s_l
              \text{ otherwise}

    The train is finite, so that all its jumps can be named: steps end on each of them.

    Parameters
    ----------
    low, high : float or sequence of float, shape () or (n_sites,)
        Values between and in the pulses.
    frequency : float
        Pulses a second [Hz].
    duty : float
        Share of a period that a pulse lasts [-]; with 1 the train is one long pulse.
    start : float
        When the first pulse begins [s].
    pulses : int
        How many pulses there are.
    """

    summary: ClassVar[str] = "train of rectangular pulses"

    low: float | tuple[float, ...] = numbers(0.0, doc="value between pulses")
    high: float | tuple[float, ...] = numbers(1.0, doc="value in a pulse")
    frequency: float = number(unit="Hz", within="(0, inf)", doc="pulses a second")
    duty: float = number(0.5, within="(0, 1]", doc="share of the period that a pulse lasts")
    start: float = number(0.0, unit="s", doc="when the first pulse begins")
    pulses: int = integer(1, within="[1, 1000000]", doc="number of pulses, after which the value stays low")

    @cached_property
    def _low(self) -> Array:
        return np.asarray(self.low + 0.0 * self._high if np.ndim(self.low) == 0 else self.low, dtype=np.float64)

    @cached_property
    def _high(self) -> Array:
        return np.asarray(self.high, dtype=np.float64)

    @cached_property
    def _jumps(self) -> tuple[float, ...]:
        if self.duty == 1.0:
            return (self.start, self.start + self.pulses / self.frequency)
        number = np.arange(self.pulses)
        times = np.stack([number, number + self.duty], axis=1).ravel() / self.frequency + self.start
        return tuple(times.tolist())

    def value(self, time: float) -> Array:
        return self._high if bisect_right(self._jumps, time) % 2 else self._low

    def mean(self, start: float, end: float) -> Array:
        return mean_over_pieces(self.value, self._jumps, start, end)

    def rate(self, time: float) -> Array:
        return np.zeros_like(self._low)

    def jumps(self) -> tuple[float, ...]:
        return self._jumps


@hookimpl
def myobridge_signals():
    return {"square": Square}
