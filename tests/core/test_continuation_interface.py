"""Continuation interface: a scalar problem and a small strategy, both written against the contract alone."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.solvers import newton


class Cubic(mb.ContinuationProblem):
    """F(u, l) = u^3 + slope u - l: with slope < 0 the path folds, and its middle branch is unstable."""

    def __init__(self, slope: float) -> None:
        self.slope = slope

    def residual(self, unknowns, level):
        return unknowns**3 + self.slope * unknowns - level

    def tangent(self, unknowns, level):
        return np.diag(3.0 * unknowns**2 + self.slope)

    def level_derivative(self, unknowns, level):
        return np.array([-1.0])

    def negative_eigenvalues(self, unknowns, level):
        return int(np.sum(np.diag(self.tangent(unknowns, level)) < 0.0))


@attrs.frozen
class Steps(mb.ContinuationStrategy):
    """Equal steps of the level, predicted along the tangent, corrected by Newton."""

    steps: int = 10

    def trace(self, problem, start):
        unknowns, points = start, []
        for level in np.linspace(0.0, 1.0, self.steps + 1):
            if points:
                tangent = problem.tangent(unknowns, points[-1].level)
                slope = -np.linalg.solve(tangent, problem.level_derivative(unknowns, points[-1].level))
                unknowns = unknowns + (level - points[-1].level) * slope
            found = newton(
                lambda x, level=level: (problem.residual(x, level), problem.tangent(x, level), 1.0),
                unknowns,
                admissible=problem.admissible,
            )
            if not found.converged:
                return mb.ContinuationPath(tuple(points), False, f"at level {level:.3g}: {found.reason}")
            unknowns = found.unknowns
            unstable = problem.negative_eigenvalues(unknowns, level)
            points.append(mb.PathPoint(unknowns, float(level), found.iterations, unstable))
        return mb.ContinuationPath(tuple(points), True)


@pytest.mark.parametrize("abstract", [mb.ContinuationStrategy, mb.ContinuationProblem])
def test_the_interfaces_are_abstract(abstract: type) -> None:
    with pytest.raises(TypeError, match="abstract"):
        abstract()


def test_a_path_is_traced_through_the_interface() -> None:
    strategy: mb.ContinuationStrategy = Steps(20)
    path = strategy.trace(Cubic(1.0), np.array([0.3]))
    assert path.completed
    assert len(path.points) == 21
    for point in path.points:
        assert point.unknowns[0] ** 3 + point.unknowns[0] == pytest.approx(point.level, abs=1e-13)
        assert point.negative_eigenvalues == 0
        assert point.iterations <= 6
    assert path.points[-1].unknowns[0] == pytest.approx(0.6823278038280193, abs=1e-12)
    assert max(point.iterations for point in path.points[1:]) > 0


def test_an_unstable_branch_is_told() -> None:
    path = Steps(10).trace(Cubic(-3.0), np.array([0.0]))
    assert path.completed
    assert {point.negative_eigenvalues for point in path.points} == {1}


def test_a_path_that_ends_early_says_where() -> None:
    class Walled(Cubic):
        def admissible(self, unknowns):
            return bool(unknowns[0] < 0.5)

    path = Steps(10).trace(Walled(1.0), np.array([0.0]))
    assert not path.completed
    assert "no admissible point" in path.reason
    assert path.points[-1].unknowns[0] < 0.5
    assert path.points[-1].level == pytest.approx(0.6)


def test_a_strategy_is_registered_like_any_other_plugin() -> None:
    from myobridge.hookspecs import FAMILIES

    assert FAMILIES["continuation"].interface is mb.ContinuationStrategy
