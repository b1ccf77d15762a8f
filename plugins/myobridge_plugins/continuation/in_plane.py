"""Equilibria of unknowns and level together: the system that arclength continuation solves at every step."""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.interfaces import Array, ContinuationProblem, LinearSystem, Matrix, NewtonProblem
from myobridge.solvers import SingularMatrix, bordered, solve
from myobridge_plugins.continuation.equilibrium import AtLevel
from myobridge_plugins.continuation.last_tangent import SMALL, LastTangent

__all__ = ["InPlane", "direction_at", "load_of"]


@final
class InPlane(NewtonProblem):
    """Equilibrium of unknowns and level together, in the plane through `guess` with normal `row`."""

    def __init__(self, problem: ContinuationProblem, guess: Array, row: Array) -> None:
        self._problem, self._guess, self._row = problem, guess, row

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        residual, magnitude = AtLevel(self._problem, float(unknowns[-1])).residual(unknowns[:-1])
        return np.append(residual, self._row @ (unknowns - self._guess)), magnitude

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        inner, level = unknowns[:-1], float(unknowns[-1])
        column = self._problem.level_derivative(inner, level)
        return bordered(self._problem.tangent(inner, level), column, self._row[:-1], float(self._row[-1]))

    def admissible(self, unknowns: Array) -> bool:
        return self._problem.admissible(unknowns[:-1])


def load_of(problem: ContinuationProblem, point: Array) -> float:
    """Norm of the full load, 1 where that is 0.

    It brings the condition on the step to the unit of the residual, and its row to the size of the matrix, so that the
    dense row is not made a pivot before its turn.
    """
    return float(np.linalg.norm(problem.level_derivative(point[:-1], float(point[-1])))) or 1.0


def direction_at(problem: ContinuationProblem, point: Array, row: Array, last: LastTangent) -> Array:
    """Direction of the path at a point, on the positive side of `row`."""
    unknowns, level = point[:-1], float(point[-1])
    load = load_of(problem, point)
    column = problem.level_derivative(unknowns, level)
    tangent = bordered(problem.tangent(unknowns, level), column, load * row[:-1], load * float(row[-1]))
    right = np.zeros(point.size)
    right[-1] = load
    large = point.size > SMALL and isinstance(tangent, LinearSystem)
    found = last.solve(tangent, right) if large else solve(tangent, right)
    if not np.all(np.isfinite(found)):
        raise SingularMatrix
    return found
