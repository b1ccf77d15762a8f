r"""What makes a mesh fit for computing: no cell is inverted, flat or loose, no node stands alone or twice.

.. math:: q = \min_c \frac{c_0\,\det(e_{c1}, \dots, e_{cd})}{|e_{c1}| \cdots |e_{cd}|}

over the corners c of a cell with the edges e that meet there: the scaled Jacobian, 1 for the regular triangle or
tetrahedron, square or cube (c_0 is 2/sqrt(3), sqrt(2), 1), 0 for a flat cell.

**What "inverted" means.** The numbering of a cell says nothing: half of the tetrahedra of a sound mesh may be
left-handed, scikit-fem sorts the nodes of triangles, and either is the same body. So two things are looked at that hold
in any numbering. Inside a quadrilateral or hexahedron the determinants at all corners must have one sign (for
quadrilaterals this is J of one sign everywhere; for hexahedra necessary, not sufficient). Between cells, the two that
share a facet must lie on its two sides; where they do not, the mesh is folded, and the smaller part, as cut out along
the folds, is inverted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.errors import ParameterError

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["check_mesh", "listed", "scaled_jacobian"]

KINDS = {"MeshTri1": "triangle", "MeshQuad1": "quadrilateral", "MeshTet1": "tetrahedron", "MeshHex1": "hexahedron"}

# Determinant of the unit edges at a corner of the regular cell.
_REGULAR = {"MeshTri1": math.sqrt(3.0) / 2.0, "MeshQuad1": 1.0, "MeshTet1": math.sqrt(0.5), "MeshHex1": 1.0}

# Flatter than this no stress can be trusted; thin layers of aspect ratio 1e5 are well above.
_FLAT = 1e-6

# Nodes nearer than this share of the size of the body are one node written twice.
_SAME = 1e-10


def scaled_jacobian(mesh: Mesh) -> np.ndarray:
    """Scaled Jacobian q of every cell, in [-1, 1], shape (n_cells,); at most 0: degenerate or partly inverted."""
    return _least(*_corners(mesh))


def check_mesh(mesh: Mesh, key: str) -> None:
    """Refuse a mesh that cannot be computed on.

    Looked at, in this order: kind of cell, finite coordinates, nodes without a cell, nodes at the same place, flat
    cells, inverted cells (see above), facets of more than two cells, folds, names of parts that point nowhere.

    Parameters
    ----------
    mesh : skfem.Mesh
        `MeshTri`, `MeshQuad`, `MeshTet` or `MeshHex` with straight edges [m].
    key : str
        Parameter that the mesh comes from, for the message.

    Raises
    ------
    ParameterError
        Naming up to five cells or nodes, counted from 0, and how many there are.
    """
    if type(mesh).__name__ not in KINDS:
        raise ParameterError(
            key, f"is a {type(mesh).__name__}; expected straight-sided cells: {', '.join(KINDS.values())}"
        )
    _check_nodes(mesh, key)
    volumes, angles = _corners(mesh)
    quality = _least(volumes, angles)
    inverted = (volumes.min(axis=1) < 0.0) & (volumes.max(axis=1) > 0.0)
    if not np.all(quality > _FLAT):
        flat = np.flatnonzero(~(quality > _FLAT) & ~inverted)
        if flat.size:
            raise ParameterError(key, f"{listed(flat, mesh.nelements, 'cell')} degenerate: without volume")
        raise ParameterError(
            key, f"{listed(np.flatnonzero(inverted), mesh.nelements, 'cell')} inverted: J changes sign inside"
        )
    facets: Any = mesh.t2f
    shared = np.bincount(facets.ravel())
    if shared.max() > 2:
        cells = np.flatnonzero((shared[facets] > 2).any(axis=0))
        raise ParameterError(key, f"{listed(cells, mesh.nelements, 'cell')} stacked: more than two share a facet")
    folded = _folded(mesh)
    if folded.size:
        raise ParameterError(
            key, f"{listed(folded, mesh.nelements, 'cell')} inverted: on the same side of a facet as the neighbour"
        )
    _check_parts(mesh, key)


def listed(numbers: np.ndarray, total: int, what: str) -> str:
    """Subject and verb of a sentence about some out of many: ``cells 3, 4, 8, 9, 11, ... (17 of 800) are``."""
    said = ", ".join(str(number) for number in numbers[:5].tolist()) + (", ..." if len(numbers) > 5 else "")
    return (
        f"{what} {said} (1 of {total}) is" if len(numbers) == 1 else f"{what}s {said} ({len(numbers)} of {total}) are"
    )


def _corners(mesh: Any) -> tuple[np.ndarray, np.ndarray]:
    """Determinants at each corner, of the edges [m^dim] and of the unit edges over the regular cell's: (n_cells, k)."""
    domain = mesh.elem.refdom
    place, dim = domain.p, domain.dim()
    edges = domain.facets if dim == 2 else domain.edges
    points = mesh.p[:, mesh.t]
    volumes, angles = [], []
    for corner in range(domain.nnodes):  # 3 to 8 corners, all cells at once
        others = [b if a == corner else a for a, b in edges if corner in (a, b)]
        if np.linalg.det(place[:, others] - place[:, [corner]]) < 0.0:
            others[:2] = others[1::-1]
        vectors = np.moveaxis(points[:, others] - points[:, [corner]], 2, 0)
        lengths = np.linalg.norm(vectors, axis=1)
        volume = np.linalg.det(vectors)
        product = lengths.prod(axis=1)
        volumes.append(volume)
        angles.append(np.divide(volume, product, out=np.zeros_like(volume), where=product > 0.0))
    return np.stack(volumes, axis=1), np.stack(angles, axis=1) / _REGULAR[type(mesh).__name__]


