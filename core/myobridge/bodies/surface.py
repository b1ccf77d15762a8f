"""Surface: the skin of a body in one state, refined into triangles with values, and its edges as polylines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from myobridge.bodies.skin import Skin, lattice, nodal_means
from myobridge.interfaces import Array, VisibleMesh

__all__ = ["Surface", "intervals", "polylines", "surface"]


class Surface(NamedTuple):
    """Triangles of the faces of a skin.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray, shape (m, 3)
    values : ndarray, shape (n,) or, flat over each cell, (m,)
    blank : ndarray of bool, shape (m,)
        Triangles without a value (cells without sites).
    """

    points: Array
    triangles: np.ndarray
    values: Array
    blank: np.ndarray


def intervals(seen: Skin, most: int) -> int:
    """Intervals an edge that follow the curves with at most `most` triangles; straight faces need fewer."""
    halves = 1 if seen.kind.startswith("triangle") else 2
    wanted = 6 if seen.kind[-1].isdigit() else 2
    return int(np.clip(np.sqrt(most / (halves * max(len(seen.faces), 1))), 1, wanted))


def surface(
    mesh: VisibleMesh, seen: Skin, place: Array, values: Array, n: int, *, on_cells: bool, flat: bool
) -> Surface:
    """Skin `seen` of `mesh` with its nodes at `place`, refined `n` times.

    Parameters
    ----------
    place : ndarray, shape (n_points, 3)
        Where the nodes are [m].
    values : ndarray, shape (n_points,) or (n_cells,)
    on_cells : bool
        Which of the two.
    flat : bool
        One value a cell; else values on cells are averaged at the nodes.
    """
    shape, local, _ = lattice(seen.kind, n)
    points = np.einsum("lk,fkd->fld", shape, place[seen.faces])
    offsets = np.arange(len(seen.faces))[:, None, None] * len(shape)
    triangles = (local[None] + offsets).reshape(-1, 3)
    owner = np.repeat(seen.cells, len(local))
    if flat:
        of_cells = values if on_cells else values[np.asarray(mesh.cells)].mean(axis=1)
        painted = of_cells[owner]
        blank = ~np.isfinite(painted)
    else:
        nodal = nodal_means(mesh, values) if on_cells else values
        painted = np.einsum("lk,fk->fl", shape, nodal[seen.faces]).ravel()
        blank = ~np.all(np.isfinite(painted[triangles]), axis=1)
        if on_cells:
            blank |= ~np.isfinite(values[owner])
    return Surface(points.reshape(-1, 3), triangles, painted, blank)


def polylines(seen: Skin, place: Array, n: int, edges: np.ndarray | None = None) -> Array:
    """Edges of faces as curves, (n_edges, n + 1, 3): those of `edges` as (face, number of the edge), else all."""
    shape, _, local = lattice(seen.kind, n)
    if edges is None:
        edges = np.stack(np.divmod(np.arange(len(seen.faces) * len(local)), len(local)), axis=1)
    # Each edge on its own: the whole lattice of all faces is not needed for an outline.
    return np.einsum("elk,ekd->eld", shape[local[edges[:, 1]]], place[seen.faces[edges[:, 0]]])
