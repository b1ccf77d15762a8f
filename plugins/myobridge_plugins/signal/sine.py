"""Harmonic oscillation."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import number, numbers

__all__ = ["Sine"]


@final
@attrs.frozen
class Sine(Signal):
    r"""Harmonic oscillation.

    .. math:: s(t) = s_0 + a \sin(\omega t + \varphi), \qquad
              \bar s = s_0 + a \sin(\omega t_m + \varphi)\,\frac{\sin(\omega \tau / 2)}{\omega \tau / 2}

    with :math:`t_m` the middle and :math:`\tau` the length of the interval, :math:`\omega = 2 \pi f`.

    Parameters
    ----------
    offset, amplitude : float or sequence of float, shape () or (n_sites,)
        Value about which it swings, and how far.
    frequency : float
        Cycles a second [Hz].
    phase : float
        Phase at t = 0 [rad].
    """

    summary: ClassVar[str] = "harmonic oscillation about a value"

    offset: float | tuple[float, ...] = numbers(0.0, doc="value about which it swings")
    amplitude: float | tuple[float, ...] = numbers(1.0, doc="how far it swings")
    frequency: float = number(unit="Hz", within="(0, inf)", doc="cycles a second")
    phase: float = number(0.0, unit="rad", doc="phase at t = 0")

    @cached_property
    def _offset(self) -> Array:
        return np.asarray(self.offset, dtype=np.float64)

    @cached_property
    def _amplitude(self) -> Array:
        return np.asarray(self.amplitude, dtype=np.float64)

    @cached_property
    def _omega(self) -> float:
        return 2.0 * math.pi * self.frequency

    def value(self, time: float) -> Array:
        return np.asarray(self._offset + self._amplitude * math.sin(self._omega * time + self.phase))

    def mean(self, start: float, end: float) -> Array:
        middle = math.sin(self._omega * (start + 0.5 * (end - start)) + self.phase)
        return np.asarray(self._offset + self._amplitude * (middle * np.sinc(self.frequency * (end - start))))

    def rate(self, time: float) -> Array:
        slope = self._omega * math.cos(self._omega * time + self.phase)
        return np.asarray(0.0 * self._offset + self._amplitude * slope)


@hookimpl
def myobridge_signals():
    return {"sine": Sine}
