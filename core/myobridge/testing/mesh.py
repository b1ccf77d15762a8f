"""Contract checks of a source of meshes and of a field of fibre directions."""

from __future__ import annotations

import functools
import pickle
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.interfaces import Fibres, MeshSource
from myobridge.mesh_check import check_mesh, scaled_jacobian

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["fibre_checks", "mesh_checks"]


def mesh_checks(source: MeshSource, least_quality: float = 0.0) -> list[Callable[[], None]]:
    """Checks that hold a source of meshes to its contract; call each.

    `least_quality` is the scaled Jacobian that every cell must exceed, see `myobridge.mesh_check`.
    """
    return [
        _bound(check_passes_the_check, source),
        _bound(check_cells_have_volume, source, least_quality),
        _bound(check_boundaries, source),
        _bound(check_subdomains, source),
        _bound(check_is_repeatable, source),
    ]


def fibre_checks(fibres: Fibres, mesh: Mesh) -> list[Callable[[], None]]:
    """Checks that hold a field of fibre directions on `mesh` to its contract; call each."""
    return [_bound(check_unit_vectors, fibres, mesh), _bound(check_points_are_alone, fibres, mesh)]


def _bound(check: Callable[..., None], *given: Any) -> Callable[[], None]:
    bound = functools.partial(check, *given)
    functools.update_wrapper(bound, check)
    return bound


def check_passes_the_check(source: MeshSource) -> None:
    """The mesh is one that can be computed on."""
    check_mesh(source.mesh(), "mesh")


def check_cells_have_volume(source: MeshSource, least_quality: float) -> None:
    """Every cell has volume, and the shape that was promised."""
    quality = scaled_jacobian(source.mesh())
    assert quality.min() > least_quality, f"cell {quality.argmin()} has the scaled Jacobian {quality.min()}"


def check_boundaries(source: MeshSource) -> None:
    """Named boundaries hold facets of the mesh, each once; boundaries that lie outside share none."""
    mesh: Any = source.mesh()
    outer = mesh.boundary_facets()
    for name, facets in (mesh.boundaries or {}).items():
        assert isinstance(name, str), f"{name!r} is no name"
        assert name, "a boundary has an empty name"
        assert len(facets) == len(np.unique(facets)) > 0, f"'{name}' is empty, or names a facet twice"
        assert 0 <= min(facets) <= max(facets) < mesh.nfacets, f"'{name}' names facets that do not exist"
        assert np.isin(facets, outer).all() or not np.isin(facets, outer).any(), (
            f"'{name}' is half outside, half inside"
        )


def check_subdomains(source: MeshSource) -> None:
    """Named subdomains hold cells of the mesh, each once."""
    mesh: Any = source.mesh()
    for name, cells in (mesh.subdomains or {}).items():
        assert name, "a subdomain has an empty name"
        assert len(cells) == len(np.unique(cells)) > 0, f"'{name}' is empty, or names a cell twice"
        assert 0 <= min(cells) <= max(cells) < mesh.nelements, f"'{name}' names cells that do not exist"


def check_is_repeatable(source: MeshSource) -> None:
    """Asked again, or after a copy through pickle, the source answers the same mesh."""
    first: Any = source.mesh()
    for again in (source.mesh(), pickle.loads(pickle.dumps(source)).mesh()):
        assert np.array_equal(first.p, again.p)
        assert np.array_equal(first.t, again.t)


def _points(mesh: Any, count: int) -> np.ndarray:
    """Random local coordinates inside the reference cell."""
    corners = mesh.elem.refdom.p
    return corners @ np.random.default_rng(0).dirichlet(np.ones(corners.shape[1]), count).T


def check_unit_vectors(fibres: Fibres, mesh: Mesh) -> None:
    """Directions have shape (n_cells, n_points, dim) and length 1."""
    points = _points(mesh, 5)
    found = fibres.directions(mesh, points)
    assert found.shape == (mesh.nelements, 5, mesh.dim()), f"shape {found.shape}"
    assert np.abs(np.linalg.norm(found, axis=2) - 1.0).max() < 1e-14 * 4


def check_points_are_alone(fibres: Fibres, mesh: Mesh) -> None:
    """What is answered at a point does not depend on the other points asked for."""
    points = _points(mesh, 4)
    together = fibres.directions(mesh, points)
    for k in range(points.shape[1]):
        alone = fibres.directions(mesh, points[:, [k]])[:, 0]
        assert np.abs(alone - together[:, k]).max() < 1e-13
