"""Cells between copies of a plane mesh: hexahedra or tetrahedra from quadrilaterals and levels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from myobridge.interfaces import Array

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["extruded"]


def extruded(points: Array, quads: np.ndarray, levels: Array, shape: str) -> Mesh:
    """Mesh with nodes at (level, y, z), level by level, from plane `points` (2, n) and `quads` (4, k).

    A tetrahedron is a third of the prism over half a quadrilateral. All prisms are cut in the order of the numbers of
    their plane nodes, so that neighbours agree on the diagonal of the face between them.
    """
    import skfem

    size = points.shape[1]
    place = np.vstack([np.repeat(levels, size), np.tile(points, len(levels))])
    lower = size * np.arange(len(levels) - 1)
    if shape == "hexahedron":
        a, b, c, d = quads
        # scikit-fem's corners: 1, 2 and 3 are the neighbours of 0; 4, 5, 6 lie across a face, 7 across the cell.
        plane = np.stack([a, b, d, a + size, c, b + size, d + size, c + size])
        return skfem.MeshHex(place, (plane[:, None, :] + lower[None, :, None]).reshape(8, -1))
    first, second = (np.linalg.norm(points[:, quads[i]] - points[:, quads[i + 2]], axis=0) for i in (0, 1))
    shorter = first <= (1.0 + 1e-9) * second  # the same choice for equal ones, whatever the rounding
    one = np.where(shorter, quads[[0, 1, 2]], quads[[0, 1, 3]])
    other = np.where(shorter, quads[[0, 2, 3]], quads[[1, 2, 3]])
    a, b, c = np.sort(np.hstack([one, other]), axis=0)
    plane = np.hstack([[a, b, c, c + size], [a, b, b + size, c + size], [a, a + size, b + size, c + size]])
    return skfem.MeshTet(place, (plane[:, None, :] + lower[None, :, None]).reshape(4, -1))
