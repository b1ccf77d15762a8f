"""Elastic bedding of a boundary."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Load, Surface
from myobridge.parameters import number, text
from myobridge_plugins.load.normals import unit_normals

__all__ = ["Robin"]


@final
@attrs.frozen
class Robin(Load):
    r"""Springs between a boundary and the ground, spread over the reference area (Robin condition).

    .. math:: f_a = -\int N_a\,K u\,dA, \qquad K = k_n\,N N^T + k_t\,(I - N N^T), \qquad
              W = \tfrac12 \int u \cdot K u\,dA

    with the unit normal N of the reference, so the springs are linear.

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    normal, tangential : float
        Stiffness per reference area along the normal and across it [Pa/m].
    """

    summary: ClassVar[str] = "elastic bedding, linear springs along and across the normal"
    dead: ClassVar[bool] = False

    boundary: str = text(doc="name of the boundary")
    normal: float = number(0.0, unit="Pa/m", within="[0, inf)", doc="stiffness along the reference normal")
    tangential: float = number(0.0, unit="Pa/m", within="[0, inf)", doc="stiffness across the reference normal")

    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        return -np.einsum("faibj,fbj->fai", self.nodal_stiffness(surface, displacement, time), displacement)

    def nodal_stiffness(self, surface: Surface, displacement: Array, time: float) -> Array:
        normals = unit_normals(surface)
        along = np.einsum("fpi,fpj->fpij", normals, normals)
        local = self.tangential * np.eye(surface.dimension) + (self.normal - self.tangential) * along
        return np.einsum("fp,pa,pb,fpij->faibj", surface.areas, surface.shapes, surface.shapes, local, optimize=True)

    def energy(self, surface: Surface, displacement: Array) -> float:
        return -0.5 * float(np.vdot(self.nodal_force(surface, displacement, 0.0), displacement))


@hookimpl
def myobridge_loads():
    return {"robin": Robin}
