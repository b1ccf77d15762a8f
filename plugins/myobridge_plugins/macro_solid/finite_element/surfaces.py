"""Surfaces: the facets of a named boundary as loads see them, and the nodes they act on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from myobridge.interfaces import Array, Surface
from myobridge_plugins.macro_solid.finite_element.discretisation import Discretisation
from myobridge_plugins.macro_solid.finite_element.element_pairs import facet_nodes

__all__ = ["BoundaryPart", "boundary_part"]


class BoundaryPart(NamedTuple):
    """A surface and the numbers of its nodes, (n_facets, nodes of a facet)."""

    surface: Surface
    nodes: np.ndarray


def boundary_part(
    discretisation: Discretisation, facets: np.ndarray, name: str, thickness: float, degree: int
) -> BoundaryPart:
    """Facets of a mesh by number, their nodes ordered so that the normal points outwards."""
    from skfem.quadrature import get_quadrature

    mesh, dimension = discretisation.mesh, discretisation.dimension
    cells = mesh.f2t[0, facets]
    place = np.empty(discretisation.n_cells, dtype=np.int64)
    place[discretisation.order] = np.arange(discretisation.n_cells)
    local = np.argmax(mesh.t2f[:, cells] == facets, axis=0)
    element, forward, backward = facet_nodes(mesh, discretisation.cell.element)
    cell_nodes = discretisation.nodes[place[cells]]
    rows = np.arange(facets.size)[:, None]
    nodes = cell_nodes[rows, forward[local]]
    centres = discretisation.positions[cell_nodes].mean(axis=1)
    found = discretisation.positions[nodes]
    points, weights = get_quadrature(element, degree)
    shapes, slopes = _tables(element, points)
    outward = np.einsum("fx,fx->f", _normals(found, slopes[:1])[:, 0], found.mean(axis=1) - centres)
    nodes = np.where((outward > 0.0)[:, None], nodes, cell_nodes[rows, backward[local]])
    found = discretisation.positions[nodes]
    factor = thickness if dimension == 2 else 1.0
    areas = np.linalg.norm(_normals(found, slopes), axis=2) * weights * factor
    surface = Surface(name, found, shapes, slopes, np.ascontiguousarray(weights), areas, factor)
    return BoundaryPart(surface, nodes)


def _normals(positions: Array, slopes: Array) -> Array:
    """Normals times the ratio of areas, (n_facets, n_points, dim)."""
    tangents = np.einsum("fax,qam->fqxm", positions, slopes)
    if tangents.shape[2] == 2:
        return np.stack([tangents[:, :, 1, 0], -tangents[:, :, 0, 0]], axis=2)
    return np.cross(tangents[..., 0], tangents[..., 1])


def _tables(element: Any, points: Array) -> tuple[Array, Array]:
    found = [element.lbasis(points, a) for a in range(len(element.doflocs))]
    shapes = np.stack([np.broadcast_to(value, points.shape[1:]) for value, _ in found], axis=1)
    slopes = np.stack([np.asarray(slope).T for _, slope in found], axis=1)
    return np.ascontiguousarray(shapes), np.ascontiguousarray(slopes)
