"""Equilibria of unknowns and level together: the system that arclength continuation solves at every step."""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.interfaces import Array, ContinuationProblem, LinearSystem, Matrix, NewtonProblem
from myobridge.solvers import bordered
from myobridge_plugins.continuation.equilibrium import AtLevel

__all__ = ["InPlane"]


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
