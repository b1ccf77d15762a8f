"""Laplace's equation between two boundaries of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.interfaces import Array

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["potential"]

# Where conjugate gradients with multigrid overtake the factorisation in 3D.
_LARGE = 20_000


def potential(mesh: Mesh, low: np.ndarray, high: np.ndarray, order: int, points: Array) -> Array:
    """Gradient [1/m] of the harmonic function that is 0 on the facets `low` and 1 on `high`.

    At local `points` (dim, n_points) of every cell; (dim, n_cells, n_points). NaN in a part of the mesh that touches
    neither.
    """
    import skfem
    from skfem.models.poisson import laplace

    elements: dict[tuple[int, int], Any] = {
        (3, 1): skfem.ElementTriP1,
        (3, 2): skfem.ElementTriP2,
        (4, 1): skfem.ElementQuad1,
        (4, 2): skfem.ElementQuad2,
        (-4, 1): skfem.ElementTetP1,
        (-4, 2): skfem.ElementTetP2,
        (8, 1): skfem.ElementHex1,
        (8, 2): skfem.ElementHex2,
    }
    nodes = mesh.t.shape[0]
    element = elements[-4 if nodes == 4 and mesh.dim() == 3 else nodes, order]()
    basis: Any = skfem.Basis(mesh, element)
    stiffness = laplace.assemble(basis)
    values = np.zeros(basis.N)
    fixed_high = basis.get_dofs(high).all()
    values[fixed_high] = 1.0
    fixed = np.union1d(basis.get_dofs(low).all(), fixed_high)
    floating = _floating(mesh, basis, fixed)
    free = np.setdiff1d(np.arange(basis.N), np.union1d(fixed, floating))
    inner = stiffness[free][:, free].tocsr()
    values[free] = _solved(inner, -stiffness[free] @ values)
    values[floating] = np.nan
    del basis  # its quadrature is not the one asked for, and takes most of the memory
    there: Any = skfem.Basis(mesh, element, quadrature=(points, np.ones(points.shape[1])))
    return np.asarray(there.interpolate(values).grad)


def _floating(mesh: Mesh, basis: Any, fixed: np.ndarray) -> np.ndarray:
    """Unknowns of the parts of the mesh in which nothing is given."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    dofs = basis.element_dofs
    first = np.broadcast_to(dofs[0], dofs.shape).ravel()
    graph: Any = coo_array((np.ones(first.size, dtype=np.int8), (first, dofs.ravel())), shape=(basis.N, basis.N))
    count, part = connected_components(graph, directed=False)
    held = np.zeros(count, dtype=bool)
    held[part[fixed]] = True
    return np.flatnonzero(~held[part])


def _solved(matrix: Any, load: Array) -> Array:
    if len(load) < _LARGE:
        from scipy.sparse.linalg import splu

        return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(load)
    import pyamg

    hierarchy: Any = pyamg.smoothed_aggregation_solver(matrix)
    return np.asarray(hierarchy.solve(load, tol=1e-13, accel="cg", maxiter=200))
