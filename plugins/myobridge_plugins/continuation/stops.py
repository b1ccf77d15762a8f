"""How a path begins, where it must have a point, and how its points are kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from myobridge.interfaces import Array, ContinuationProblem, NewtonMethod, PathPoint
from myobridge_plugins.continuation.equilibrium import accepted, equilibrium
from myobridge_plugins.continuation.last_tangent import LastTangent

__all__ = ["Watch", "begin_path", "keep", "next_stop"]

Watch = Callable[[PathPoint], object]


def begin_path(
    points: list[PathPoint],
    problem: ContinuationProblem,
    start: Array,
    method: NewtonMethod | None,
    watch: Watch | None,
    last: LastTangent | None = None,
) -> str:
    """Put the equilibrium at level 0 to an empty path; why there is none, where there is none."""
    if points:
        return ""
    first = equilibrium(problem, start, 0.0, method, last)
    if not first.converged:
        return f"no equilibrium at level 0 from the given start: {first.reason}."
    keep(points, accepted(problem, first.unknowns, 0.0, first.iterations), watch)
    return ""


def next_stop(points: Sequence[PathPoint], stops: Sequence[float]) -> float:
    """First of the `stops`, and of level 1 behind them, that the path has not reached yet."""
    highest = max(point.level for point in points)
    return next((stop for stop in stops if stop > highest), 1.0)


def keep(points: list[PathPoint], point: PathPoint, watch: Watch | None) -> None:
    """Put an accepted point to the others, and tell of it."""
    points.append(point)
    if watch is not None:
        watch(point)
