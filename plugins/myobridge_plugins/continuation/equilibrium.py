r"""What all strategies ask of a problem: the equilibrium at a level, the slope of the path, the length of a change.

.. math:: F(u, \ell) = 0, \qquad \frac{du}{d\ell} = -\Bigl(\frac{\partial F}{\partial u}\Bigr)^{-1}
          \frac{\partial F}{\partial \ell}, \qquad |\Delta u| = \Bigl(\sum_i w_i^2\,\Delta u_i^2\Bigr)^{1/2}
"""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array, ContinuationProblem, LinearSystem, Matrix, PathPoint
from myobridge.solvers import NewtonResult, SingularMatrix, UnsolvedSystem, absolute_product, newton, solve

__all__ = ["accepted", "cancelling", "equilibrium", "length", "slope"]


def equilibrium(
    problem: ContinuationProblem, guess: Array, level: float, tolerance: float, max_iterations: int
) -> NewtonResult:
    """Equilibrium at a fixed level, sought from `guess` by Newton's method."""
    if not problem.admissible(guess):
        return NewtonResult(guess, False, 0, "the state to start from is not admissible")

    def evaluate(unknowns: Array) -> tuple[Array, Matrix | LinearSystem, float]:
        tangent = problem.tangent(unknowns, level)
        return problem.residual(unknowns, level), tangent, cancelling(problem, tangent, unknowns, level)

    with np.errstate(all="ignore"):  # far off, a trial may overflow; Newton sees it and backtracks
        return newton(
            evaluate, guess, admissible=problem.admissible, tolerance=tolerance, max_iterations=max_iterations
        )


def cancelling(problem: ContinuationProblem, tangent: Matrix | LinearSystem, unknowns: Array, level: float) -> float:
    """Norm of what cancels in the residual: what the problem says, and the tangent times the unknowns."""
    return problem.magnitude(unknowns, level) + float(np.linalg.norm(absolute_product(tangent, unknowns)))


def slope(problem: ContinuationProblem, unknowns: Array, level: float) -> Array | None:
    """Change of the unknowns per unit of level along the path; None where the tangent is singular."""
    try:
        change = -solve(problem.tangent(unknowns, level), problem.level_derivative(unknowns, level))
    except (SingularMatrix, UnsolvedSystem):
        return None
    return change if np.all(np.isfinite(change)) else None


def length(problem: ContinuationProblem, change: Array) -> float:
    """Length of a change of the unknowns, in the problem's weights."""
    return float(np.linalg.norm(problem.weights() * change))


def accepted(problem: ContinuationProblem, unknowns: Array, level: float, iterations: int) -> PathPoint:
    """The point of a path, with the verdict on its stability."""
    return PathPoint(unknowns, level, iterations, problem.negative_eigenvalues(unknowns, level))
