"""Result of a study: rows, Pareto front, recommendation; as table, files and pictures."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from myobridge.errors import MyobridgeError
from myobridge.study.reference import Standard
from myobridge.study.rows import Row

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["StudyResult"]


@attrs.frozen(eq=False)
class StudyResult:
    """What a study found.

    Attributes
    ----------
    study : Study
        With the quantities that were compared.
    rows : tuple of Row
        One a variant, in the order of the study.
    standards : mapping
        Checked solution of each model that has fine runs; `error` is what it is off itself.
    failures : mapping
        Why a model has none.
    computed, kept : int
        Runs computed now, and runs that were kept from before.
    cpu : float
        CPU seconds of the steps of the runs computed now.
    doubt : float
        What the solution that all errors are measured from is off itself; 0 for a closed form.
    """

    study: Study
    rows: tuple[Row, ...]
    standards: Mapping[str, Standard]
    failures: Mapping[str, str]
    computed: int = 0
    kept: int = 0
    cpu: float = 0.0
    doubt: float = 0.0

    @property
    def measured(self) -> tuple[Row, ...]:
        """Rows with an error and a time, the cheapest first."""
        return tuple(sorted((row for row in self.rows if row.measured), key=lambda row: row.cpu))

    def pareto(self) -> tuple[Row, ...]:
        """Rows that no other beats in both time and error, the cheapest first."""
        front: list[Row] = []
        least = math.inf
        for row in self.measured:
            if row.error < least:
                least = row.error
                front.append(row)
        return tuple(front)

    def recommend(self, tolerance: float | None = None) -> Row | None:
        """The cheapest variant that is good enough for `tolerance`, or that of the study; None where none is.

        Its error and what the reference may be off, which is not known to be on the same side, stay below it together.

        Raises
        ------
        MyobridgeError
            If there is no tolerance.
        """
        limit = self.study.tolerance if tolerance is None else tolerance
        if limit is None:
            raise MyobridgeError("tolerance: is not given, neither here nor in the study")
        return next((row for row in self.measured if row.error + self.doubt <= limit), None)

    def table(self) -> list[dict[str, Any]]:
        """Tidy table: a flat mapping for every row, with the same keys in all."""
        lines = [row.as_data() for row in self.rows]
        keys = list(dict.fromkeys(key for line in lines for key in line))
        return [{key: line.get(key) for key in keys} for line in lines]

    def frame(self) -> Any:
        """The table as a pandas frame.

        Raises
        ------
        MyobridgeError
            If pandas is not installed; `table` gives the same without.
        """
        try:
            import pandas  # pyright: ignore[reportMissingImports]
        except ImportError:
            raise MyobridgeError("pandas is not installed; StudyResult.table() gives the same as plain data") from None
        return pandas.DataFrame(self.table())

    def reference_errors(self) -> Mapping[str, float]:
        """Estimated error of the solution of each model itself."""
        return {model: found.error for model, found in self.standards.items()}

    def save(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write table, plots and report into a folder; returns the files.

        Raises
        ------
        MyobridgeError
            If they cannot be written.
        """
        from myobridge.study.plot import draw
        from myobridge.study.report import write_report

        place = Path(folder)
        try:
            place.mkdir(parents=True, exist_ok=True)
            data = place / "study.json"
            data.write_text(json.dumps(self.as_data(), indent=1, allow_nan=False), encoding="utf-8")
            return [data, *draw(self, place), write_report(self, place / "report.html")]
        except OSError as error:
            raise MyobridgeError(f"{error.filename or place}: cannot be written ({error.strerror})") from None

    def as_data(self) -> dict[str, Any]:
        """Plain data, for JSON: what is not a number is null there."""
        study = self.study
        best = None if study.tolerance is None else self.recommend()
        return {
            "study": study.title,
            "scene": study.scene_of({}).to_toml(),
            "quantities": [quantity.name for quantity in study.quantities],
            "norm": study.norm,
            "tolerance": study.tolerance,
            "reference_error": {model: _number(error) for model, error in self.reference_errors().items()},
            "recommended": None if best is None else best.command,
            "pareto": [row.label for row in self.pareto()],
            "rows": [{key: _number(value) for key, value in line.items()} for line in self.table()],
        }


def _number(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
