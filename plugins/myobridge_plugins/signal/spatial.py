"""A signal that reaches a part of the muscle, and reaches it late."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import choice, integer, number, part

__all__ = ["Spatial"]

_AXES = ("x", "y", "z")
_SAME: Any = attrs.cmp_using(eq=np.array_equal)


@final
@attrs.frozen
class Spatial(Signal):
    r"""Recruitment of one compartment, and conduction along the fibres.

    .. math:: r(X, t) = w(x_a)\; s\Big(t - \frac{|x_a - x_0|}{c}\Big), \qquad
              w(x) = \min\{S\big((x - x_1)/\delta\big),\, S\big((x_2 - x)/\delta\big)\}

    with the coordinate x_a along the axis `along`, S(u) = 0 below -1/2, 1 above 1/2 and 1/2 + u (3/2 - 2 u^2) between,
    so that the compartment ends at x_1 and x_2 within edges of width delta; delta = 0 is a sharp end. Without `speed` c
    the signal s comes everywhere at once.

    Parameters
    ----------
    signal : Signal
        What arrives; its own values a site are kept.
    along : {"x", "y", "z"}
        Axis of the compartment and of conduction.
    start, end : float, optional
        Where the compartment begins and ends on the axis [m]; without, it goes on.
    edge : float
        Width over which recruitment falls at both ends [m].
    speed : float, optional
        Conduction velocity [m/s], about 4 in human muscle.
    innervation : float
        Place on the axis from which the excitation spreads both ways [m].
    delays : int
        Number of different delays: sites are put into as many zones of equal depth, each delayed as in its middle.
        Every zone has its own jumps, at which steps end.

    Raises
    ------
    ParameterError
        If the compartment ends before it begins, or (when the sites are known) the axis does not exist.

    Departures
    ----------
    Excitation runs straight along an axis, not along curved fibres.

    References
    ----------
    .. [1] S. Andreassen, L. Arendt-Nielsen, J. Physiol. 391 (1987) 561-571: conduction velocity 2 to 6 m/s.
    """

    summary: ClassVar[str] = "another signal in one compartment of the muscle, conducted at a given speed"

    signal: Signal = part("signal", doc="what arrives")
    along: str = choice("x", _AXES, doc="axis of the compartment and of conduction")
    start: float | None = number(None, unit="m", doc="where the compartment begins; without, it goes on")
    end: float | None = number(None, unit="m", doc="where it ends; without, it goes on")
    edge: float = number(0.0, unit="m", within="[0, inf)", doc="width over which recruitment falls at both ends")
    speed: float | None = number(None, unit="m/s", within="(0, inf)", doc="conduction velocity; without, no delay")
    innervation: float = number(0.0, unit="m", doc="place on the axis from which the excitation spreads both ways")
    delays: int = integer(16, within="[1, 1000]", doc="number of different delays")

    def __attrs_post_init__(self) -> None:
        if self.start is not None and self.end is not None and self.end <= self.start:
            raise ParameterError("end", f"is {self.end!r}; expected a number in ({self.start}, inf) [m], after start")

    def located(self, positions: Array) -> Signal:
        axis, dim = _AXES.index(self.along), positions.shape[1]
        if axis >= dim:
            raise ParameterError("along", f"is '{self.along}'; the sites have {', '.join(_AXES[:dim])}")
        place = positions[:, axis]
        inner = self.signal.located(positions)
        if self.speed is None:
            return Located(inner, self._factor(place), (0.0,), np.zeros(len(place), dtype=np.int64))
        delay = np.abs(place - self.innervation) / self.speed
        first, width = delay.min(), np.ptp(delay) / self.delays
        zone = np.clip((delay - first) / (width or 1.0), 0, self.delays - 1).astype(np.int64)
        used, zone = np.unique(zone, return_inverse=True)
        return Located(inner, self._factor(place), tuple((first + (used + 0.5) * width).tolist()), zone)

    def value(self, time: float) -> Array:
        raise ParameterError(
            "plugin",
            "'spatial' has no value before it knows the sites; it drives the activation, not loads or stretches",
        )

    def mean(self, start: float, end: float) -> Array:
        return self.value(start)

    def _factor(self, place: Array) -> Array:
        factor = np.ones(len(place))
        if self.start is not None:
            factor = np.minimum(factor, self._smooth(place - self.start))
        if self.end is not None:
            factor = np.minimum(factor, self._smooth(self.end - place))
        return factor

    def _smooth(self, depth: Array) -> Array:
        if self.edge == 0.0:
            return (depth >= 0.0).astype(np.float64)
        u = np.clip(depth / self.edge, -0.5, 0.5)
        return 0.5 + u * (1.5 - 2.0 * u**2)


@final
@attrs.frozen
class Located(Signal):
    """A signal times a factor a site, delayed by that of the site's zone.

    Attributes
    ----------
    signal : Signal
    factor : ndarray, shape (n_sites,)
        In [0, 1].
    delays : tuple of float
        Delay of each zone [s].
    zone : ndarray, shape (n_sites,)
        Zone of each site.
    """

    signal: Signal
    factor: Array = attrs.field(eq=_SAME)
    delays: tuple[float, ...]
    zone: Any = attrs.field(eq=_SAME)

    @cached_property
    def _jumps(self) -> tuple[float, ...]:
        jumps: list[float] = []
        for jump in sorted(_after(time, delay) for time in self.signal.jumps() for delay in self.delays):
            if jumps and jump - jumps[-1] < 1e-12 * (1.0 + abs(jump)):
                jumps.pop()  # two that rounding alone tells apart are one: the later, when both are over
            jumps.append(jump)
        return tuple(jumps)

    def value(self, time: float) -> Array:
        return self._spread([self.signal.value(time - delay) for delay in self.delays])

    def mean(self, start: float, end: float) -> Array:
        if end <= start:
            return self.value(start)
        return self._spread([self.signal.mean(start - delay, end - delay) for delay in self.delays])

    def rate(self, time: float) -> Array:
        return self._spread([self.signal.rate(time - delay) for delay in self.delays])

    def jumps(self) -> tuple[float, ...]:
        return self._jumps

    def _spread(self, zones: list[Array]) -> Array:
        """Value of each site out of those of the zones, each of shape () or (n_sites,)."""
        if len(zones) == 1:
            return self.factor * zones[0]
        each = np.stack(zones)
        return self.factor * (each[self.zone] if each.ndim == 1 else each[self.zone, np.arange(len(self.zone))])


def _after(time: float, delay: float) -> float:
    """First number at which a signal delayed by `delay` has had its jump at `time`, in spite of rounding."""
    jump = time + delay
    while jump - delay < time:
        jump = math.nextafter(jump, math.inf)
    return jump


@hookimpl
def myobridge_signals():
    return {"spatial": Spatial}
