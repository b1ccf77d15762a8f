"""Simplified Newton method."""

from __future__ import annotations

import math
from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    KeptTangent,
    LinearSolver,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
    NewtonStep,
    NewtonTask,
)
from myobridge.parameters import integer, number, part
from myobridge.solvers import (
    HeldTangent,
    Ordinary,
    SingularMatrix,
    UnsolvedSystem,
    is_round_off,
)
from myobridge_plugins.newton.anderson import Anderson
from myobridge_plugins.newton.inexact import Inexact
from myobridge_plugins.newton.search import Search

__all__ = ["Simplified"]

# Relative residual of a linear solve with a kept tangent: the tangent is further off than that.
_LINEAR = 1e-2
# A residual that grows by more than this, or a correction of which less than this share is admissible, leads nowhere.
_GROWTH, _FRACTION = 5.0, 1e-2
# Slow iterations in a row after which the tangent is renewed: accelerated ones may pause.
_SLOW = 4
# A tangent of this solve is renewed only where it has lowered the residual by this factor.
_GAINED = 0.1
# Most iterations with the true tangent and factors of another.
_TRUE = 20


@final
@attrs.frozen
class Simplified(NewtonMethod):
    r"""Newton's method that keeps its tangent (thesis [1]_, 1.5.2), across iterations and steps, accelerated.

    .. math:: F'(x_j)\,\delta_k = -F(x_k), \qquad j \le k

    The residual is the true one; only the tangent is old. Its factors serve as long as that is cheaper than new ones,
    by a count of solves (`HeldTangent`). Each iteration costs a residual and a triangular solve, a hundredth of a
    factorisation in space; those before it correct the old tangent (`Anderson`).

    Where the residual grows fivefold, or falls by less than the factor `contraction` again and again, the tangent is
    renewed at the best point so far. Where that does not help either, the true tangent takes over, solved with the
    factors that are there (`Inexact`), and at last the ordinary method from the start: what that solves, this does.

    Parameters
    ----------
    tolerance : float
        Factor by which the residual must fall.
    max_iterations : int
        Most iterations with kept tangents; then true ones take over.
    backtracks : int
        Most halvings of a correction that leads to a point that is not admissible.
    contraction : float
        An iteration that lowers the residual by less than this factor is slow.
    depth : int
        Earlier iterations that accelerate the next one; 0: none.
    linear : LinearSolver, optional
        Solver of sparse systems; chosen by their size unless given.

    Departures
    ----------
    The thesis keeps the first tangent of a step for a given number of iterations. Here costs decide, and contraction
    (Deuflhard [2]_).

    References
    ----------
    .. [1] Thesis, 1.5.2.
    .. [2] P. Deuflhard, Newton Methods for Nonlinear Problems (2011), section 2.1.2.
    """

    summary: ClassVar[str] = "keeps its tangent across iterations and steps, accelerated (thesis, 1.5.2)"

    tolerance: float = number(1e-12, within="(0, 1e-3]", doc="factor by which the residual must fall")
    max_iterations: int = integer(
        100, within="[1, inf)", doc="most iterations with kept tangents; then true ones take over"
    )
    backtracks: int = integer(20, within="[1, inf)", doc="most halvings of a correction")
    contraction: float = number(0.7, within="(0, 1)", doc="fall of the residual below which an iteration is slow")
    depth: int = integer(5, within="[0, inf)", doc="earlier iterations that accelerate the next one")
    linear: LinearSolver | None = part("linear_solver", None, doc="linear solver; chosen by size unless given")

    @classmethod
    def suits(cls, task: NewtonTask) -> bool:
        return task.direct and not task.path

    def solve(self, problem: NewtonProblem, start: Array, kept: KeptTangent | None = None) -> NewtonResult:
        search = Search(problem, start, self.tolerance, self.backtracks)
        try:
            held = HeldTangent(kept, self.linear)
            if self._found(search, held) or self._found_truly(search, held):
                history = tuple(search.history)
                return NewtonResult(search.point, True, len(history), "", history, held.handed_on())
        except (SingularMatrix, UnsolvedSystem):
            pass
        ordinary = Ordinary(tolerance=self.tolerance, backtracks=self.backtracks, linear=self.linear)
        rest = ordinary.solve(problem, start)
        history = (*search.history, *rest.history)
        return rest._replace(iterations=len(history), history=history)

    def _found(self, search: Search, held: HeldTangent) -> bool:
        """Whether a solution was found with tangents held on to."""
        past, inner, slow = Anderson(self.depth), 0, 0
        useless, renewed = held.empty, False
        at_renewal = math.inf

        def inverse(vector: Array) -> Array:
            nonlocal inner
            found = held.factors.solve(vector, _LINEAR)
            inner += held.factors.iterations
            held.charge(max(held.factors.iterations, 1))
            return found

        while not search.converged:
            if len(search.history) >= self.max_iterations or not math.isfinite(search.size):
                return False
            if useless:
                if search.best.size > _GAINED * at_renewal:
                    return False
                search.return_to_best()
                tangent = search.problem.tangent(search.point)
                if is_round_off(tangent, search.point, search.residual):
                    return True
                held.renew(tangent)
                past.forget()
                at_renewal, slow, renewed = search.size, 0, True
            earlier, residual, before, inner = search.point, search.residual, search.size, 0
            fraction = search.step(past.correction(residual, inverse))
            search.note(NewtonStep(before, fraction, inner, renewed))
            renewed = False
            slow = slow + 1 if search.size > self.contraction * before else 0
            if slow and is_round_off(held.system, search.point, search.residual):
                return True
            lost = fraction < _FRACTION or search.size > _GROWTH * before
            useless = lost or slow >= _SLOW or (held.overdrawn and not held.fresh)
            past.learn(search.point - earlier, search.residual - residual)
        return True

    def _found_truly(self, search: Search, held: HeldTangent) -> bool:
        """Whether a solution was found from the best point with true tangents, and the factors that are there."""
        if not math.isfinite(search.best.size):
            return False
        inexact = Inexact(
            tolerance=min(search.goal.size(search.best.magnitude) / search.best.size, 1e-3),
            max_iterations=_TRUE,
            backtracks=self.backtracks,
            linear=self.linear,
        )
        found = inexact.with_held(search.problem, search.best.point, held)
        search.history.extend(found.history)
        search.go_to(found.unknowns)
        return found.converged


@hookimpl
def myobridge_newton_methods() -> dict[str, type[NewtonMethod]]:
    return {"simplified": Simplified}
