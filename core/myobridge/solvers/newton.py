r"""Newton's method as all variants share it, and the ordinary one.

.. math:: F'(x_k)\,\delta_k = -F(x_k), \qquad x_{k+1} = x_k + \alpha_k\,\delta_k

The share :math:`\alpha` is halved (backtracking) while the new point is not admissible, its residual is not finite, or
it has grown out of all proportion.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    KeptTangent,
    LinearSolver,
    LinearSystem,
    Matrix,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
    NewtonStep,
)
from myobridge.parameters import integer, number, part
from myobridge.solvers.choice import factorise
from myobridge.solvers.linear import SingularMatrix, UnsolvedSystem, absolute_product, length_of, solve
from myobridge.work import count

__all__ = ["ROUND_OFF", "Correction", "Goal", "Ordinary", "is_round_off", "iterate", "log_step", "newton"]

_LOG = logging.getLogger("myobridge.newton")
ROUND_OFF = 16.0 * float(np.finfo(float).eps)
"""Share of the terms that cancel in a residual below which it is zero."""

# The relative residual of the linear systems, where the solver iterates: small enough that nobody sees the difference.
_LINEAR = 1e-8


@final
@attrs.frozen
class Goal:
    r"""When a residual is small enough.

    .. math:: \|F\| \le \max\bigl(\epsilon \min(\|F_0\|, \|T\|),\; 16\,\varepsilon\,\|T\|\bigr)

    with the tolerance :math:`\epsilon` and the terms `T` that cancel in the residual `F`. A bad guess in a tissue that
    stiffens exponentially has a residual of millions: to fall below that says little, so what counts then is the size
    of the terms where the iteration stands.

    Parameters
    ----------
    tolerance : float
        Factor by which the residual must fall.
    first, terms : float
        Norms of the residual and of its terms at the start. Terms smaller than the residual are not known.
    """

    tolerance: float
    first: float
    terms: float

    def size(self, terms: float) -> float:
        """Largest residual that is small enough where the terms have this norm."""
        known = self.terms >= self.first
        return max(self.tolerance * (min(self.first, terms) if known else self.first), ROUND_OFF * terms)

    def reached(self, size: float, terms: float, iterations: int) -> bool:
        """Whether a residual is small enough; at the start only one that is round-off of its own terms."""
        return size <= (self.size(terms) if iterations > 0 else ROUND_OFF * terms)


Correction = Callable[[Array, Array], tuple[Array, int, bool] | None]
"""From unknowns and residual: the correction, iterations of the linear solver, whether the tangent was new.

