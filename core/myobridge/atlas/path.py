"""Points of a path of equilibria: their number, effort, stability and turns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import numpy as np

from myobridge.atlas.quantities import PathGauge
from myobridge.interfaces import ContinuationPath
from myobridge.statics import Statics

__all__ = ["Iterations", "LimitLevelError", "LimitPoints", "NegativeEigenvalues", "Points"]


@final
class Points(PathGauge):
    """Accepted points."""

    words: ClassVar[str] = "points of the path"

    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        return float(len(path.points))


@final
class Iterations(PathGauge):
    """Newton iterations of the whole path."""

    words: ClassVar[str] = "iterations of the path"

    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        return float(sum(point.iterations for point in path.points))


@final
class NegativeEigenvalues(PathGauge):
    """Most unstable directions of an accepted point; not finite where they were not counted."""

    words: ClassVar[str] = "negative eigenvalues"

    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        counts = [point.negative_eigenvalues for point in path.points]
        return float("nan") if not counts or min(counts) < 0 else float(max(counts))


def _limit_levels(statics: Statics, path: ContinuationPath) -> list[float]:
    """Levels at which the level turns, by a parabola over the path's length through three points."""
    found: list[float] = []
    weights = statics.problem.weights()
    for left, middle, right in zip(path.points, path.points[1:], path.points[2:], strict=False):
        if (middle.level - left.level) * (right.level - middle.level) >= 0.0:
            continue
        before, after = (
            float(np.linalg.norm(weights * (b.unknowns - a.unknowns))) for a, b in ((left, middle), (middle, right))
        )
        a, b, _ = np.polyfit([-before, 0.0, after], [left.level, middle.level, right.level], 2)
        found.append(middle.level - b * b / (4.0 * a))
    return found


@final
class LimitPoints(PathGauge):
    """Limit points that the path passes."""

    words: ClassVar[str] = "limit points"

    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        return float(len(_limit_levels(statics, path)))


@final
class LimitLevelError(PathGauge):
    """Largest distance of a limit point's level from that on the fine mesh, relative to the largest."""

    words: ClassVar[str] = "error of the limit loads"

    def value(self, statics: Statics, path: ContinuationPath, fine: Mapping[str, Any] | None = None) -> float:
        if fine is None:
            return float("nan")
        mine, exact = np.array(_limit_levels(statics, path)), np.array(_limit_levels(**fine))
        if not mine.size or mine.size != exact.size:
            return float("nan")
        return float(np.abs(mine - exact).max() / np.abs(exact).max())
