"""Structured meshes of a box, whose six (four) sides are named: what the other shapes are bent from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.interfaces import Array

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["SIDES", "grid", "moved"]

SIDES = {
    2: (("left", "right"), ("bottom", "top")),
    3: (("left", "right"), ("front", "back"), ("bottom", "top")),
}
"""Names of the low and the high side along x, y (and z)."""


def grid(shape: str, levels: Sequence[Array]) -> Mesh:
    """Mesh of the box whose cells end at increasing `levels` of x, y (and z), with its sides named as in `SIDES`.

    The diagonals of triangles run from the corners of the box to its middle: mirrored, as the body is, and no triangle
    has two edges on the boundary (where a quadratic displacement with clamped edges leaves it no freedom).
    """
    import skfem

    mesh: Any
    if shape == "triangle":
        mesh = _triangles(skfem.MeshQuad.init_tensor(*levels), [len(level) - 1 for level in levels])
    else:
        kind = {"quadrilateral": skfem.MeshQuad, "tetrahedron": skfem.MeshTet, "hexahedron": skfem.MeshHex}[shape]
        mesh = kind.init_tensor(*levels)
    sides: dict[str, Any] = {}
    outer = mesh.boundary_facets()
    for axis, names in enumerate(SIDES[len(levels)]):
        places = mesh.p[axis][mesh.facets[:, outer]]
        for name, level in zip(names, (levels[axis][0], levels[axis][-1]), strict=True):
            sides[name] = outer[(places == level).all(axis=0)]
    return mesh.with_boundaries(sides)


def moved(mesh: Mesh, points: Array) -> Mesh:
    """The same cells and names with the nodes at `points` (dim, n_nodes) [m]."""
    return replace(mesh, doflocs=np.ascontiguousarray(points))


def _triangles(quads: Mesh, counts: Sequence[int]) -> Mesh:
    import skfem

    middle = quads.p[:, quads.t].mean(axis=1)
    column, row = (np.unique(middle[axis], return_inverse=True)[1] for axis in (0, 1))
    # From lower left to upper right where that leads to the middle, the other diagonal elsewhere.
    rising = (2 * column < counts[0]) == (2 * row < counts[1])
    a, b, c, d = quads.t
    first = np.where(rising, [a, b, c], [a, b, d])
    second = np.where(rising, [a, c, d], [b, c, d])
    return skfem.MeshTri(quads.p, np.hstack([first, second]))
