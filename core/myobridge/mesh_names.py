"""Named parts of a mesh: facets of a boundary, cells of a subdomain; a name that is not there is explained."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.errors import ParameterError, nearest

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["boundary_facets", "subdomain_cells"]


def boundary_facets(mesh: Mesh, name: str, key: str) -> np.ndarray:
    """Facets of ``mesh.boundaries[name]``, increasing; shape (n,), whole numbers.

    Parameters
    ----------
    mesh : skfem.Mesh
    name : str
        Name of the boundary.
    key : str
        Parameter that holds the name, for the message.

    Raises
    ------
    ParameterError
        If the mesh has no such boundary, or it holds no facet; it lists the names there are and the nearest one.
    """
    return _named(mesh.boundaries, name, key, "boundary", "boundaries", "facet")


def subdomain_cells(mesh: Mesh, name: str, key: str) -> np.ndarray:
    """Cells of ``mesh.subdomains[name]``, increasing; arguments and errors as for `boundary_facets`."""
    return _named(mesh.subdomains, name, key, "subdomain", "subdomains", "cell")


def _named(named: Mapping[str, Any] | None, name: str, key: str, one: str, many: str, what: str) -> np.ndarray:
    if not named:
        raise ParameterError(key, f"asks for the {one} '{name}', and the mesh has no named {many}")
    if name not in named:
        raise ParameterError(key, f"the mesh has no {one} '{name}'. {nearest(name, named)}")
    # A plain array: scikit-fem's oriented boundaries carry more than numbers of facets.
    found = np.unique(np.asarray(named[name], dtype=np.int64))
    if found.size == 0:
        raise ParameterError(key, f"the {one} '{name}' of the mesh holds no {what}")
    return found
