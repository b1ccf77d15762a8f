"""Fibre directions from a file."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Fibres
from myobridge.parameters import number, text

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Table"]


@final
@attrs.frozen
class Table(Fibres):
    r"""Directions measured or computed elsewhere: one a cell, or at places of their own.

    .. math:: N(X) = n_e / |n_e| \;\text{ in cell } e, \qquad \text{or} \qquad
              N(X) = n_k / |n_k|, \quad k = \arg\min_j |X - X_j|

    A text file has as many columns as the mesh has dimensions (one line a cell, in the order of the cells), or twice as
    many (place, then direction; each point takes the direction of the nearest place). Numbers are separated by blanks
    or commas; what follows ``#`` is skipped. An ``.npz`` file holds ``directions`` and perhaps ``positions``.

    Parameters
    ----------
    file : str
        Path of the file; in a scene, relative to the scene's file.
    scale : float
        Unit of the places [m]: 1e-3 for a file in millimetres.

    Raises
    ------
    ParameterError
        If the file is missing, is no table of finite numbers, has another number of rows or columns than the mesh asks
        for, or a direction of no length.
    """

    summary: ClassVar[str] = "directions from a file, one a cell or those of the nearest place"

    file: str = text(doc="text or .npz file: directions of the cells, or places and directions", kind="file")
    scale: float = number(1.0, unit="m", within="(0, inf)", doc="unit of the places, 1e-3 for millimetres")

    def __attrs_post_init__(self) -> None:
        _ = self._columns  # a broken file is reported when the scene is read

    @cached_property
    def _columns(self) -> Array:
        """Directions (n, dim), or places and directions (n, 2 dim)."""
        path = Path(self.file)
        if not path.is_file():
            others = [item.name for item in path.parent.glob("*.*")] if path.parent.is_dir() else []
            raise ParameterError("file", f"'{self.file}' does not exist. {nearest(path.name, others[:10])}")
        try:
            columns = _from_npz(path) if path.suffix == ".npz" else _from_text(path)
        except (ValueError, OSError, KeyError) as error:
            raise ParameterError("file", f"'{self.file}' is no table of numbers: {error}") from None
        if columns.ndim != 2 or columns.shape[1] not in (2, 3, 4, 6) or len(columns) == 0:
            raise ParameterError(
                "file",
                f"'{self.file}' has shape {columns.shape}; expected rows of 2 or 3 numbers, or with places 4 or 6",
            )
        wrong = np.flatnonzero(~np.isfinite(columns).all(axis=1))
        if wrong.size:
            raise ParameterError("file", f"'{self.file}': row {wrong[0]} (counted from 0) is not finite")
        return columns

    def directions(self, mesh: Mesh, points: Array) -> Array:
        columns, dim = self._columns, mesh.dim()
        if columns.shape[1] not in (dim, 2 * dim):
            raise ParameterError(
                "file",
                f"'{self.file}' has {columns.shape[1]} columns; the mesh has {dim} dimensions: {dim} or {2 * dim}",
            )
        given = columns[:, -dim:]
        lengths = np.linalg.norm(given, axis=1)
        if not lengths.all():
            row = int(np.flatnonzero(lengths == 0.0)[0])
            raise ParameterError("file", f"'{self.file}': row {row} (counted from 0) is a direction of no length")
        units = given / lengths[:, None]
        if columns.shape[1] == dim:
            if len(units) != mesh.nelements:
                raise ParameterError(
                    "file",
                    f"'{self.file}' has {len(units)} rows; the mesh has {mesh.nelements} cells, one row for each",
                )
            return np.repeat(units[:, None], points.shape[1], axis=1)
        from scipy.spatial import KDTree

        mapping: Any = mesh.mapping()
        places = np.moveaxis(mapping.F(points), 0, -1)
        return units[KDTree(self.scale * columns[:, :dim]).query(places)[1]]


def _from_npz(path: Path) -> Array:
    with np.load(path, allow_pickle=False) as arrays:
        if "directions" not in arrays:
            raise KeyError(f"it holds no 'directions', but {', '.join(arrays) or 'nothing'}")
        parts = [arrays[name] for name in ("positions", "directions") if name in arrays]
        return np.hstack(parts).astype(np.float64)


def _from_text(path: Path) -> Array:
    lines = path.read_text(encoding="utf-8-sig").replace(",", " ").splitlines()
    if not any(line.partition("#")[0].strip() for line in lines):
        raise ValueError("it is empty")
    return np.loadtxt(lines, dtype=np.float64, ndmin=2)


@hookimpl
def myobridge_fibres():
    return {"table": Table}
