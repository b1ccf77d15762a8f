"""Natural parameter continuation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    ContinuationPath,
    ContinuationProblem,
    ContinuationStrategy,
    NewtonMethod,
    PathPoint,
)
from myobridge.parameters import integer, number, part
from myobridge_plugins.continuation.equilibrium import accepted, equilibrium, length, slope
from myobridge_plugins.continuation.last_tangent import LastTangent
from myobridge_plugins.continuation.stops import Watch, begin_path, keep, next_stop

__all__ = ["Natural"]

# A step that moves further than this many times the slope at its end is suspected of a jump, and followed back.
_SUSPECT = 2.0
# Of the step, the distance by which the way back may miss.
_MISSED = 0.1


@final
@attrs.frozen
class Natural(ContinuationStrategy):
    r"""Natural parameter continuation (thesis [1]_, Method 4.4): raise the level, solve, repeat.

    .. math:: F(u_{k+1}, \ell_{k+1}) = 0, \qquad \ell_{k+1} = \min\bigl(1,\; \ell_k + 2^{-m} h\bigr)

    `m` grows by one when the solution fails, and falls by one, not below 0, after a step that took no more than `easy`
    iterations. Below the smallest step the path ends: at a limit point there is no equilibrium at a higher level.

    Parameters
    ----------
    step, smallest : float
        Largest and smallest step of the level [-].
    easy : int
        Iterations up to which a step counts as easy.
    newton : NewtonMethod, optional
        Method, tolerance, iterations, linear solver; unless given one that suits the size, to 1e-10 in at most 20
        iterations.

    Departures
    ----------
    Newton starts on the tangent of the path where that is admissible, in the thesis from the last solution: the same
    equilibria in fewer iterations. A solution that moved more than twice as far as the slope at its end explains is
    followed back to the level before; when that leads elsewhere Newton had landed on another branch, and the step has
    failed. The thesis accepts such jumps. It regrows after every success, and to m = 1 only, so that it never takes the
    step `h`.

    References
    ----------
    .. [1] Thesis, Method 4.4.
    """

    summary: ClassVar[str] = "raises the level step by step (thesis, Method 4.4); ends at a limit point"

    step: float = number(0.1, within="(0, 1]", doc="largest step of the level")
    smallest: float = number(1e-4, within="(0, 1]", doc="smallest step of the level, at which it gives up")
    easy: int = integer(6, within="[1, inf)", doc="iterations up to which a step is easy, and the next one larger")
    newton: NewtonMethod | None = part(
        "newton", None, doc="Newton's method; chosen by size unless given, to 1e-10 in at most 20 iterations"
    )

    def trace(
        self,
        problem: ContinuationProblem,
        start: Array,
        *,
        stops: Sequence[float] = (),
        watch: Watch | None = None,
        earlier: Sequence[PathPoint] = (),
    ) -> ContinuationPath:
        points, last = list(earlier), LastTangent(self.newton)
        if complaint := begin_path(points, problem, start, self.newton, watch, last):
            return ContinuationPath((), False, complaint)
        ahead = slope(problem, points[-1].unknowns, points[-1].level, last)
        halvings, spent = 0, 0
        while points[-1].level < 1.0:
            here = points[-1]
            step = self.step / 2.0**halvings
            stop = next_stop(points, stops)
            # A rest smaller than the smallest step is not left over.
            level = stop if here.level + step > stop - 0.5 * self.smallest else here.level + step
            found = equilibrium(problem, self._guess(problem, here, ahead, level), level, self.newton, last)
            spent += found.iterations
            reason = found.reason
            following = None
            if found.converged:
                following = slope(problem, found.unknowns, level, last)
                checks, reason = self._way_back(problem, here, found.unknowns, level, following)
                spent += checks
            if not reason:
                keep(points, accepted(problem, found.unknowns, level, spent, last), watch)
                ahead, spent = following, 0
                if found.iterations <= self.easy:
                    halvings = max(halvings - 1, 0)
            elif step / 2.0 < self.smallest:
                return ContinuationPath(tuple(points), False, self._advice(points, level, reason))
            else:
                halvings += 1
        return ContinuationPath(tuple(points), True)

    def _guess(self, problem: ContinuationProblem, here: PathPoint, ahead: Array | None, level: float) -> Array:
        if ahead is None:
            return here.unknowns
        guess = here.unknowns + (level - here.level) * ahead
        return guess if problem.admissible(guess) else here.unknowns

    def _way_back(
        self, problem: ContinuationProblem, here: PathPoint, unknowns: Array, level: float, following: Array | None
    ) -> tuple[int, str]:
        """Iterations spent on the way back, and a complaint where it leads elsewhere."""
        step = level - here.level
        moved = length(problem, unknowns - here.unknowns)
        rounding = 1e-12 * max(length(problem, unknowns), length(problem, here.unknowns))
        explained = 0.0 if following is None else step * length(problem, following)
        if moved <= _SUSPECT * explained + rounding:
            return 0, ""
        guess = unknowns if following is None else unknowns - step * following
        if not problem.admissible(guess):
            guess = unknowns
        back = equilibrium(problem, guess, here.level, self.newton)
        if back.converged and length(problem, back.unknowns - here.unknowns) <= _MISSED * moved:
            return back.iterations, ""
        return back.iterations, "the solution found does not lead back to the last one: it lies on another branch"

    def _advice(self, points: list[PathPoint], level: float, reason: str) -> str:
        last = points[-1]
        return (
            f"natural continuation stopped at level {last.level:.6g} after {len(points)} points: no equilibrium was "
            f"found at level {level:.6g}, with steps down to {self.smallest:g} ({reason}). The last state has "
            f"{last.negative_eigenvalues} negative eigenvalues. If its stiffness is about to vanish this is a limit "
            "point: try the strategy 'arclength', which passes it, or a smaller full load. Else try a smaller "
            "'smallest' or a 'newton' of more iterations."
        )


@hookimpl
def myobridge_continuations() -> dict[str, type[ContinuationStrategy]]:
    return {"natural": Natural}
