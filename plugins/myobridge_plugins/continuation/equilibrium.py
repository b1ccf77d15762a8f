r"""What all strategies ask of a problem: the equilibrium at a level, the slope of the path, the length of a change.

.. math:: F(u, \ell) = 0, \qquad \frac{du}{d\ell} = -\Bigl(\frac{\partial F}{\partial u}\Bigr)^{-1}
          \frac{\partial F}{\partial \ell}, \qquad |\Delta u| = \Bigl(\sum_i w_i^2\,\Delta u_i^2\Bigr)^{1/2}
"""

from __future__ import annotations

import functools
from typing import final

import attrs
import numpy as np

from myobridge.interfaces import (
    Array,
    ContinuationProblem,
    LinearSystem,
    Matrix,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
    PathPoint,
    SystemSize,
)
from myobridge.solvers import SingularMatrix, UnsolvedSystem, absolute_product, method_for_size, solve
from myobridge_plugins.continuation.last_tangent import SMALL, LastTangent

__all__ = ["AtLevel", "accepted", "cancelling", "default_method", "equilibrium", "length", "slope"]


_TOLERANCE, _ITERATIONS = 1e-10, 20
# Tangents up to this size are dense and cheap.
_SMALL = 100


@final
class AtLevel(NewtonProblem):
    """Equilibrium at a fixed level, as Newton's methods see it."""

    def __init__(self, problem: ContinuationProblem, level: float) -> None:
        self._problem, self._level = problem, level

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        residual = self._problem.residual(unknowns, self._level)
        if unknowns.size > _SMALL:  # of large tangents Newton itself asks for what cancels, once it has one
            return residual, self._problem.magnitude(unknowns, self._level)
        tangent = self._problem.tangent(unknowns, self._level)
        return residual, cancelling(self._problem, tangent, unknowns, self._level)

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        return self._problem.tangent(unknowns, self._level)

    def admissible(self, unknowns: Array) -> bool:
        return self._problem.admissible(unknowns)


def default_method(n_unknowns: int, max_iterations: int = _ITERATIONS) -> NewtonMethod:
    """The method that suits systems of this size, to 1e-10."""
    method = method_for_size(SystemSize(n_unknowns, 3), path=True).method
    if not attrs.has(type(method)):
        return method
    wanted = {"tolerance": _TOLERANCE, "max_iterations": max_iterations}
    known = {field.name for field in attrs.fields(type(method))}
    return attrs.evolve(method, **{name: value for name, value in wanted.items() if name in known})


def equilibrium(
    problem: ContinuationProblem,
    guess: Array,
    level: float,
    method: NewtonMethod | None = None,
    last: LastTangent | None = None,
) -> NewtonResult:
    """Equilibrium at a fixed level, sought from `guess`; unless a method is given by one that suits the size.

    Where a last tangent is given the method begins with it, and leaves its own.
    """
    if not problem.admissible(guess):
        return NewtonResult(guess, False, 0, "the state to start from is not admissible")
    with np.errstate(all="ignore"):  # far off, a trial may overflow; Newton sees it and backtracks
        found = (method or default_method(guess.size)).solve(
            AtLevel(problem, level), guess, None if last is None else last.kept
        )
    if last is not None and found.converged:
        last.take(found.kept)
    return found


def cancelling(problem: ContinuationProblem, tangent: Matrix | LinearSystem, unknowns: Array, level: float) -> float:
    """Norm of what cancels in the residual: what the problem says, and the tangent times the unknowns."""
    return problem.magnitude(unknowns, level) + float(np.linalg.norm(absolute_product(tangent, unknowns)))


def slope(problem: ContinuationProblem, unknowns: Array, level: float, last: LastTangent | None = None) -> Array | None:
    """Change of the unknowns per unit of level along the path; None where the tangent is singular.

    With a last tangent, large ones are factored there.
    """
    try:
        tangent = problem.tangent(unknowns, level)
        if last is not None and unknowns.size > SMALL and isinstance(tangent, LinearSystem):
            change = last.slope(problem, unknowns, level, tangent)
        else:
            change = -solve(tangent, problem.level_derivative(unknowns, level))
    except (SingularMatrix, UnsolvedSystem):
        return None
    return change if np.all(np.isfinite(change)) else None


def length(problem: ContinuationProblem, change: Array) -> float:
    """Length of a change of the unknowns, in the problem's weights."""
    return float(np.linalg.norm(problem.weights() * change))


def accepted(
    problem: ContinuationProblem, unknowns: Array, level: float, iterations: int, last: LastTangent | None = None
) -> PathPoint:
    """The point of a path, with the verdict on its stability."""
    verdict = problem.negative_eigenvalues if last is None else functools.partial(last.verdict, problem)
    return PathPoint(unknowns, level, iterations, verdict(unknowns, level))
