"""Comparison with a fine run, and the amplification of errors from step to step."""

from __future__ import annotations

from typing import Any, ClassVar, final

import numpy as np

from myobridge.atlas.quantities import RunGauge
from myobridge.interfaces import StepReport
from myobridge.simulation import Simulation

__all__ = ["Amplification", "DisplacementError", "TensionError"]


class _Trace(RunGauge):
    """Rows of numbers over time, and their distance from those of a fine run."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.times = [simulation.time]
        self.rows = [self.read(simulation)]

    def read(self, simulation: Simulation) -> Any:
        raise NotImplementedError

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        self.times.append(simulation.time)
        self.rows.append(self.read(simulation))

    def value(self, fine: Any = None) -> float:
        if fine is None:
            return float("nan")
        times, mine, theirs = np.array(self.times[1:]), np.array(self.rows[1:]), np.array(fine.rows)
        mine, theirs = mine.reshape(len(mine), -1), theirs.reshape(len(theirs), -1)
        exact = np.column_stack([np.interp(times, fine.times, column) for column in theirs.T])
        scale = float(np.abs(theirs).max())
        return float(np.abs(mine - exact).max()) / (scale or 1.0)


@final
class TensionError(_Trace):
    """Largest distance of the mean tension from that of the fine run, relative to its largest value."""

    words: ClassVar[str] = "error of the force"

    @classmethod
    def applies(cls, simulation: Simulation) -> bool:
        return simulation.bus is not None

    def read(self, simulation: Simulation) -> float:
        assert simulation.bus is not None
        volumes = simulation.solid.site_volumes
        return float(np.dot(volumes, simulation.bus.tension) / volumes.sum())


@final
class DisplacementError(_Trace):
    """Largest distance of any displacement from that of the fine run, relative to the largest there."""

    words: ClassVar[str] = "error of the displacement"

    def read(self, simulation: Simulation) -> Any:
        return np.array(simulation.motion.displacement)


@final
class Amplification(RunGauge):
    """Factor by which a change of the displacement comes back in the next step, over the first steps.

    A load that moves on drops out as the change becomes large; the factor of the last of ten steps is the answer.
    """

    words: ClassVar[str] = "amplification of a step"

    FIRST: ClassVar[int] = 10

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.rows = [np.array(simulation.motion.displacement)]

    def observe(self, simulation: Simulation, report: StepReport) -> None:
        if len(self.rows) < self.FIRST:
            self.rows.append(np.array(simulation.motion.displacement))

    def value(self, fine: Any = None) -> float:
        if len(self.rows) < 4:
            return float("nan")
        older, old, new = (self.rows[k + 1] - self.rows[k] for k in (-4, -3, -2))
        before, after = old - older, new - old
        return float(np.dot(after, before) / (np.dot(before, before) or np.nan))