None where the residual is what round-off of the unknowns leaves (`is_round_off`): it cannot fall any further.
"""


def iterate(
    problem: NewtonProblem,
    start: Array,
    correction: Correction,
    *,
    tolerance: float,
    max_iterations: int,
    backtracks: int,
    growth: float,
) -> NewtonResult:
    """Iterations with a given way to find corrections: what all methods share.

    Parameters
    ----------
    correction : callable
        Raises `SingularMatrix` or `UnsolvedSystem` where it finds none.
    tolerance : float
        Converged when the residual has fallen by this factor (`Goal`), or when it, or a correction, is round-off.
    growth : float
        The residual may grow by this factor in one iteration; beyond it the step is halved.
    """
    unknowns = start
    residual, magnitude = problem.residual(unknowns)
    size = length_of(residual)
    first, goal = size, Goal(tolerance, size, magnitude)
    history: list[NewtonStep] = []
    for iteration in range(max_iterations):
        if not math.isfinite(size):
            return NewtonResult(unknowns, False, iteration, "the residual is not finite", tuple(history))
        if goal.reached(size, magnitude, iteration):
            return NewtonResult(unknowns, True, iteration, "", tuple(history))
        try:
            found = correction(unknowns, residual)
        except SingularMatrix:
            return NewtonResult(unknowns, False, iteration, "the tangent is singular", tuple(history))
        except UnsolvedSystem as error:
            reason = f"the linear system of iteration {iteration + 1} is not solved: {error}"
            return NewtonResult(unknowns, False, iteration, reason, tuple(history))
        if found is None:
            return NewtonResult(unknowns, True, iteration, "", tuple(history))
        change, inner, renewed = found
        fraction, before = 1.0, size
        for _ in range(backtracks):
            candidate = unknowns - fraction * change
            if problem.admissible(candidate):
                residual, magnitude = problem.residual(candidate)
                size = length_of(residual)
                if math.isfinite(size) and size <= growth * before:
                    break
            fraction *= 0.5
        else:
            reason = "no admissible point along Newton's direction"
            return NewtonResult(unknowns, False, iteration + 1, reason, tuple(history))
        history.append(NewtonStep(before, fraction, inner, renewed))
        count("newton_iterations")
        count("inner_iterations", inner)
        log_step(iteration + 1, history[-1], size)
        unknowns = candidate
        if fraction == 1.0 and renewed and length_of(change) <= ROUND_OFF * length_of(unknowns):
            return NewtonResult(unknowns, True, iteration + 1, "", tuple(history))
    converged = goal.reached(size, magnitude, max_iterations)
    reason = f"Newton did not converge in {max_iterations} iterations (residual {first:.2e} at first, {size:.2e} now)"
    return NewtonResult(unknowns, converged, max_iterations, "" if converged else reason, tuple(history))


@final
@attrs.frozen
class Ordinary(NewtonMethod):
    r"""Newton's method with a new tangent at every iteration (thesis [1]_, 1.5.1).

    .. math:: F'(x_k)\,\delta_k = -F(x_k), \qquad x_{k+1} = x_k + \alpha_k\,\delta_k

    Parameters
    ----------
    tolerance : float
        Factor by which the residual must fall; round-off of what cancels in it is always enough.
    max_iterations : int
        After which it has failed.
    backtracks : int
        Most halvings of a correction that leads to a point that is not admissible.
    growth : float
        Factor by which the residual may grow in one iteration before the correction is halved. Incompressible bodies
        need room here: a good step may well raise it a hundred times before it falls.
    linear : LinearSolver, optional
        Solver of sparse systems; chosen by their size unless given.

    Departures
    ----------
    The thesis takes the whole correction always.

    References
    ----------
    .. [1] Thesis, 1.5.1.
    """

    summary: ClassVar[str] = "a new tangent at every iteration (thesis, 1.5.1); the default"

    tolerance: float = number(1e-12, within="(0, 1e-3]", doc="factor by which the residual must fall")
    max_iterations: int = integer(30, within="[1, inf)", doc="iterations after which it has failed")
    backtracks: int = integer(20, within="[1, inf)", doc="most halvings of a correction")
    growth: float = number(1e6, within="(1, inf]", doc="growth of the residual that halves a correction")
    linear: LinearSolver | None = part("linear_solver", None, doc="linear solver; chosen by size unless given")

    def solve(self, problem: NewtonProblem, start: Array, kept: KeptTangent | None = None) -> NewtonResult:
        def correction(unknowns: Array, residual: Array) -> tuple[Array, int, bool] | None:
            tangent = problem.tangent(unknowns)
            if isinstance(tangent, np.ndarray):
                return solve(tangent, residual), 0, True
            if is_round_off(tangent, unknowns, residual):
                return None
            factors = factorise(tangent, self.linear)
            return factors.solve(residual, _LINEAR), factors.iterations, True

        return iterate(
            problem,
            start,
            correction,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            backtracks=self.backtracks,
            growth=self.growth,
        )


@final
class _Function(NewtonProblem):
    """Equations given as functions."""

    def __init__(
        self,
        evaluate: Callable[[Array], tuple[Array, Matrix | LinearSystem, float]],
        admissible: Callable[[Array], bool],
    ) -> None:
        self._evaluate, self._admissible = evaluate, admissible
        self._known: tuple[Array, Matrix | LinearSystem] | None = None

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        residual, tangent, magnitude = self._evaluate(unknowns)
        self._known = (unknowns, tangent)
        return residual, magnitude

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        if self._known is None or self._known[0] is not unknowns:
            self.residual(unknowns)
        assert self._known is not None
        return self._known[1]

    def admissible(self, unknowns: Array) -> bool:
        return self._admissible(unknowns)


def newton(
    evaluate: Callable[[Array], tuple[Array, Matrix | LinearSystem, float]],
    start: Array,
    *,
    admissible: Callable[[Array], bool],
    tolerance: float = 1e-12,
    max_iterations: int = 30,
) -> NewtonResult:
    """Solve ``F(x) = 0`` given as a function by the ordinary method.

    Parameters
    ----------
    evaluate : callable
        Residual and tangent at a point, and the norm of the terms that cancel in the residual.
    start : ndarray, shape (n,)
        Where to begin.
    admissible : callable
        Whether a point is physically possible.
    tolerance, max_iterations : float and int
        Those of `Ordinary`.
    """
    method = Ordinary(tolerance=tolerance, max_iterations=max_iterations)
    return method.solve(_Function(evaluate, admissible), start)


def log_step(number: int, step: NewtonStep, size: float) -> None:
    """Log iteration `number`, which left a residual of this size."""
    if _LOG.isEnabledFor(logging.INFO):
        said = f", {step.linear_iterations} linear iterations" if step.linear_iterations else ""
        said += "" if step.factorised else ", tangent kept"
        _LOG.info("iteration %d: residual %.2e -> %.2e, step %g%s", number, step.residual, size, step.fraction, said)


def is_round_off(tangent: Matrix | LinearSystem, unknowns: Array, residual: Array) -> bool:
    r"""Whether :math:`\|F\| \le 16\,\varepsilon\,\| |F'| |x| \|`: what the last digits of the unknowns stand for.

    A factorisation costs hundreds of times more than this question.
    """
    return length_of(residual) <= ROUND_OFF * length_of(absolute_product(tangent, unknowns))


@hookimpl
def myobridge_newton_methods() -> dict[str, type[NewtonMethod]]:
    return {"ordinary": Ordinary}
