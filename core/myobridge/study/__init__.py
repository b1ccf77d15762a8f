"""Studies: what accuracy costs, measured: one scene, many variants, a reference that is itself checked."""

from myobridge.study.quantities import QUANTITIES, Quantity
from myobridge.study.reference import Reference
from myobridge.study.result import StudyResult
from myobridge.study.rows import Row
from myobridge.study.study import Study

__all__ = ["QUANTITIES", "Quantity", "Reference", "Row", "Study", "StudyResult"]
