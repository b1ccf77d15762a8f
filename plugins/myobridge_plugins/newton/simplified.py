"""Simplified Newton method."""

from __future__ import annotations

import math
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    KeptTangent,
    LinearSolver,
    LinearSystem,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
)
from myobridge.parameters import integer, number, part
from myobridge.solvers import Ordinary, factorise, is_round_off, iterate

__all__ = ["Simplified"]

# Relative residual of a linear solve with a kept tangent: the tangent is further off than that.
_LINEAR = 1e-4
# A kept tangent that raises the residual by more than this leads nowhere.
_GROWTH = 1e3


@final
@attrs.frozen
class Simplified(NewtonMethod):
    r"""Newton's method that keeps its tangent (thesis [1]_, 1.5.2).

    .. math:: F'(x_j)\,\delta_k = -F(x_k), \qquad j \le k

    One factorisation serves as long as every iteration lowers the residual by the factor `contraction`; then the
    tangent is renewed. It converges linearly, each iteration costs a residual and a triangular solve, a hundredth of a
    factorisation in space. Where the iterations lead nowhere, the ordinary method goes on from the best point.

    Parameters
    ----------
    tolerance : float
        Factor by which the residual must fall.
    max_iterations : int
        After which it has failed.
    backtracks : int
        Most halvings of a correction that leads to a point that is not admissible.
    contraction : float
        Factor by which the residual must fall in every iteration, else the tangent is renewed.
    linear : LinearSolver, optional
        Solver of sparse systems; chosen by their size unless given.

    Departures
    ----------
    The thesis keeps the first tangent for a given number of iterations. Here the contraction decides (Deuflhard [2]_),
    and a tangent may be handed on from one solve to the next.

    References
    ----------
    .. [1] Thesis, 1.5.2.
    .. [2] P. Deuflhard, Newton Methods for Nonlinear Problems (2011), section 2.1.2.
    """

    summary: ClassVar[str] = "keeps its tangent while the residual falls fast (thesis, 1.5.2)"

    tolerance: float = number(1e-12, within="(0, 1e-3]", doc="factor by which the residual must fall")
    max_iterations: int = integer(100, within="[1, inf)", doc="iterations after which it has failed")
    backtracks: int = integer(20, within="[1, inf)", doc="most halvings of a correction")
    contraction: float = number(0.3, within="(0, 1)", doc="fall of the residual below which the tangent is renewed")
    linear: LinearSolver | None = part("linear_solver", None, doc="linear solver; chosen by size unless given")

    def solve(self, problem: NewtonProblem, start: Array, kept: KeptTangent | None = None) -> NewtonResult:
        held: list[KeptTangent] = [] if kept is None else [kept]
        sizes: list[float] = []
        best: list[tuple[float, Array]] = [(math.inf, start)]

        def correction(unknowns: Array, residual: Array) -> tuple[Array, int, bool] | None:
            size = float(np.linalg.norm(residual))
            slow = bool(sizes) and size > self.contraction * sizes[-1]
            sizes.append(size)
            if size < best[0][0]:
                best[0] = (size, unknowns)
            renewed = slow or not held
            if renewed:
                tangent = problem.tangent(unknowns)
                if is_round_off(tangent, unknowns, residual):
                    return None
                system = tangent if isinstance(tangent, LinearSystem) else LinearSystem(tangent, symmetric=False)
                held[:] = [KeptTangent(system, factorise(system, self.linear), np.zeros(1))]
            factors = held[0].factorisation
            if factors is None:
                factors = factorise(held[0].system, self.linear)
                held[:] = [attrs.evolve(held[0], factorisation=factors)]
            return factors.solve(residual, _LINEAR), factors.iterations, renewed

        first = iterate(
            problem,
            start,
            correction,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            backtracks=self.backtracks,
            growth=_GROWTH,
        )
        if first.converged or len(first.history) + 1 >= self.max_iterations:
            return first._replace(kept=held[0] if held else None)
        rest = Ordinary(
            tolerance=self.tolerance,
            max_iterations=self.max_iterations - len(first.history),
            backtracks=self.backtracks,
            linear=self.linear,
        ).solve(problem, best[0][1])
        history = first.history + rest.history
        return rest._replace(iterations=first.iterations + rest.iterations, history=history)


@hookimpl
def myobridge_newton_methods() -> dict[str, type[NewtonMethod]]:
    return {"simplified": Simplified}
