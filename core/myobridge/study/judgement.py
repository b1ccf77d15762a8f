"""Judge: how far a variant is off, with the error of its discretisation and that of its model apart."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, final

import attrs

from myobridge.study.levels import Levels
from myobridge.study.measurement import Course, Measurement
from myobridge.study.reference import Standard, closed_form, distance, standard
from myobridge.study.rows import Row, priced
from myobridge.study.variants import Variant

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["Judge"]


@final
class Judge:
    """Compares courses with the standards of a study.

    Attributes
    ----------
    standards : dict
        Checked solution of each model that has fine runs.
    failures : dict
        Why a model has none.
    """

    def __init__(self, study: Study, levels: Levels) -> None:
        self._study, self._true_model = study, levels.reference_model
        self.standards: dict[str, Standard] = {}
        self.failures: dict[str, str] = {}

    def learn(self, model: str, levels: Sequence[Measurement]) -> Standard | None:
        """Make the standard of a model from its fine runs, from coarse to fine."""
        failed = next((one for one in levels if one.failure or one.course is None), None)
        if failed is not None:
            self.failures[model] = f"the reference failed: {failed.failure or 'it was stopped'}"
            return None
        self.standards[model] = standard([one.course for one in levels if one.course is not None], self._study.norm)
        return self.standards[model]

    @property
    def doubt(self) -> float:
        """What the solution that all errors are measured from is off itself; 0 for a closed form."""
        known = self.standards.get(self._true_model)
        return 0.0 if known is None else known.error

    def obstacle(self, variant: Variant) -> str:
        """Why a variant cannot be judged; empty where it can."""
        return self.failures.get(self._true_model) or self.failures.get(variant.model, "")

    def errors(self, variant: Variant, course: Course) -> Mapping[str, float]:
        """Errors of a variant, none of them less than what the standards themselves are off."""
        if self.obstacle(variant):
            return {}
        total = self._distance(course, self._true_model)
        if variant.model == self._true_model:
            return {"error": total, "discretisation_error": total, "model_error": 0.0}
        own = self._distance(course, variant.model)
        between = self._distance(self.standards[variant.model].course, self._true_model)
        return {"error": total, "discretisation_error": own, "model_error": between}

    def row(self, variant: Variant, measurements: Sequence[Measurement]) -> Row:
        """Row of a variant, with its errors where it has run to its end."""
        errors: Mapping[str, float] = {}
        first = measurements[0]
        if not first.failure and not first.stopped and first.course is not None:
            errors = self.errors(variant, first.course)
        row, obstacle = priced(variant, measurements, **errors), self.obstacle(variant)
        return attrs.evolve(row, reason=obstacle) if obstacle and not row.reason else row

    def _distance(self, course: Course, model: str) -> float:
        found = self._standard(model, course)
        off = distance(course, found.course, self._study.norm)
        return max(off, found.error) if math.isfinite(off) else math.inf

    def _standard(self, model: str, course: Course) -> Standard:
        """Standard of a model; a closed form is asked at the very times of the course."""
        given = self._study.reference.closed_form
        if model == self._true_model and given is not None:
            return closed_form(given, course.times, tuple(course.values))
        return self.standards[model]
