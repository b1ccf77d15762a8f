"""A density of sarcomeres that falls towards the tendons."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, SarcomereDensity
from myobridge.parameters import choice, number

__all__ = ["Tapered"]

_AXES = ("x", "y", "z")


@final
@attrs.frozen
class Tapered(SarcomereDensity):
    r"""Density that rises from `floor` at both ends of the muscle to `top` within `taper` of its length.

    .. math:: \rho_{sc}(X) = \rho_0 + (\rho_1 - \rho_0)\,u^2 (3 - 2u), \qquad
              u = \min\Big\{1,\; \frac{\min(s, 1 - s)}{\tau}\Big\}, \quad s = \frac{x_a - x_0}{x_1 - x_0} \in [0, 1]

    Its slope is continuous where it meets the full density. Beyond the ends the floor holds.

    Parameters
    ----------
    along : {"x", "y", "z"}
        Axis along which the density changes.
    start, end : float
        Where the muscle begins and ends on that axis [m].
    floor, top : float
        Density at the ends and inside, relative to a fully packed muscle [-].
    taper : float
        Share of the length over which it rises, at each end; 0.5: the full density only in the middle.

    Raises
    ------
    ParameterError
        If the muscle ends before it begins, or (when the sites are known) the axis does not exist.

    Departures
    ----------
    The thesis draws its density and gives no formula; this one falls as smoothly, and in as large a part of the muscle.

    References
    ----------
    .. [1] The thesis, Fig. 4 of the chapter on numerical results: more supportive tissue close to the tendons.
    """

    summary: ClassVar[str] = "density that falls towards both ends of the muscle"

    along: str = choice("x", _AXES, doc="axis along which the density changes")
    start: float = number(0.0, unit="m", doc="where the muscle begins on that axis")
    end: float = number(0.1, unit="m", doc="where the muscle ends on that axis")
    floor: float = number(0.2, within="[0, inf)", doc="density at both ends")
    top: float = number(1.0, within="[0, inf)", doc="density inside")
    taper: float = number(0.4, within="(0, 0.5]", doc="share of the length over which it rises, at each end")

    def __attrs_post_init__(self) -> None:
        if self.end <= self.start:
            raise ParameterError("end", f"is {self.end!r}; expected a number in ({self.start}, inf) [m], after start")

    def at(self, positions: Array) -> Array:
        axis, dim = _AXES.index(self.along), positions.shape[1]
        if axis >= dim:
            raise ParameterError("along", f"is '{self.along}'; the sites have {', '.join(_AXES[:dim])}")
        s = np.clip((positions[:, axis] - self.start) / (self.end - self.start), 0.0, 1.0)
        u = np.minimum(np.minimum(s, 1.0 - s) / self.taper, 1.0)
        return self.floor + (self.top - self.floor) * u**2 * (3.0 - 2.0 * u)


@hookimpl
def myobridge_sarcomere_densities():
    return {"tapered": Tapered}
