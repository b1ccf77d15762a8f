"""Linear ramp between two values."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import number, numbers
from myobridge_plugins.signal.piecewise import mean_over_pieces

__all__ = ["Ramp"]


@final
@attrs.frozen
class Ramp(Signal):
    r"""Linear ramp.

    .. math:: s(t) = s_0 + \dot s\,(\min(\max(t, t_0), t_1) - t_0), \qquad
              \dot s = (s_1 - s_0) / (t_1 - t_0)

    Give either `final` (then `end` is needed), or `slope` (then `end` may be left out: the ramp goes on for ever).

    Parameters
    ----------
    initial, final : float or sequence of float, shape () or (n_sites,)
        Values before `start` and after `end`; lists of velocities in one run: one value a site.
    start, end : float
        When the ramp begins and ends [s].
    slope : float or sequence of float, shape () or (n_sites,)
        Rate of change [1/s]; not called `rate`, which is a method of every signal.

    Raises
    ------
    ParameterError
        If both or none of `final` and `slope` are given, or `end` does not come after `start`.
    """

    summary: ClassVar[str] = "linear from one value to another, or at a given rate"

    initial: float | tuple[float, ...] = numbers(0.0, doc="value before the start")
    final: float | tuple[float, ...] | None = numbers(None, doc="value after the end")
    start: float = number(0.0, unit="s", doc="when the ramp begins")
    end: float | None = number(None, unit="s", doc="when the ramp ends")
    slope: float | tuple[float, ...] | None = numbers(None, unit="1/s", doc="rate of change, instead of a final value")

    def __attrs_post_init__(self) -> None:
        if (self.final is None) == (self.slope is None):
            given = "neither is given" if self.final is None else "both are given"
            raise ParameterError("final", f"or slope: {given}; give one of the two")
        if self.end is None and self.slope is None:
            raise ParameterError("end", "is missing; a ramp to a final value needs the time [s] at which it ends")
        if self.end is not None and self.end <= self.start:
            raise ParameterError("end", f"is {self.end!r}; expected a number in ({self.start}, inf) [s], after start")
        target = "final" if self.slope is None else "slope"
        sizes = np.size(self.initial), np.size(getattr(self, target))
        if min(sizes) > 1 and sizes[0] != sizes[1]:
            raise ParameterError(target, f"has {sizes[1]} values and initial has {sizes[0]}; expected as many, or one")

    @cached_property
    def _initial(self) -> Array:
        return np.asarray(self.initial, dtype=np.float64)

    @cached_property
    def _slope(self) -> Array:
        if self.final is None:
            return np.asarray(self.slope, dtype=np.float64)
        return (np.asarray(self.final, dtype=np.float64) - self._initial) / (self._end - self.start)

    @cached_property
    def _end(self) -> float:
        return math.inf if self.end is None else self.end

    @cached_property
    def _last(self) -> Array:
        # Not initial + slope * length: the final value must be what was asked for, to the last bit.
        if self.final is None:
            return self._initial + self._slope * (self._end - self.start)
        return np.broadcast_to(np.asarray(self.final, dtype=np.float64), self._slope.shape)

    @cached_property
    def _jumps(self) -> tuple[float, ...]:
        return (self.start,) if self.end is None else (self.start, self.end)

    def value(self, time: float) -> Array:
        if time >= self._end:
            return self._last
        return np.asarray(self._initial + self._slope * max(time - self.start, 0.0))

    def mean(self, start: float, end: float) -> Array:
        return mean_over_pieces(self.value, self._jumps, start, end)

    def rate(self, time: float) -> Array:
        return self._slope if self.start <= time < self._end else np.zeros_like(self._slope)

    def jumps(self) -> tuple[float, ...]:
        return self._jumps


@hookimpl
def myobridge_signals():
    return {"ramp": Ramp}
