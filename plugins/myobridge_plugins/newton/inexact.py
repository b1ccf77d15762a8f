"""Inexact Newton method."""

from __future__ import annotations

import math
from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    KeptTangent,
    LinearSolver,
    LinearSystem,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
    NewtonTask,
)
from myobridge.parameters import integer, number, part
from myobridge.solvers import HeldTangent, UnsolvedSystem, is_round_off, iterate, length_of

__all__ = ["Inexact"]

_SAFEGUARD = 0.1
_GROWTH = 1e6


@final
@attrs.frozen
class Inexact(NewtonMethod):
    r"""Newton's method whose linear systems are solved just well enough (thesis [1]_, 1.5.3).

    .. math:: \|F'(x_k)\,\delta_k + F(x_k)\| \le \eta_k\,\|F(x_k)\|, \qquad
              \eta_k = \gamma \Bigl(\frac{\|F(x_k)\|}{\|F(x_{k-1})\|}\Bigr)^2

    The tangent is the true one of every iteration, and GMRES multiplies with it. What preconditions GMRES, a
    factorisation or a multigrid hierarchy, is kept across iterations and steps, and renewed where iterations with it
    come dearer (`HeldTangent`), or do not arrive.

    The forcing term :math:`\eta` is the second choice of Eisenstat and Walker [2]_, with their safeguards, at most
    `forcing`.

    Parameters
    ----------
    tolerance : float
        Factor by which the residual must fall.
    max_iterations : int
        After which it has failed.
    backtracks : int
        Most halvings of a correction that leads to a point that is not admissible.
    forcing : float
        Largest forcing term, also the first one [-].
    linear : LinearSolver, optional
        Solver of sparse systems; chosen by their size unless given.

    References
    ----------
    .. [1] Thesis, 1.5.3.
    .. [2] S. C. Eisenstat, H. F. Walker, SIAM J. Sci. Comput. 17 (1996) 16-32, Eq. (2.6) with gamma = 0.9, alpha = 2.
    """

    summary: ClassVar[str] = "solves its linear systems just well enough (thesis, 1.5.3), with what was factored before"

    tolerance: float = number(1e-12, within="(0, 1e-3]", doc="factor by which the residual must fall")
    max_iterations: int = integer(50, within="[1, inf)", doc="iterations after which it has failed")
    backtracks: int = integer(20, within="[1, inf)", doc="most halvings of a correction")
    forcing: float = number(0.01, within="(0, 1)", doc="largest relative residual of a linear system")
    linear: LinearSolver | None = part("linear_solver", None, doc="linear solver; chosen by size unless given")

    @classmethod
    def suits(cls, task: NewtonTask) -> bool:
        return task.path or not task.direct

    def solve(self, problem: NewtonProblem, start: Array, kept: KeptTangent | None = None) -> NewtonResult:
        held = HeldTangent(kept, self.linear)
        found = self.with_held(problem, start, held)
        return found._replace(kept=held.handed_on()) if found.converged else found

    def with_held(self, problem: NewtonProblem, start: Array, held: HeldTangent) -> NewtonResult:
        """Solve from `start` with a tangent that the caller holds, and may find renewed."""
        sizes: list[float] = []
        terms: list[float] = []

        def correction(unknowns: Array, residual: Array) -> tuple[Array, int, bool] | None:
            tangent = problem.tangent(unknowns)
            if is_round_off(tangent, unknowns, residual):
                return None
            system = tangent if isinstance(tangent, LinearSystem) else LinearSystem(tangent, symmetric=False)
            sizes.append(length_of(residual))
            terms.append(self._term(sizes, terms))
            return _solved(held, system, residual, terms[-1])

        return iterate(
            problem,
            start,
            correction,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            backtracks=self.backtracks,
            growth=_GROWTH,
        )

    def _term(self, sizes: list[float], terms: list[float]) -> float:
        """Forcing term of the next linear system."""
        if len(sizes) < 2:
            return self.forcing
        term = 0.9 * (sizes[-1] / sizes[-2]) ** 2
        earlier = 0.9 * terms[-1] ** 2
        if earlier > _SAFEGUARD:
            term = max(term, earlier)
        # No system better than the whole problem wants: half of what is left to fall.
        wanted = 0.5 * self.tolerance * sizes[0] / sizes[-1]
        return min(max(term, wanted, 1e-10), self.forcing)


def _solved(held: HeldTangent, system: LinearSystem, residual: Array, term: float) -> tuple[Array, int, bool]:
    """Correction, applications, whether there are new factors: by those that are there, or by those of this tangent."""
    digits = -math.log10(term)
    if not held.empty and not held.worn(digits):
        try:
            found, spent = held.factors.solve_near(system, residual, term)
        except UnsolvedSystem:
            pass
        else:
            held.charge(spent, digits)
            return found, spent, False
    held.renew(system)
    found, spent = held.factors.solve_near(system, residual, term)
    held.charge(spent, digits)
    return found, spent, True


@hookimpl
def myobridge_newton_methods() -> dict[str, type[NewtonMethod]]:
    return {"inexact": Inexact}
