"""The tangent that a path factored last: it serves the slope, the verdict on stability, and the next state."""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.interfaces import Array, ContinuationProblem, Factorisation, KeptTangent, LinearSystem, NewtonMethod
from myobridge.solvers import UnsolvedSystem, choice_for, factorise

__all__ = ["SMALL", "LastTangent"]

SMALL = 300
"""Tangents up to this size are factored wherever they are wanted: it costs next to nothing."""

# Residual of a slope that iterations find: it is where a guess comes from.
_SLOPE = 1e-8


@final
class LastTangent:
    """Tangent with its factors, and the state that it is of.

    Parameters
    ----------
    method : NewtonMethod, optional
        Whose linear solver is taken where it names one.
    """

    def __init__(self, method: NewtonMethod | None = None) -> None:
        self._linear = getattr(method, "linear", None)
        self._at: tuple[Array, float] | None = None
        self.kept: KeptTangent | None = None

    def take(self, kept: KeptTangent | None) -> None:
        """Go on with what a solve handed on, if anything."""
        if kept is not None:
            self.kept, self._at = kept, None

    def solve(self, system: LinearSystem, right: Array) -> Array:
        """Solution with a tangent near the last one: with the factors that are there, or with new ones.

        Raises
        ------
        SingularMatrix, UnsolvedSystem
            If there is none.
        """
        if self.kept is not None and self.kept.factorisation is not None:
            try:
                return self.kept.factorisation.solve_near(system, right, _SLOPE)[0]
            except UnsolvedSystem:
                pass
        return self._factored(system).solve(right, _SLOPE)

    def slope(self, problem: ContinuationProblem, unknowns: Array, level: float, system: LinearSystem) -> Array:
        """Change of the unknowns with the level.

        Where the solver tells the inertia the tangent is factored here, once for slope, verdict and the next state.
        """
        right = -problem.level_derivative(unknowns, level)
        solver = self._linear or choice_for(system).solver
        if solver is None or not solver.tells_inertia:
            return self.solve(system, right)
        factors = self._factored(system)
        self._at = (unknowns, level)
        return factors.solve(right, _SLOPE)

    def verdict(self, problem: ContinuationProblem, unknowns: Array, level: float) -> int:
        """Negative eigenvalues beyond those of a stable state, by the factors of this state where there are some."""
        if self._at is not None and self._at[1] == level and self._at[0] is unknowns and self.kept is not None:
            return problem.negative_eigenvalues(unknowns, level, self.kept.factorisation)
        return problem.negative_eigenvalues(unknowns, level)

    def _factored(self, system: LinearSystem) -> Factorisation:
        self.kept = self._at = None
        factors = factorise(system, self._linear)
        self.kept = KeptTangent(system, factors, np.array([0.0, 0.0, np.inf]))
        return factors
