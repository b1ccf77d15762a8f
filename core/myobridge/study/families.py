"""Families of a study: the lines of its plots, with the slope of error against time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from myobridge.study.result import StudyResult
from myobridge.study.rows import Row

__all__ = ["Family", "families"]


class Family(NamedTuple):
    """Rows of one line of the plot.

    Attributes
    ----------
    name : str
    rows : tuple of Row
        All with an error and a time, the cheapest first.
    front : tuple of Row
        Those that no other row of the family beats in both: the line is drawn through them.
    slope : float
        Exponent of error against CPU time along the front; NaN with fewer than three points.
    """

    name: str
    rows: tuple[Row, ...]
    front: tuple[Row, ...]
    slope: float

    @property
    def label(self) -> str:
        """Name and slope."""
        name = self.name or "as it is"
        return name if math.isnan(self.slope) else f"{name} (slope {self.slope:.1f})"


def families(result: StudyResult, error: str = "error") -> list[Family]:
    """Families of a study by the given kind of error, in the order of its variants."""
    found: list[Family] = []
    for name in dict.fromkeys(row.variant.family for row in result.rows):
        rows = tuple(row for row in result.measured if row.variant.family == name and _positive(getattr(row, error)))
        if rows:
            front = _front(rows, error)
            found.append(Family(name, rows, front, _slope(front, error)))
    return found


def _positive(error: float) -> bool:
    return math.isfinite(error) and error > 0.0  # zero has no place on a logarithmic axis


def _front(rows: Sequence[Row], error: str) -> tuple[Row, ...]:
    least, found = math.inf, list[Row]()
    for row in rows:
        if getattr(row, error) < least:
            least = getattr(row, error)
            found.append(row)
    return tuple(found)


def _slope(front: Sequence[Row], error: str) -> float:
    if len(front) < 3:
        return math.nan
    return float(np.polyfit(np.log([row.cpu for row in front]), np.log([getattr(row, error) for row in front]), 1)[0])
