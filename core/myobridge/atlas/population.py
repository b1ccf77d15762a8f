"""Bounds and realizability of a population of cross-bridges."""

from __future__ import annotations

from typing import Any, ClassVar, final

import numpy as np

from myobridge.atlas.quantities import RunGauge
from myobridge.interfaces import StepReport
from myobridge.simulation import Simulation

__all__ = ["OutOfBounds", "Unrealizable"]


@final
class OutOfBounds(RunGauge):
    """How far the attached fraction leaves [0, 1], of a model that promises that it does not at small steps."""

    words: ClassVar[str] = "attached fraction out of [0, 1] by"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        bus = simulation.bus
        if bus is None or not bus.model.promises.bounds:  # the density of moments alone is drawn, not computed
            return False
        return bus.model.density(np.array(bus.population)) is not None

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        assert simulation.bus is not None
        found = simulation.bus.model.density(np.array(simulation.bus.population))
        assert found is not None
        fraction = found[1]
        beyond = max(-float(fraction.min()), float(fraction.max()) - 1.0)
        self.largest = float(np.maximum(self.largest, beyond))

    def value(self, fine: Any = None) -> float:
        return self.largest


@final
class Unrealizable(RunGauge):
    """How far the moments are from those of any population: negative Q0, or a negative variance."""

    words: ClassVar[str] = "moments unrealizable by"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        return simulation.bus is not None and simulation.bus.moments().shape[1] >= 3

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        assert simulation.bus is not None
        q0, q1, q2 = simulation.bus.moments()[:, :3].T
        product = q0 * q2
        variance = (q1**2 - product) / np.maximum(np.abs(product), 1e-30)
        # Below the round-off of one head in 1e15 there is no population whose variance could be told.
        variance = np.where(np.abs(q0) > 1e-15, variance, 0.0)
        worst = max(float(np.max(-q0)), float(np.max(variance)))
        self.largest = float(np.maximum(self.largest, worst))

    def value(self, fine: Any = None) -> float:
        return self.largest
