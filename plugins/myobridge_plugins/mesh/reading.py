"""Points and cells of a mesh file: what meshio read, brought to one kind of straight-sided cell."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge.interfaces import Array
from myobridge.mesh_check import listed

__all__ = ["Content", "read"]

# Corners of a cell, and the kind of straight-sided cell it is.
_STRAIGHT = {"triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}
_CURVED = {
    "triangle6": "triangle",
    "triangle7": "triangle",
    "quad8": "quad",
    "quad9": "quad",
    "tetra10": "tetra",
    "hexahedron20": "hexahedron",
    "hexahedron24": "hexahedron",
    "hexahedron27": "hexahedron",
}
_CORNERS = {**_STRAIGHT, "line": 2, "line3": 2, **{name: _STRAIGHT[kind] for name, kind in _CURVED.items()}}


@attrs.frozen(eq=False)
class Content:
    """Body in a file.

    Attributes
    ----------
    kind : str
        meshio's word for the cells: triangle, quad, tetra, hexahedron.
    points : ndarray, shape (n_nodes, dim)
        In the unit of the file.
    cells : ndarray, shape (n_cells, n_corners)
        Blocks of the file joined, in their order.
    facets : list of ndarray, shape (n, corners of a facet)
        Facets of each block of the file, in numbers of nodes; none for a block of other cells.
    starts : list of int
        First cell of each block of the file; -1 for a block of other cells.
    kept : ndarray, shape (nodes in the file,)
        New number of each node of the file, -1 where it was left out.
    raw : meshio.Mesh
    """

    kind: str
    points: Array
    cells: np.ndarray
    facets: list[np.ndarray]
    starts: list[int]
    kept: np.ndarray
    raw: Any


def read(path: Path, straighten: bool) -> Content:
    """Body in the file at `path`; with `straighten`, quadratic cells lose the nodes between their corners.

    Raises
    ------
    ParameterError
        If the file cannot be read, or holds mixed, unknown, quadratic (without `straighten`) or no cells, or a flat
        mesh that does not lie in z = 0.
    """
    raw = _read(path)
    top = max((block.dim for block in raw.cells), default=0)
    counts: dict[str, int] = {}
    for block in raw.cells:
        if block.dim == top:
            counts[block.type] = counts.get(block.type, 0) + len(block.data)
    said = ", ".join(f"{count} {name}" for name, count in counts.items()) or "nothing"
    if top < 2:
        raise ParameterError("file", f"'{path}' holds {said}; expected one of {', '.join(_STRAIGHT)}")
    unknown = [name for name in counts if name not in _STRAIGHT and name not in _CURVED]
    if unknown:
        raise ParameterError("file", f"'{path}' holds {said}; expected one of {', '.join(_STRAIGHT)}")
    if len({_CURVED.get(name, name) for name in counts}) > 1:
        raise ParameterError("file", f"'{path}' mixes cells: {said}; a mesh has cells of one kind")
    curved = [name for name in counts if name in _CURVED]
    if curved and not straighten:
        raise ParameterError(
            "file",
            f"'{path}' holds {said}; meshes have straight edges here: save it with first-order cells, or set "
            "straighten = true to keep the corners only (a curved outline becomes coarser)",
        )
    return _joined(raw, top, _CURVED.get(next(iter(counts)), next(iter(counts))), path)


def _read(path: Path) -> Any:
    import meshio

    if not path.is_file():
        others = [item.name for item in path.parent.glob("*.*")] if path.parent.is_dir() else []
        raise ParameterError("file", f"'{path}' does not exist. {nearest(path.name, others[:10])}")
    printed = io.StringIO()  # meshio prints what goes wrong, and ends the program
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = " ".join(printed.getvalue().split()) or f"{type(error).__name__}: {error}"
        raise ParameterError("file", f"'{path}' cannot be read by meshio: {reason}") from None


def _joined(raw: Any, top: int, kind: str, path: Path) -> Content:
    blocks: list[np.ndarray] = []
    facets: list[np.ndarray] = []
    starts: list[int] = []
    used = np.zeros(len(raw.points), dtype=bool)
    corners = np.zeros(len(raw.points), dtype=bool)
    total = 0
    for block in raw.cells:
        cut = np.asarray(block.data)[:, : _CORNERS[block.type]] if block.type in _CORNERS else np.empty((0, 1), int)
        inside, beside = block.dim == top, block.dim == top - 1
        starts.append(total if inside else -1)
        facets.append(cut if beside else np.empty((0, top), dtype=np.int64))
        if inside:
            if block.data.size and (block.data.min() < 0 or block.data.max() >= len(used)):
                raise ParameterError("file", f"'{path}' names node {block.data.max()} of {len(used)} in its cells")
            blocks.append(cut)
            total += len(cut)
            used[block.data] = True
            corners[cut] = True
    keep = corners | ~used  # not the nodes between corners; those of no cell are for the check to find
    numbers = np.where(keep, np.cumsum(keep) - 1, -1)
    points = _flat(np.asarray(raw.points, dtype=np.float64), top, path)[keep]
    cells = numbers[np.vstack(blocks)]
    return Content(kind, points, cells, [numbers[part] for part in facets], starts, numbers, raw)


def _flat(points: Array, top: int, path: Path) -> Array:
    """Coordinates of a body of dimension `top`."""
    if points.shape[1] < top:
        raise ParameterError(
            "file", f"'{path}' has points of {points.shape[1]} coordinates, and cells of {top} dimensions"
        )
    beyond = points[:, top:]
    size = float(np.max(np.ptp(points, axis=0), initial=0.0))
    wrong = np.flatnonzero((np.abs(beyond) > 1e-9 * size).any(axis=1))
    if wrong.size:
        raise ParameterError(
            "file",
            f"'{path}' holds flat cells that do not lie in z = 0: {listed(wrong, len(points), 'node')} off it, z from "
            f"{beyond.min():g} to {beyond.max():g}; a surface in space is no body; mesh its volume, or move it to 0",
        )
    return points[:, :top]
