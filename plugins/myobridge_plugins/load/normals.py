r"""Normals of a surface, reference and deformed.

.. math:: n\,da = x_{,0} \times x_{,1}\,d\xi \quad\text{(3D)}, \qquad n\,da = h\,(t_y, -t_x)\,d\xi,\; t = x_{,0}
          \quad\text{(2D, thickness h)}
"""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array, Surface

__all__ = ["area_slopes", "area_vectors", "unit_normals"]

# Alternating tensor, and the turn by -90 degrees.
_EPS = np.zeros((3, 3, 3))
_EPS[[0, 1, 2], [1, 2, 0], [2, 0, 1]] = 1.0
_EPS[[0, 2, 1], [2, 1, 0], [1, 0, 2]] = -1.0
_TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])


def _tangents(surface: Surface, positions: Array) -> Array:
    """Derivatives of the positions by the facet's coordinates, (n_facets, n_points, dim - 1, dim)."""
    return np.einsum("pad,fai->fpdi", surface.slopes, positions)


def area_vectors(surface: Surface, displacement: Array) -> Array:
    """Outward normal times deformed area [m^2] that each quadrature point stands for, (n_facets, n_points, dim)."""
    tangents = _tangents(surface, surface.positions + displacement)
    if surface.dimension == 2:
        normal = surface.thickness * tangents[:, :, 0] @ _TURN.T
    else:
        normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    return surface.weights[:, None] * normal


def area_slopes(surface: Surface, displacement: Array) -> Array:
    """Derivatives of `area_vectors` by the nodal displacements, (n_facets, n_points, dim, n_nodes, dim) [m]."""
    weighted = surface.weights[:, None, None] * surface.slopes
    if surface.dimension == 2:
        slopes = surface.thickness * np.einsum("pa,ij->piaj", weighted[:, :, 0], _TURN)
        return np.broadcast_to(slopes, (len(displacement), *slopes.shape))
    tangents = _tangents(surface, surface.positions + displacement)
    # eps[i, j, k] is the i-th component of e_j x e_k.
    return np.einsum("fpak,ijk->fpiaj", _cross_arms(weighted, tangents), _EPS)


def _cross_arms(weighted: Array, tangents: Array) -> Array:
    """N_a,0 x_,1 - N_a,1 x_,0: what the displacement of node a is crossed with."""
    return (
        weighted[None, :, :, 0, None] * tangents[:, :, None, 1]
        - weighted[None, :, :, 1, None] * tangents[:, :, None, 0]
    )


def unit_normals(surface: Surface) -> Array:
    """Outward unit normals in the reference, (n_facets, n_points, dim)."""
    vectors = area_vectors(surface, np.zeros_like(surface.positions))
    return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
