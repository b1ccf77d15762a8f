"""Levels at which a path must have a point."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from myobridge.interfaces import PathPoint

__all__ = ["Watch", "keep", "next_stop"]

Watch = Callable[[PathPoint], object]


def next_stop(points: Sequence[PathPoint], stops: Sequence[float]) -> float:
    """First of the `stops`, and of level 1 behind them, that the path has not reached yet."""
    highest = max(point.level for point in points)
    return next((stop for stop in stops if stop > highest), 1.0)


def keep(points: list[PathPoint], point: PathPoint, watch: Watch | None) -> None:
    """Put an accepted point to the others, and tell of it."""
    points.append(point)
    if watch is not None:
        watch(point)
