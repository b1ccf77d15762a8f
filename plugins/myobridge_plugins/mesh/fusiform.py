"""The three-dimensional muscle: a belly between two tendons, of round or elliptic cross-section."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MeshSource
from myobridge.mesh_check import check_mesh
from myobridge.parameters import choice, integer, number
from myobridge_plugins.mesh.disc import INNER, disc
from myobridge_plugins.mesh.extrusion import extruded
from myobridge_plugins.mesh.grid import moved
from myobridge_plugins.mesh.outline import Outline

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Fusiform"]


@final
@attrs.frozen
class Fusiform(MeshSource):
    r"""Muscle of revolution about the x axis, flattened on request, with tendons at both ends.

    .. math:: X = \big(L s,\; r(s)\,y,\; a\,r(s)\,z\big), \quad y^2 + z^2 \le 1, \qquad
              r(s) = r_e + (r_b - r_e)\,\sin^2\!\Big(\pi\,\frac{s - \tau}{1 - 2\tau}\Big)

    r is constant in the tendons, the share tau of the length at each end. Volume: pi a L (2 tau r_e^2 + (1 - 2 tau)
    (r_e^2 + r_e d + 3 d^2 / 8)), d = r_b - r_e; that of the mesh tends to it with the square of the cell size.

    Boundaries: left, right (the ends), skin. Subdomains: muscle; with tendons also tendon_left, tendon_right and tendon
    (both).

    Parameters
    ----------
    length, radius, end_radius : float
        From end to end; half axis along y at the belly, and at the ends [m].
    flatness : float
        Half axis along z by that along y.
    tendon : float
        Share of the length that the tendon at each end takes.
    cells : int, optional
        Cells along the length, shorter where the muscle is thinner; each tendon has at least one. By default so many
        that cells in the middle are half as long again as they are wide: then no
        tetrahedron has a scaled Jacobian below 0.1 while the length is at least 6 radii, flatness in [0.5, 1], `tendon`
        in [0.05, 0.2] or 0, and `end_radius` a quarter of `radius` or more.
    across : int
        Cells along each side of the square in the middle of the cross-section; the skin has four times as many around.
    shape : {"tetrahedron", "hexahedron"}
        Of the cells; a hexahedron makes six tetrahedra.
    """

    summary: ClassVar[str] = "3D muscle, a belly between two tendons, round or flattened"

    length: float = number(0.1, unit="m", within="(0, inf)", doc="from end to end")
    radius: float = number(0.015, unit="m", within="(0, inf)", doc="half axis along y at the belly")
    end_radius: float = number(0.006, unit="m", within="(0, inf)", doc="half axis along y at the ends")
    flatness: float = number(1.0, within="(0, inf)", doc="half axis along z by that along y")
    tendon: float = number(0.1, within="[0, 0.5)", doc="share of the length that the tendon at each end takes")
    cells: int | None = integer(
        None, within="[2, inf)", doc="cells along the length; by default half as long again as wide"
    )
    across: int = integer(
        2, within="[2, inf)", doc="cells across the middle square; the skin has 4 times as many around"
    )
    shape: str = choice("tetrahedron", ("tetrahedron", "hexahedron"), doc="of the cells")

    def __attrs_post_init__(self) -> None:
        if self.end_radius > self.radius:
            raise ParameterError("end_radius", f"is {self.end_radius!r}; expected a number in (0, {self.radius}] [m]")

    def mesh(self) -> Mesh:
        outline = Outline(self.radius, self.end_radius, self.tendon)
        rod: Any = extruded(*disc(self.across), outline.levels(self.cells or self._cells(outline)), self.shape)
        s, y, z = rod.p
        radius = outline.at(s)
        mesh = moved(rod, np.stack([self.length * s, radius * y, self.flatness * radius * z]))
        outer = rod.boundary_facets()
        ends = s[rod.facets[:, outer]]
        left, right = (ends == 0.0).all(axis=0), (ends == 1.0).all(axis=0)
        mesh = mesh.with_boundaries({"left": outer[left], "right": outer[right], "skin": outer[~left & ~right]})
        mesh = mesh.with_subdomains(outline.parts(s[rod.t].mean(axis=0)))
        check_mesh(mesh, "cells")
        return mesh

    def _cells(self, outline: Outline) -> int:
        width = INNER * math.sqrt(2.0) / self.across  # of a cell in the middle, in radii
        return max(math.ceil(self.length * outline.slenderness / (1.5 * width * math.sqrt(min(self.flatness, 1.0)))), 2)


@hookimpl
def myobridge_meshes():
    return {"fusiform": Fusiform}
