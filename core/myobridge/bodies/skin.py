r"""Skin: the faces of a body that can be seen, and their refinement into flat triangles.

.. math:: x(\xi) = \sum_k N_k(\xi)\,(X_k + u_k)

Faces of quadratic cells are curved: each is evaluated on a lattice of its reference coordinates with its own shape
functions, so that straight triangles follow the curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from myobridge.interfaces import Array, VisibleMesh

__all__ = ["Lattice", "Skin", "lattice", "nodal_means", "skin"]

# Faces of a cell in VTK's order of nodes, seen from outside: corners, middles of edges, middle of the face.
_FACES: Mapping[str, tuple[str, list[list[int]]]] = {
    "tetra": ("triangle", [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]),
    "tetra10": (
        "triangle6",
        [[0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9], [0, 2, 1, 6, 5, 4]],
    ),
    "hexahedron": (
        "quad",
        [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]],
    ),
    "hexahedron27": (
        "quad9",
        [
            [0, 4, 7, 3, 16, 15, 19, 11, 20],
            [1, 2, 6, 5, 9, 18, 13, 17, 21],
            [0, 1, 5, 4, 8, 17, 12, 16, 22],
            [3, 7, 6, 2, 19, 14, 18, 10, 23],
            [0, 3, 2, 1, 11, 10, 9, 8, 24],
            [4, 5, 6, 7, 12, 13, 14, 15, 25],
        ],
    ),
}


class Skin(NamedTuple):
    """Faces that belong to one cell only; of a flat body all its cells.

    `faces` is (n_faces, nodes of a face), `cells` (n_faces,) the cell of each, `kind` meshio's word for a face.
    """

    faces: np.ndarray
    cells: np.ndarray
    kind: str

    @property
    def corners(self) -> np.ndarray:
        """Corner nodes of each face."""
        return self.faces[:, : 3 if self.kind.startswith("triangle") else 4]

    def facing(self, points: Array, eye: Array) -> tuple[Skin, np.ndarray]:
        """The faces that look at an eye in direction `eye` (3,), their corners at `points`, and their numbers."""
        corners = points[self.corners]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        front = np.flatnonzero(normals @ eye > 0.0)
        return Skin(self.faces[front], self.cells[front], self.kind), front

    def border(self) -> np.ndarray:
        """Edges that belong to one face only, as (face, number of the edge in it); (n_edges, 2)."""
        corners = self.corners
        edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
        _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
        return np.stack(np.divmod(np.sort(first[count == 1]), corners.shape[1]), axis=1)

    def creases(self, points: Array, angle: float = 35.0) -> np.ndarray:
        """Edges at which the normals of the two faces differ by more than `angle` degrees; as `border`."""
        corners = self.corners
        place = points[corners]
        normals = np.cross(place[:, 1] - place[:, 0], place[:, 2] - place[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        edges = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
        order = np.lexsort(edges.T[::-1])
        pair = np.flatnonzero(np.all(edges[order][:-1] == edges[order][1:], axis=1))
        one, other = order[pair], order[pair + 1]
        width = corners.shape[1]
        bent = np.sum(normals[one // width] * normals[other // width], axis=1) < np.cos(np.radians(angle))
        return np.stack(np.divmod(one[bent], width), axis=1)


def skin(mesh: VisibleMesh) -> Skin:
    """Faces of a body that can be seen."""
    cells = np.asarray(mesh.cells)
    if mesh.kind not in _FACES:
        return Skin(cells, np.arange(len(cells)), mesh.kind)
    kind, local = _FACES[mesh.kind]
    faces = cells[:, local].reshape(-1, len(local[0]))
    owner = np.repeat(np.arange(len(cells)), len(local))
    corners = np.sort(faces[:, : 3 if kind.startswith("triangle") else 4], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    seen = np.sort(first[count == 1])
    return Skin(faces[seen], owner[seen], kind)


class Lattice(NamedTuple):
    """Refinement of a reference face: shape functions (m, nodes), triangles (t, 3), edges (3 or 4, n + 1) of points."""

    shape: Array
    triangles: np.ndarray
    edges: np.ndarray


@lru_cache(maxsize=32)
def lattice(kind: str, n: int) -> Lattice:
    """Lattice of `n` intervals an edge on the reference face of `kind`."""
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    low, right, up, both = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    lower = np.stack([low, right, up], axis=-1).reshape(-1, 3)
    upper = np.stack([right, both, up], axis=-1).reshape(-1, 3)
    if kind.startswith("quad"):
        shape = _quad_shape(kind, i / n, j / n)
        edges = np.stack([number[:, 0], number[-1, :], number[::-1, -1], number[0, ::-1]])
        return Lattice(shape, np.concatenate([lower, upper]), edges)
    inside = i + j <= n
    renumbered = np.cumsum(inside) - 1
    triangles = np.concatenate([lower, upper])
    triangles = renumbered[triangles[np.all(inside[triangles], axis=1)]]
    along = np.arange(n + 1)
    edges = renumbered[np.stack([number[:, 0], number[n - along, along], number[0, ::-1]])]
    return Lattice(_triangle_shape(kind, i[inside] / n, j[inside] / n), triangles, edges)


def _triangle_shape(kind: str, x: Array, y: Array) -> Array:
    w = 1.0 - x - y
    if kind == "triangle":
        return np.stack([w, x, y], axis=1)
    return np.stack([w * (2 * w - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * w * x, 4 * x * y, 4 * y * w], axis=1)


def _quad_shape(kind: str, x: Array, y: Array) -> Array:
    if kind == "quad":
        return np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)

    def along(s: Array) -> tuple[Array, Array, Array]:
        return (1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)

    (a0, am, a1), (b0, bm, b1) = along(x), along(y)
    return np.stack([a0 * b0, a1 * b0, a1 * b1, a0 * b1, am * b0, a1 * bm, am * b1, a0 * bm, am * bm], axis=1)


def nodal_means(mesh: VisibleMesh, values: Array) -> Array:
    """Mean at each node of the `values` (n_cells,) of the cells around it; NaN where all of them are."""
    cells = np.asarray(mesh.cells)
    there = np.isfinite(values)
    nodes = cells[there].ravel()
    total = np.bincount(nodes, np.repeat(values[there], cells.shape[1]), minlength=len(mesh.points))
    count = np.bincount(nodes, minlength=len(mesh.points))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
