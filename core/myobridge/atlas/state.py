"""Constraint, momenta and pressure of a solid in motion."""

from __future__ import annotations

from typing import Any, ClassVar, final

import numpy as np

from myobridge.atlas.quantities import RunGauge
from myobridge.interfaces import Array, StepReport
from myobridge.simulation import Simulation

__all__ = ["AngularMomentumDrift", "ConstraintError", "MomentumDrift", "PressureNoise", "VolumeError"]


@final
class ConstraintError(RunGauge):
    """Largest norm of the constraint's residual, relative to the volumes that cancel in it."""

    words: ClassVar[str] = "constraint error"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        return simulation.motion.multiplier.size > 0

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        found = simulation.solid.balance(simulation.motion, None, simulation.time, rate=False)
        if found.constraint is None:
            return
        error = float(np.linalg.norm(found.constraint)) / (found.constraint_magnitude or 1.0)
        self.largest = float(np.maximum(self.largest, error))

    def value(self, fine: Any = None) -> float:
        return self.largest


@final
class VolumeError(RunGauge):
    """Largest change of volume of a cell, ``|J - 1|``."""

    words: ClassVar[str] = "change of volume"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        return simulation.solid.visible_mesh() is not None

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.largest = 0.0

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        fields = simulation.solid.visible_fields(simulation.motion, simulation.time)
        error = float(np.abs(fields["J"] - 1.0).max()) if "J" in fields else 0.0
        self.largest = float(np.maximum(self.largest, error))

    def value(self, fine: Any = None) -> float:
        return self.largest


class _Kept(RunGauge):
    """Largest change of a vector that should be conserved, relative to its size at the start."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.first = self.read(simulation)
        self.largest = 0.0

    def read(self, simulation: Simulation) -> Array:
        raise NotImplementedError

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        moved = float(np.linalg.norm(self.read(simulation) - self.first))
        self.largest = float(np.maximum(self.largest, moved))

    def value(self, fine: Any = None) -> float:
        return self.largest / (float(np.linalg.norm(self.first)) or 1.0)


@final
class MomentumDrift(_Kept):
    """Of the linear momentum."""

    words: ClassVar[str] = "change of momentum"

    def read(self, simulation: Simulation) -> Array:
        return np.asarray(simulation.solid.momentum(simulation.motion))


@final
class AngularMomentumDrift(_Kept):
    """Of the angular momentum about the origin."""

    words: ClassVar[str] = "change of angular momentum"

    def read(self, simulation: Simulation) -> Array:
        return np.asarray(simulation.solid.angular_momentum(simulation.motion))


@final
class PressureNoise(RunGauge):
    r"""What alternates in the multiplier from step to step: root mean square of a quarter of its second difference.

    .. math:: \tfrac14\,(p_{n+1} - 2 p_n + p_{n-1})

    over all multipliers and all steps but the first tenth. A multiplier that jumps by plus and minus `a` has noise `a`.
    """

    words: ClassVar[str] = "pressure noise"
    unit: ClassVar[str] = "Pa"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        return simulation.motion.multiplier.size > 0

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.rows: list[Array] = []
        self.squares: list[float] = []

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        self.rows = [*self.rows[-2:], simulation.motion.multiplier]
        if len(self.rows) == 3:
            older, old, new = self.rows
            self.squares.append(float(np.mean((0.25 * (new - 2.0 * old + older)) ** 2)))

    def value(self, fine: Any = None) -> float:
        kept = self.squares[len(self.squares) // 10 :]
        return float(np.sqrt(np.mean(kept))) if kept else float("nan")
