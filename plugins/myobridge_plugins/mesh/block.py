"""A box in two or three dimensions, straight or bowed."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MeshSource
from myobridge.mesh_check import check_mesh
from myobridge.parameters import choice, number, numbers
from myobridge_plugins.mesh.grid import grid, moved

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Block"]

_SHAPES = {2: ("triangle", "quadrilateral"), 3: ("tetrahedron", "hexahedron")}


@final
@attrs.frozen
class Block(MeshSource):
    r"""Box, or a bar or arch whose centre line is half a sine wave.

    .. math:: X = o + (\xi_1, \dots, \xi_d + b \sin(\pi \xi_1 / L_1)), \qquad 0 \le \xi_i \le L_i

    The bow b moves the centre line along the last axis, towards the top: a small one is the imperfection of a column, a
    large one the rise of a shallow arch. The ends stay plane and where they are; area and volume do not change.

    Boundaries: left, right (low and high x); bottom, top (low and high y in 2D, z in 3D); front, back (low and high y
    in 3D). Subdomains: none.

    Parameters
    ----------
    size : sequence of float, shape (2,) or (3,)
        Edges of the box [m]; their number is the dimension.
    cells : sequence of int, same length
        Number of cells along each axis.
    shape : {"triangle", "quadrilateral", "tetrahedron", "hexahedron"}, optional
        Default: triangles or tetrahedra. A rectangle is cut into two triangles, a cuboid into six tetrahedra.
    origin : sequence of float, same length, optional
        Corner with the lowest coordinates [m].
    bow : float
        Displacement of the centre line at mid-length [m].

    Raises
    ------
    ParameterError
        If numbers of axes differ, cells are no whole numbers, or the shape is one of another dimension.
    """

    summary: ClassVar[str] = "box in 2D or 3D, straight or bowed (column, shallow arch)"

    size: tuple[float, ...] = numbers(unit="m", within="(0, inf)", doc="edges of the box; 2 or 3 of them")
    cells: tuple[float, ...] = numbers(within="[1, inf)", doc="number of cells along each axis")
    shape: str | None = choice(
        None, ("triangle", "quadrilateral", "tetrahedron", "hexahedron"), doc="of the cells; triangles or tetrahedra"
    )
    origin: tuple[float, ...] | None = numbers(None, unit="m", doc="corner with the lowest coordinates; 0 of each")
    bow: float = number(0.0, unit="m", doc="of the centre line at mid-length, towards the top, half a sine wave")

    def __attrs_post_init__(self) -> None:
        if not isinstance(self.size, tuple) or len(self.size) not in _SHAPES:
            raise ParameterError("size", f"is {self.size!r}; expected a list of 2 or 3 numbers [m]")
        dim = len(self.size)
        for key, item in (("cells", self.cells), ("origin", self.origin)):
            if item is not None and (not isinstance(item, tuple) or len(item) != dim):
                raise ParameterError(key, f"is {item!r}; expected {dim} numbers, one for each of size")
        for i, count in enumerate(self.cells):
            if count != int(count):
                raise ParameterError(f"cells[{i}]", f"is {count!r}; expected a whole number in [1, inf)")
        if self.shape is not None and self.shape not in _SHAPES[dim]:
            raise ParameterError(
                "shape", f"is '{self.shape}'; a box with {dim} edges has one of {', '.join(_SHAPES[dim])}"
            )

    def mesh(self) -> Mesh:
        shape = self.shape or _SHAPES[len(self.size)][0]
        levels = [np.linspace(0.0, length, int(count) + 1) for length, count in zip(self.size, self.cells, strict=True)]
        straight = grid(shape, levels)
        points = straight.p.copy()
        points[-1] += self.bow * np.sin(np.pi * points[0] / self.size[0])
        if self.origin is not None:
            points += np.array(self.origin)[:, None]
        mesh = moved(straight, points)
        check_mesh(mesh, "size")
        return mesh


@hookimpl
def myobridge_meshes():
    return {"block": Block}
