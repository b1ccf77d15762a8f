"""Measured or computed values read from a CSV file."""

from __future__ import annotations

import csv
from functools import cached_property
from pathlib import Path
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Signal
from myobridge.parameters import text
from myobridge_plugins.signal.piecewise import interpolate, mean_over_pieces, slope

__all__ = ["Table"]


@final
@attrs.frozen
class Table(Signal):
    r"""Values from a CSV file, joined by lines.

    .. math:: s(t) = s_j + (s_{j+1} - s_j)\,\frac{t - t_j}{t_{j+1} - t_j}, \qquad t_j \le t < t_{j+1}

    First column: increasing times [s]. Every further column: values, one column for all sites or one for each.
    Cells are separated by commas; empty lines and lines that begin with ``#`` are skipped, and the first line may name
    the columns. Beyond both ends the end values hold.

    Parameters
    ----------
    file : str
        Path of the file; in a scene, relative to the scene's file.

    Raises
    ------
    ParameterError
        If the file is missing, a cell is no number, a line has too few cells or the times do not increase; the
        message names the line.
    """

    summary: ClassVar[str] = "values from a CSV file (columns: t, then one or one a site), joined by lines"

    file: str = text(doc="CSV file: times [s] in the first column, values in the others", kind="file")

    def __attrs_post_init__(self) -> None:
        _ = self._columns  # a broken file is reported when the scene is read, not in the middle of a run

    @cached_property
    def _columns(self) -> Array:
        path = Path(self.file)
        if not path.is_file():
            others = sorted(item.name for item in path.parent.glob("*.csv"))
            beside = f"Beside it: {', '.join(others[:10])}." if others else "There is no CSV file beside it."
            raise ParameterError("file", f"'{self.file}' does not exist. {beside}")
        rows: list[list[float]] = []
        named = False
        try:
            with path.open(newline="", encoding="utf-8-sig") as stream:
                reader = csv.reader(stream, skipinitialspace=True)
                for cells in reader:
                    if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                        continue
                    if not rows and not named and not any(_is_number(cell) for cell in cells):
                        named = True
                        continue
                    rows.append(self._row(cells, reader.line_num, rows))
        except (UnicodeDecodeError, csv.Error) as error:
            raise ParameterError("file", f"'{self.file}' is no text file of comma-separated values ({error})") from None
        if not rows:
            raise ParameterError("file", f"'{self.file}' holds no line of numbers; expected columns t, value(s)")
        return np.asarray(rows, dtype=np.float64)

    def _row(self, cells: list[str], line: int, rows: list[list[float]]) -> list[float]:
        where = f"'{self.file}', line {line}:"
        for column, cell in enumerate(cells, start=1):
            if not _is_number(cell):
                raise ParameterError("file", f"{where} column {column} is {cell.strip()!r}; expected a finite number")
        if len(cells) < 2:
            raise ParameterError("file", f"{where} one column only; expected a time [s] and at least one value")
        if rows and len(cells) != len(rows[0]):
            raise ParameterError("file", f"{where} {len(cells)} columns; expected {len(rows[0])} as in the lines above")
        row = [float(cell) for cell in cells]
        if rows and row[0] <= rows[-1][0]:
            raise ParameterError(
                "file", f"{where} time {row[0]} does not come after {rows[-1][0]}; times must increase"
            )
        return row

    @cached_property
    def _times(self) -> tuple[float, ...]:
        return tuple(self._columns[:, 0].tolist())

    @cached_property
    def _values(self) -> Array:
        values = self._columns[:, 1:]
        return np.ascontiguousarray(values[:, 0] if values.shape[1] == 1 else values)

    def value(self, time: float) -> Array:
        return interpolate(self._times, self._values, time)

    def mean(self, start: float, end: float) -> Array:
        return mean_over_pieces(self.value, self._times, start, end)

    def rate(self, time: float) -> Array:
        return slope(self._times, self._values, time)

    def jumps(self) -> tuple[float, ...]:
        return self._times


def _is_number(cell: str) -> bool:
    try:
        return bool(np.isfinite(float(cell)))
    except ValueError:
        return False


@hookimpl
def myobridge_signals():
    return {"table": Table}
