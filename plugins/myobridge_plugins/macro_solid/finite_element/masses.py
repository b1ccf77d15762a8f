r"""Masses of a body: consistent, or lumped onto the nodes.

.. math:: M_{ab} = \int \rho N_a N_b, \qquad
          m_a = \sum_e m_e \frac{\int_e N_a^2}{\sum_b \int_e N_b^2} \quad \text{(lumped)}

Lumping scales the diagonal of each cell to the cell's mass [1]_: every entry is positive, which sums of rows are not
for quadratic elements.

References
----------
.. [1] E. Hinton, T. Rock, O. C. Zienkiewicz, Earthq. Eng. Struct. Dyn. 4 (1976) 245-249.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from myobridge.interfaces import Array, Matrix
from myobridge_plugins.macro_solid.finite_element.body import Body

__all__ = ["CHOICES", "mass_matrix", "node_mass", "node_momentum"]

CHOICES = ("consistent", "lumped")


def node_mass(body: Body, density: float, kind: str) -> Any:
    """Mass over nodes [kg], what hangs on the boundary included: sparse, or a vector where it is lumped."""
    if kind == "consistent":
        return body.node_mass(density)
    found: Array = density * _lumped(body)
    hanging = body.loading.mass()
    if hanging is not None:
        diagonal = hanging.diagonal()
        found += diagonal * (hanging.sum() / diagonal.sum())
    return found


def _lumped(body: Body) -> Array:
    """Volumes of the cells, shared out among their nodes in proportion to the diagonal of the consistent mass."""
    grid = body.grid
    shares = np.zeros((grid.n_cells, grid.nodes.shape[1]))
    squares = grid.volumes[:, None] * grid.cell.values[grid.quadrature_of_point] ** 2
    np.add.at(shares, grid.cell_of_point, squares)
    volumes = np.bincount(grid.cell_of_point, weights=grid.volumes, minlength=grid.n_cells)
    shares *= (volumes / shares.sum(axis=1))[:, None]
    found = np.zeros(grid.n_nodes)
    np.add.at(found, grid.nodes.ravel(), shares.ravel())
    return found


def mass_matrix(body: Body, mass: Any) -> Matrix:
    """Mass of the free numbers: sparse, or a vector where it is lumped."""
    dimension = body.grid.dimension
    if isinstance(mass, np.ndarray):
        return np.repeat(mass, dimension)[body.free]
    import scipy.sparse as sparse

    whole = sparse.kron(mass, sparse.eye_array(dimension), format="csr")
    return sparse.csr_array(whole[body.free][:, body.free])


def node_momentum(body: Body, mass: Any, velocity: Array) -> Array:
    """Momentum of each node [kg m/s], (n_nodes, dim), of the free velocities; what is held counts as at rest."""
    full = np.zeros(body.n_full)
    full[body.free] = velocity
    nodal = full.reshape(-1, body.grid.dimension)
    return mass[:, None] * nodal if isinstance(mass, np.ndarray) else mass @ nodal
