"""Quantities that the atlas measures: a gauge watches a run, or reads a path, and answers with one number."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from myobridge.interfaces import ContinuationPath, StepReport
from myobridge.simulation import Simulation
from myobridge.statics import Statics

__all__ = ["PathGauge", "RunGauge"]


class RunGauge(ABC):
    """Abstract watcher of a run through time; made before the first step.

    Class attributes
    ----------------
    words : str
        The quantity in words.
    unit : str
    """

    words: ClassVar[str] = ""
    unit: ClassVar[str] = "-"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        """Whether there is anything to measure."""
        return True

    def __init__(self, simulation: Simulation) -> None:
        self.start = simulation.time

    @abstractmethod
    def observe(self, simulation: Simulation, report: StepReport) -> None:
        """Look at the state after an accepted step."""

    @abstractmethod
    def value(self, fine: Any = None) -> float:
        """The number; `fine` is the same gauge after the reference run, where the case has one."""


class PathGauge(ABC):
    """Abstract reader of a path of equilibria."""

    words: ClassVar[str] = ""
    unit: ClassVar[str] = "-"

    @abstractmethod
    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        """The number; `fine` holds ``statics`` and ``path`` of the reference."""
