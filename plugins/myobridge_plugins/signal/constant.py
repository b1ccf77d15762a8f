"""Constant signal."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import numbers

__all__ = ["Constant"]


@final
@attrs.frozen
class Constant(Signal):
    r"""Constant signal.

    .. math:: s(t) = s_0

    Parameters
    ----------
    level : float or sequence of float, shape () or (n_sites,)
        The value, in the unit of what the signal drives.
    """

    summary: ClassVar[str] = "the same value at all times"

    level: float | tuple[float, ...] = numbers(1.0, doc="value at all times")

    @cached_property
    def _level(self) -> Array:
        return np.asarray(self.level, dtype=np.float64)

    def value(self, time: float) -> Array:
        return self._level

    def mean(self, start: float, end: float) -> Array:
        return self._level

    def rate(self, time: float) -> Array:
        return np.zeros_like(self._level)


@hookimpl
def myobridge_signals():
    return {"constant": Constant}
