"""Stopwatch of a run: its first step, which loads kernels and factors the first tangent, and the steps after it."""

from __future__ import annotations

from time import perf_counter, process_time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from myobridge.simulation import Simulation

__all__ = ["Stopwatch"]


class Stopwatch:
    """Started when it is made, told of every step, stopped at the end.

    Attributes
    ----------
    wall : float
        Seconds by the clock, from the beginning to the end.
    first : float
        Of them, those until the first step was done; `wall` where there was no second step.
    steps : int
        Steps after the first.
    """

    def __init__(self) -> None:
        self.wall = self.first = 0.0
        self.steps = -1
        self._started = self._since = perf_counter(), process_time()
        self._phases: dict[str, float] = {}
        self._spent: dict[str, float] = {}
        self._later = 0.0, 0.0

    def stepped(self, simulation: Simulation) -> None:
        """A step is done."""
        self.steps += 1
        if self.steps == 0:
            self._since = perf_counter(), process_time()
            self._phases = dict(simulation.seconds)

    def stop(self, simulation: Simulation) -> None:
        """The run is over, or broke off."""
        now = perf_counter(), process_time()
        self.wall = now[0] - self._started[0]
        if self.steps < 1:
            self._since, self._phases = self._started, {}
        self.first = self._since[0] - self._started[0] if self.steps > 0 else self.wall
        self.steps = max(self.steps, 0)
        self._later = now[0] - self._since[0], now[1] - self._since[1]
        self._spent = {name: value - self._phases.get(name, 0.0) for name, value in simulation.seconds.items()}

    @property
    def a_step(self) -> float:
        """Seconds a step by the clock, after the first where there are more."""
        return self._later[0] / max(self.steps, 1)

    def phases(self) -> tuple[dict[str, float], float, float]:
        """Seconds a step of each phase after the first step; wall and CPU seconds of those steps together."""
        return {name: value / max(self.steps, 1) for name, value in self._spent.items()}, *self._later
