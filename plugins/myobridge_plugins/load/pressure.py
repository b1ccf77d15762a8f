"""Pressure that follows the surface."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Load, Signal, Surface
from myobridge.parameters import number, part, text
from myobridge_plugins.load.normals import area_slopes, area_vectors
from myobridge_plugins.load.spreading import factor

__all__ = ["Pressure"]


@final
@attrs.frozen
class Pressure(Load):
    r"""Follower pressure: along the deformed normal, on the deformed area.

    .. math:: f_a = -s(t)\,p \int N_a\,n\,da, \qquad n\,da = J F^{-T} N\,dA

    Its stiffness is exact, and not symmetric on a facet; on a closed surface the sum is.

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    pressure : float
        Pressure p [Pa]; positive pushes into the body.
    scale : Signal, optional
        Factor s(t) [-]; without it 1.
    """

    summary: ClassVar[str] = "pressure along the deformed normal"
    dead: ClassVar[bool] = False

    boundary: str = text(doc="name of the boundary")
    pressure: float = number(unit="Pa", doc="pressure, positive into the body")
    scale: Signal | None = part("signal", None, doc="factor as a function of time")

    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        pressure = factor(self.scale, time) * self.pressure
        return -pressure * np.einsum("pa,fpi->fai", surface.shapes, area_vectors(surface, displacement))

    def nodal_stiffness(self, surface: Surface, displacement: Array, time: float) -> Array:
        pressure = factor(self.scale, time) * self.pressure
        slopes = area_slopes(surface, displacement)
        return pressure * np.einsum("pa,fpibj->faibj", surface.shapes, slopes, optimize=True)

    def jumps(self) -> tuple[float, ...]:
        return () if self.scale is None else self.scale.jumps()


@hookimpl
def myobridge_loads():
    return {"pressure": Pressure}
