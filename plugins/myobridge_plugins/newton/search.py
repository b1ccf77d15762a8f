"""Where the iterations of a method are, where they were best, and how they went."""

from __future__ import annotations

import math
from typing import NamedTuple, final

from myobridge.interfaces import Array, NewtonProblem, NewtonStep
from myobridge.solvers import Goal, length_of, log_step
from myobridge.work import count

__all__ = ["Place", "Search"]


class Place(NamedTuple):
    """A point, its residual, the norm of that, and the norm of what cancels in it."""

    point: Array
    residual: Array
    size: float
    magnitude: float


@final
class Search:
    """Iterations from a start.

    Attributes
    ----------
    best : Place
        Of the smallest residual so far.
    goal : Goal
        When the residual is small enough.
    history : list of NewtonStep
    """

    def __init__(self, problem: NewtonProblem, start: Array, tolerance: float, backtracks: int) -> None:
        self.problem, self._backtracks = problem, backtracks
        self._here = self.best = self._at(start)
        self.goal = Goal(tolerance, self._here.size, self._here.magnitude)
        self.history: list[NewtonStep] = []

    def _at(self, point: Array) -> Place:
        residual, magnitude = self.problem.residual(point)
        return Place(point, residual, length_of(residual), magnitude)

    @property
    def point(self) -> Array:
        """Unknowns now."""
        return self._here.point

    @property
    def residual(self) -> Array:
        """Residual there."""
        return self._here.residual

    @property
    def size(self) -> float:
        """Its norm."""
        return self._here.size

    @property
    def converged(self) -> bool:
        """Whether the residual is small enough; before the first iteration: round-off of its own terms."""
        here = self._here
        return self.goal.reached(here.size, here.magnitude, len(self.history))

    def step(self, correction: Array) -> float:
        """Take a correction away, or half of it, and so on; the share that was admissible, 0 where none was."""
        fraction = 1.0
        for _ in range(self._backtracks):
            candidate = self.point - fraction * correction
            if self.problem.admissible(candidate):
                there = self._at(candidate)
                if math.isfinite(there.size):
                    self._here = there
                    if there.size < self.best.size:
                        self.best = there
                    return fraction
            fraction *= 0.5
        return 0.0

    def return_to_best(self) -> None:
        """Go back to where the residual was smallest."""
        self._here = self.best

    def go_to(self, point: Array) -> None:
        """Go on from another point, found elsewhere."""
        self._here = self._at(point)

    def note(self, step: NewtonStep) -> None:
        """Keep how an iteration went, count it and log it."""
        count("newton_iterations")
        count("inner_iterations", step.linear_iterations)
        self.history.append(step)
        log_step(len(self.history), step, self.size)