def _least(volumes: np.ndarray, angles: np.ndarray) -> np.ndarray:
    sign = np.where(volumes.sum(axis=1) < 0.0, -1.0, 1.0)
    return np.asarray(np.clip(sign[:, None] * angles, -1.0, 1.0).min(axis=1))


def _check_nodes(mesh: Any, key: str) -> None:
    from scipy.spatial import KDTree

    points = mesh.p.T
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise ParameterError(key, f"{listed(wrong, len(points), 'node')} not finite")
    if mesh.nelements == 0:
        raise ParameterError(key, "holds no cell")
    used = np.bincount(mesh.t.ravel(), minlength=len(points))
    if len(used) > len(points):
        raise ParameterError(key, f"its cells name node {len(used) - 1}, and there are {len(points)} nodes")
    if not used.all():
        lone = np.flatnonzero(used == 0)
        raise ParameterError(key, f"{listed(lone, len(points), 'node')} in no cell; remove what is not used")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    pairs = KDTree(points).query_pairs(_SAME * size, output_type="ndarray")
    if len(pairs):
        twice = np.unique(pairs)
        raise ParameterError(
            key,
            f"{listed(twice, len(points), 'node')} at the same place as another; merge them, or the body falls apart",
        )


def _folded(mesh: Any) -> np.ndarray:
    """Cells on the wrong side of a fold: all but the largest of the parts that folds cut out."""
    inner = np.flatnonzero(mesh.f2t[1] >= 0)
    corners = mesh.p[:, mesh.facets[:, inner]]  # (dim, nodes of a facet, n)
    if mesh.dim() == 2:
        along = corners[:, 1] - corners[:, 0]
        normal = np.stack([along[1], -along[0]])
    else:
        # Diagonals of a quadrilateral face, which need not be plane; two edges of a triangle.
        last = 3 if corners.shape[1] == 4 else 0
        first = corners[:, 2] - corners[:, 0]
        normal = np.cross(first, corners[:, 1] - corners[:, last], axis=0)
    centres = mesh.p[:, mesh.t].mean(axis=1)
    middle = corners.mean(axis=1)
    sides = [np.einsum("in,in->n", normal, centres[:, cells] - middle) for cells in mesh.f2t[:, inner]]
    fold = sides[0] * sides[1] >= 0.0
    if not fold.any():
        return np.empty(0, dtype=np.int64)
    return _beyond(mesh, inner[~fold], np.unique(mesh.f2t[:, inner[fold]]))


def _beyond(mesh: Any, sound: np.ndarray, at_folds: np.ndarray) -> np.ndarray:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(sound), dtype=np.int8)
    graph: Any = coo_array((ones, tuple(mesh.f2t[:, sound])), shape=(mesh.nelements,) * 2)
    _, part = connected_components(graph, directed=False)
    touched = np.unique(part[at_folds])
    largest = touched[np.argmax(np.bincount(part)[touched])]
    wrong = np.flatnonzero(np.isin(part, touched) & (part != largest))
    return wrong if wrong.size else at_folds  # a fold that ends inside the body cuts nothing out


def _check_parts(mesh: Mesh, key: str) -> None:
    for named, size, what in (
        (mesh.boundaries, mesh.nfacets, "boundary"),
        (mesh.subdomains, mesh.nelements, "subdomain"),
    ):
        for name, numbers in (named or {}).items():
            numbers = np.asarray(numbers)
            if numbers.size == 0:
                raise ParameterError(key, f"the {what} '{name}' is empty")
            if numbers.min() < 0 or numbers.max() >= size:
                raise ParameterError(key, f"the {what} '{name}' names number {numbers.max()}, and there are {size}")
