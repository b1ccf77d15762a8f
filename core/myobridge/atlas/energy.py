r"""Energy that nobody supplied, what the ledger cannot explain, and how fast a motion grows.

.. math:: g(t) = E(t) - E(0) - (E_{attached} - E_{detached} + W_{active} + W_{external})

Viscosity and what the discretisation adds are in it: a method may lose energy, it must never make some.
"""

from __future__ import annotations

from typing import Any, ClassVar, final

import numpy as np

from myobridge.atlas.quantities import RunGauge
from myobridge.interfaces import StepReport
from myobridge.simulation import Simulation

__all__ = ["EnergyGrowth", "EnergyLoss", "GrowthRate", "LedgerDrift", "LedgerResidual"]


class _Unsupplied(RunGauge):
    """Follows g(t) and the energy it is measured by: that at the start and what was supplied at most."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.first = simulation.ledger.total
        self.scale = abs(self.first)
        self.lowest = self.growth = self.last = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        ledger = simulation.ledger
        gained = ledger.attached + ledger.active_work + ledger.external
        self.scale = max(self.scale, abs(self.first) + abs(ledger.attached) + abs(ledger.active_work + ledger.external))
        self.last = ledger.total - self.first - gained + ledger.detached
        self.lowest = min(self.lowest, self.last)
        self.growth = max(self.growth, self.last - self.lowest) if np.isfinite(self.last) else np.inf


@final
class EnergyGrowth(_Unsupplied):
    """Largest rise of g above any earlier value."""

    words: ClassVar[str] = "energy growth"

    def value(self, fine: Any = None) -> float:
        return self.growth / (self.scale or 1.0)


@final
class EnergyLoss(_Unsupplied):
    """How far g has fallen at the end."""

    words: ClassVar[str] = "energy loss"

    def value(self, fine: Any = None) -> float:
        return -self.last / (self.scale or 1.0)


@final
class LedgerResidual(RunGauge):
    """Largest imbalance of a step."""

    words: ClassVar[str] = "ledger residual"

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        self.largest = float(np.maximum(self.largest, abs(simulation.ledger.residual)))  # NaN stays

    def value(self, fine: Any = None) -> float:
        return self.largest


@final
class LedgerDrift(RunGauge):
    """Largest imbalance since the start."""

    words: ClassVar[str] = "ledger drift"

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        self.largest = float(np.maximum(self.largest, abs(simulation.ledger.drift)))

    def value(self, fine: Any = None) -> float:
        return self.largest


@final
class GrowthRate(RunGauge):
    """Rate of an amplitude that grows exponentially: half the slope of the logarithm of the energy.

    Fitted over the last third of the steps, in which the fastest mode has outgrown the others.
    """

    words: ClassVar[str] = "growth rate of the amplitude"
    unit: ClassVar[str] = "1/s"

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.rows: list[tuple[float, float]] = []

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        self.rows.append((simulation.time, simulation.ledger.total))

    def value(self, fine: Any = None) -> float:
        rows = np.array(self.rows)
        rows = rows[2 * len(rows) // 3 :]
        rows = rows[np.isfinite(rows[:, 1]) & (rows[:, 1] > 0.0)] if len(rows) else rows
        if len(rows) < 3:
            return float("nan")
        return 0.5 * float(np.polyfit(rows[:, 0] - rows[0, 0], np.log(rows[:, 1]), 1)[0])
