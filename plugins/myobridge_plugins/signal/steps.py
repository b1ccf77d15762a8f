"""Values at given times, joined by lines or held."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import choice, numbers
from myobridge_plugins.signal.piecewise import interpolate, mean_over_pieces, slope

__all__ = ["Steps"]


@final
@attrs.frozen
class Steps(Signal):
    r"""Values at given times.

    .. math:: s(t) = s_j \;(\text{hold}), \qquad
              s(t) = s_j + (s_{j+1} - s_j)\,\frac{t - t_j}{t_{j+1} - t_j} \;(\text{linear}), \qquad
              t_j \le t < t_{j+1}

    The first value holds before the first time, the last one after the last.

    Parameters
    ----------
    times : sequence of float
        Increasing times [s].
    values : sequence of float
        One value for each time, the same at all sites.
    interpolation : {"linear", "hold"}
        How the values are joined.

    Raises
    ------
    ParameterError
        If the lengths differ or the times do not increase.
    """

    summary: ClassVar[str] = "values at given times, joined by lines or held"

    times: tuple[float, ...] = numbers(unit="s", doc="increasing times")
    values: tuple[float, ...] = numbers(doc="one value for each time")
    interpolation: str = choice("linear", ("linear", "hold"), doc="how the values are joined")

    def __attrs_post_init__(self) -> None:
        for key, item in (("times", self.times), ("values", self.values)):
            if not isinstance(item, tuple):
                raise ParameterError(key, f"is {item!r}; expected a list of numbers")
        if len(self.times) != len(self.values):
            raise ParameterError("values", f"has {len(self.values)} entries for {len(self.times)} times; give as many")
        for i, (left, right) in enumerate(pairwise(self.times)):
            if right <= left:
                raise ParameterError(f"times[{i + 1}]", f"is {right!r}; expected a number in ({left}, inf) [s]")

    @cached_property
    def _values(self) -> Array:
        return np.asarray(self.values, dtype=np.float64)

    def value(self, time: float) -> Array:
        if self.interpolation == "linear":
            return interpolate(self.times, self._values, time)
        return np.asarray(self._values[max(bisect_right(self.times, time) - 1, 0)])

    def mean(self, start: float, end: float) -> Array:
        return mean_over_pieces(self.value, self.times, start, end)

    def rate(self, time: float) -> Array:
        return slope(self.times, self._values, time) if self.interpolation == "linear" else np.zeros(())

    def jumps(self) -> tuple[float, ...]:
        return self.times


@hookimpl
def myobridge_signals():
    return {"steps": Steps}
