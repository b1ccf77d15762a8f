"""Named parts of a mesh file: sets, physical groups and tags become subdomains and boundaries."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge_plugins.mesh.reading import Content

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["named_parts"]

# Arrays of whole numbers by which file formats number their regions.
_TAGS = ("gmsh:physical", "medit:ref", "avsucd:material", "flac3d:group", "cell_tags")

Parts = dict[str, np.ndarray]


def named_parts(content: Content, mesh: Mesh, tags: str) -> tuple[Parts, Parts]:
    """Boundaries (facets) and subdomains (cells) of `mesh`, which was made from `content`.

    Sets of cells and facets keep their names. Tags are named by the file (physical groups), else by their number; 0
    means none. A set of nodes names the facets of the outside whose corners it holds all.

    Raises
    ------
    ParameterError
        If the array `tags` is not in the file or holds no whole numbers, or a named facet belongs to no cell.
    """
    boundaries: Parts = {}
    subdomains: Parts = {}
    facets = _by_nodes(mesh)
    for name, blocks in [*_tagged(content, tags), *_sets(content)]:
        inside = [start + part for start, part in zip(content.starts, blocks, strict=True) if start >= 0 and part.size]
        beside = [corners[part] for corners, part in zip(content.facets, blocks, strict=True) if len(corners)]
        beside = [part for part in beside if len(part)]
        if inside:
            subdomains[name] = np.union1d(subdomains.get(name, []), np.concatenate(inside)).astype(np.int64)
        if beside:
            found = facets(name, np.vstack(beside))
            boundaries[name] = np.union1d(boundaries.get(name, []), found).astype(np.int64)
    for name, nodes in (content.raw.point_sets or {}).items():
        held = _outer(mesh, content.kept[np.asarray(nodes, dtype=np.int64)])
        if held.size and name not in boundaries:
            boundaries[name] = held
    return boundaries, subdomains


def _sets(content: Content) -> list[tuple[str, list[np.ndarray]]]:
    empty = np.empty(0, dtype=np.int64)
    return [
        (name, [empty if part is None else np.asarray(part, dtype=np.int64) for part in parts])
        for name, parts in (content.raw.cell_sets or {}).items()
        if not name.startswith("gmsh:")
    ]


def _tagged(content: Content, tags: str) -> list[tuple[str, list[np.ndarray]]]:
    arrays = content.raw.cell_data
    if tags and tags not in arrays:
        raise ParameterError("tags", f"the file holds no '{tags}' of its cells. {nearest(tags, arrays)}")
    name = tags or next((item for item in _TAGS if item in arrays), "")
    if not name:
        return []
    values = [np.asarray(item) for item in arrays[name]]
    if any(item.ndim != 1 or not np.array_equal(item, np.round(item)) for item in values):
        raise ParameterError("tags", f"'{name}' holds no whole numbers, one a cell")
    names: dict[tuple[int, int], str] = {}
    for said, pair in (content.raw.field_data or {}).items():
        if np.size(pair) == 2:
            names[int(pair[0]), int(pair[1])] = said
    found: list[tuple[str, list[np.ndarray]]] = []
    dims = [block.dim for block in content.raw.cells]
    for dim in sorted(set(dims)):
        numbers = np.unique(np.concatenate([item for item, of in zip(values, dims, strict=True) if of == dim]))
        for number in numbers[numbers != 0].astype(int).tolist():
            here = [np.flatnonzero((item == number) & (of == dim)) for item, of in zip(values, dims, strict=True)]
            found.append((names.get((number, dim), str(number)), here))
    return found


def _by_nodes(mesh: Any) -> Any:
    """Function that finds the facets of the mesh with given corners."""
    own = np.sort(mesh.facets, axis=0).T

    def find(name: str, corners: np.ndarray) -> np.ndarray:
        both, inverse = np.unique(np.vstack([own, np.sort(corners, axis=1)]), axis=0, return_inverse=True)
        number = np.full(len(both), -1)
        number[inverse.ravel()[: len(own)]] = np.arange(len(own))
        found = number[inverse.ravel()[len(own) :]]
        if (found < 0).any():
            raise ParameterError(
                "file", f"{(found < 0).sum()} of {len(found)} facets of '{name}' are no facets of its cells"
            )
        return found

    return find


def _outer(mesh: Any, nodes: np.ndarray) -> np.ndarray:
    """Facets of the outside all of whose corners are among `nodes`."""
    outer = mesh.boundary_facets()
    return outer[np.isin(mesh.facets[:, outer], nodes).all(axis=0)]
