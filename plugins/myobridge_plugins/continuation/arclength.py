"""Pseudo-arclength continuation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, NamedTuple, final

import attrs
import numpy as np

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
from myobridge.solvers import SingularMatrix, UnsolvedSystem
from myobridge_plugins.continuation.equilibrium import accepted, default_method, length, slope
from myobridge_plugins.continuation.in_plane import InPlane, direction_at, load_of
from myobridge_plugins.continuation.last_tangent import LastTangent
from myobridge_plugins.continuation.stops import Watch, begin_path, keep, next_stop

__all__ = ["Arclength"]

# Newton iterations of a step unless a method is given.
_ITERATIONS = 12


class Metric(NamedTuple):
    """Inner product of two changes (unknowns, level): `factors` holds the square weight of each."""

    factors: Array

    def product(self, left: Array, right: Array) -> float:
        return float(left @ (self.factors * right))

    def unit(self, change: Array) -> Array:
        return change / math.sqrt(self.product(change, change))


class Trial(NamedTuple):
    """End of a step: point (unknowns, level), direction of the path there, turn [degrees], iterations, complaint."""

    point: Array
    direction: Array
    turn: float
    iterations: int
    complaint: str = ""


@final
@attrs.frozen
class Arclength(ContinuationStrategy):
    r"""Pseudo-arclength continuation (Keller [1]_; thesis [2]_, Remark 4.6): unknowns and level are found together.

    .. math:: F(u, \ell) = 0, \qquad
              \vartheta\,\frac{\langle t_u, u - u_k\rangle}{U^2} + (1 - \vartheta)\,t_\ell\,(\ell - \ell_k) = s, \qquad
              \begin{pmatrix} F_u & F_\ell \\ \vartheta t_u^T / U^2 & (1 - \vartheta) t_\ell \end{pmatrix}
              \begin{pmatrix} \delta u \\ \delta\ell \end{pmatrix} = -r

    with the direction `t` of the path, of length 1, and the step `s`. The bordered matrix is regular at a limit point,
    where :math:`F_u` is singular: the level turns, and the path goes on. `U` is the scale of the unknowns: how far the
    full load would move them at the first slope, and, once that is more, the largest distance from the start so far.

    The path meets every stop and ends exactly at level 1; a fold that exceeds one for less than a step may miss it.
    It ends early, and says so, when it comes back to the lowest level, when the step falls below the smallest, or when
    there are too many points.

    Parameters
    ----------
    step, smallest, largest : float
        First, smallest and largest step [-], in the length above: 1 is the full load, or the scale of the unknowns.
    share : float
        Share of the unknowns in the length, theta above.
    turn : float
        Largest angle between the directions at both ends of a step [degrees]; a larger one halves the step.
    easy : int
        Iterations that a step should take: fewer make the next one larger, more make it smaller.
    lowest : float
        Level to which the path may come back; below 0 the load is reversed, as between the limit points of a truss.
    max_points : int
        Most points of a path, and Newton iterations of a step.
    newton : NewtonMethod, optional
        Unless given one that suits the size, to 1e-10 in at most 12 iterations.

    References
    ----------
    .. [1] H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in: Applications of
       Bifurcation Theory (1977), 359-384.
    .. [2] Thesis, Remark 4.6, which names the idea and does not use it.
    """

    summary: ClassVar[str] = "pseudo-arclength (thesis, Remark 4.6); passes limit points"

    step: float = number(0.05, within="(0, 1]", doc="first step along the path")
    smallest: float = number(1e-6, within="(0, 1]", doc="smallest step, at which it gives up")
    largest: float = number(0.25, within="(0, inf)", doc="largest step")
    share: float = number(0.5, within="(0, 1)", doc="share of the unknowns in the length of a step")
    turn: float = number(20.0, unit="degrees", within="(0, 90)", doc="largest turn of the path in a step")
    easy: int = integer(4, within="[1, inf)", doc="iterations that a step should take")
    lowest: float = number(0.0, within="(-inf, 0]", doc="level at which a path that comes back is given up")
    max_points: int = integer(1000, within="[2, inf)", doc="most points of a path")
    newton: NewtonMethod | None = part(
        "newton", None, doc="Newton's method; chosen by size unless given, to 1e-10 in at most 12 iterations"
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
        method = self.newton or default_method(start.size, _ITERATIONS)
        if complaint := begin_path(points, problem, start, method, watch):
            return ContinuationPath((), False, complaint)
        direction = self._first_direction(problem, points)
        if direction is None:
            return ContinuationPath(
                tuple(points),
                False,
                f"at level {points[-1].level:.6g} the tangent is singular, so the path has no direction: hold what "
                "moves freely, or start from a state that is stretched.",
            )
        begin, here = points[0].unknowns, np.append(points[-1].unknowns, points[-1].level)
        scale = max(length(problem, direction[:-1]), length(problem, here[:-1] - begin))
        step, turns = min(self.step, self.largest), []
        while len(points) < self.max_points:
            metric = self._metric(problem, here.size - 1, scale)
            direction = metric.unit(direction)
            spent = 0
            while True:
                trial = self._advance(problem, here, direction, step, metric, next_stop(points, stops), last)
                spent += trial.iterations
                if not trial.complaint:
                    break
                step *= 0.5
                if step < self.smallest:
                    return ContinuationPath(tuple(points), False, self._too_small(points, trial.complaint))
            level = float(trial.point[-1])
            if level <= self.lowest:
                return ContinuationPath(tuple(points), False, self._returned(points, turns))
            if trial.direction[-1] * direction[-1] < 0.0:
                turns.append(max(level, points[-1].level) if direction[-1] > 0.0 else min(level, points[-1].level))
            here, direction = trial.point, trial.direction
            keep(points, accepted(problem, here[:-1], level, spent), watch)
            if level == 1.0:
                return ContinuationPath(tuple(points), True)
            scale = max(scale, length(problem, here[:-1] - begin))
            step = min(step * self._growth(trial), self.largest)
        return ContinuationPath(tuple(points), False, self._too_many(points))

    def _first_direction(self, problem: ContinuationProblem, points: list[PathPoint]) -> Array | None:
        """Direction at the last point: up, or on from the point before; None where there is none."""
        last = points[-1]
        ahead = slope(problem, last.unknowns, last.level)
        if ahead is None:
            return None
        direction = np.append(ahead, 1.0)
        if len(points) > 1:
            weights = np.append(np.broadcast_to(problem.weights(), ahead.shape), 1.0)
            came = weights * np.append(last.unknowns - points[-2].unknowns, last.level - points[-2].level)
            direction *= math.copysign(1.0, float(came @ (weights * direction)))
        return direction

    def _metric(self, problem: ContinuationProblem, n_unknowns: int, scale: float) -> Metric:
        factors = np.full(n_unknowns + 1, 1.0 - self.share)
        factors[:-1] = self.share * (np.broadcast_to(problem.weights(), n_unknowns) / (scale or 1.0)) ** 2
        return Metric(factors)

    def _growth(self, trial: Trial) -> float:
        by_iterations = math.sqrt(self.easy / max(trial.iterations, 1))
        by_turn = 0.7 * self.turn / max(trial.turn, 1e-3 * self.turn)
        return min(max(min(by_iterations, by_turn), 0.5), 2.0)

    def _advance(
        self,
        problem: ContinuationProblem,
        here: Array,
        direction: Array,
        step: float,
        metric: Metric,
        stop: float,
        last: LastTangent,
    ) -> Trial:
        """One step along the path, or to the level `stop` where that is nearer."""
        guess = here + step * direction
        row = metric.factors * direction
        at_stop = guess[-1] >= stop
        if at_stop:
            guess, row = _at_level(stop, here, direction)
        trial = self._correct(problem, guess, row, last)
        if not trial.complaint and not at_stop and trial.point[-1] > stop:
            # The guess was below and the path is above: cut the chord, correct at that level.
            cut = self._correct(problem, *_at_level(stop, here, trial.point - here), last)
            trial = cut._replace(iterations=trial.iterations + cut.iterations)
            at_stop = True
        if trial.complaint:
            return trial
        if at_stop:
            trial.point[-1] = stop  # not a last digit beside it
        change = trial.point - here
        if metric.product(change, change) > (2.0 * step) ** 2:
            return trial._replace(complaint="the solution found is too far away, on another branch")
        try:
            ahead = metric.unit(direction_at(problem, trial.point, metric.factors * direction, last))
        except (SingularMatrix, UnsolvedSystem):
            return trial._replace(complaint="the bordered matrix is singular: branches meet here")
        turn = math.degrees(math.acos(min(max(metric.product(direction, ahead), -1.0), 1.0)))
        if not turn <= self.turn:
            return trial._replace(complaint=f"the path turns by {turn:.3g} degrees in one step")
        return trial._replace(direction=ahead, turn=turn)

    def _correct(self, problem: ContinuationProblem, guess: Array, row: Array, last: LastTangent) -> Trial:
        """Point of the path in the plane through `guess` with normal `row`."""
        if not problem.admissible(guess[:-1]):
            return Trial(guess, row, 0.0, 0, "the step leads to a state that is not admissible")
        row = row * load_of(problem, guess)
        with np.errstate(all="ignore"):  # far off, a trial may overflow; Newton sees it and backtracks
            method = self.newton or default_method(guess.size, _ITERATIONS)
            found = method.solve(InPlane(problem, guess, row), guess, last.kept)
        if found.converged:
            last.take(found.kept)
        return Trial(found.unknowns, row, 0.0, found.iterations, "" if found.converged else found.reason)

    def _too_small(self, points: list[PathPoint], complaint: str) -> str:
        return (
            f"{_stopped(points)}: no step along the path longer than {self.smallest:g} succeeded ({complaint}). "
            "If two branches meet here, a small imperfection (a load across, a mesh not quite straight) tells them "
            "apart. Else try a smaller 'smallest', a larger 'turn' or a 'newton' of more iterations."
        )

    def _returned(self, points: list[PathPoint], turns: list[float]) -> str:
        first = f", the first near level {turns[0]:.6g}" if turns else ""
        return (
            f"{_stopped(points)}: the path returns to level {self.lowest:g} after {len(turns)} limit points{first}, "
            "before it reaches level 1. Try a full load below its highest level, another start, or, if the load may be "
            "reversed on the way, a 'lowest' below 0."
        )

    def _too_many(self, points: list[PathPoint]) -> str:
        return (
            f"{_stopped(points)}, which is as many as allowed. Try more 'max_points' or a larger 'largest'; if the "
            "levels of the points come back again and again, the path is a closed loop."
        )


def _stopped(points: list[PathPoint]) -> str:
    last = points[-1]
    return (
        f"arclength continuation stopped at level {last.level:.6g} after {len(points)} points, with "
        f"{last.negative_eigenvalues} negative eigenvalues"
    )


def _at_level(stop: float, here: Array, change: Array) -> tuple[Array, Array]:
    """Where the straight line from `here` along `change` meets the level `stop`, and the normal of that plane."""
    guess = here + change * ((stop - here[-1]) / change[-1])
    guess[-1] = stop
    row = np.zeros(here.size)
    row[-1] = 1.0
    return guess, row


@hookimpl
def myobridge_continuations() -> dict[str, type[ContinuationStrategy]]:
    return {"arclength": Arclength}
