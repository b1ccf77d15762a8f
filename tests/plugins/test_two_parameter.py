"""Continuation in level and bulk modulus: where raising the level alone fails, and where softening is of no use."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.solvers import inertia
from myobridge_plugins.continuation.natural import Natural
from myobridge_plugins.continuation.two_parameter import TwoParameter


class Stiff(mb.ContinuationProblem):
    r"""Two unknowns and a volume to be kept: u^3 + s u = l - 0.2 with s = 1 - 2 x, x = (k / (k + 1e6))^(1/4), p = k u.

    Soft it has one state at each level. As its bulk modulus k grows it folds: for k = inf (x = 1) at the level
    0.2 + 2 / 3^1.5, beyond which only the branch u > 0 is left. The second unknown is the pressure over 1e6.
    """

    fold = 0.2 + 2.0 / 3.0**1.5
    start = np.array([-1.0, 0.0])

    def __init__(self, bulk_modulus: float = float("inf")) -> None:
        self.bulk_modulus = bulk_modulus

    @property
    def slope(self):
        return 1.0 - 2.0 * (1.0 / (1.0 + 1e6 / self.bulk_modulus)) ** 0.25

    def residual(self, unknowns, level):
        u, p = unknowns
        return np.array([u**3 + self.slope * u + 0.2 - level, u - p])

    def tangent(self, unknowns, level):
        return np.array([[3.0 * unknowns[0] ** 2 + self.slope, 0.0], [1.0, -1.0]])

    def level_derivative(self, unknowns, level):
        return np.array([-1.0, 0.0])

    def negative_eigenvalues(self, unknowns, level):
        return inertia(self.tangent(unknowns, level)[:1, :1]).negative

    def weights(self):
        return np.array([1.0, 0.0])

    def softened(self, bulk_modulus):
        return Stiff(min(bulk_modulus, self.bulk_modulus))


def test_it_gets_by_hardening_where_plain_stepping_ends() -> None:
    plain = Natural().trace(Stiff(), Stiff.start)
    assert not plain.completed
    assert plain.points[-1].level == pytest.approx(Stiff.fold, abs=1e-3)
    path = TwoParameter().trace(Stiff(), Stiff.start)
    assert path.completed, path.reason
    last = path.points[-1]
    # u^3 - u = 0.8
    assert last.unknowns[0] == pytest.approx(max(np.roots([1.0, 0.0, -1.0, -0.8]).real), abs=1e-9)
    for point in path.points:
        rest = np.linalg.norm(Stiff().residual(point.unknowns, point.level))
        assert rest < 1e-9, "a state of the tissue itself, not of a softer one"
    unstable = [point.level for point in path.points if point.negative_eigenvalues]
    assert unstable == [0.2], "there the soft state u = 0 stays an equilibrium, of the unstable branch, and is flagged"
    print(f"{len(path.points)} points, {sum(point.iterations for point in path.points)} iterations")


def test_a_tissue_that_is_soft_itself_is_not_hardened() -> None:
    path = TwoParameter().trace(Stiff(2e4), Stiff.start)
    assert path.completed, path.reason
    for point in path.points:
        assert np.linalg.norm(Stiff(2e4).residual(point.unknowns, point.level)) < 1e-9


class Brittle(Stiff):
    """Above a bulk modulus of 1e5 Pa nothing beyond u = 0.3 is possible."""

    def admissible(self, unknowns):
        return bool(unknowns[0] < 0.3) or self.bulk_modulus < 1e5

    def softened(self, bulk_modulus):
        return Brittle(min(bulk_modulus, self.bulk_modulus))


def test_a_failure_says_at_which_level_and_bulk_modulus_and_keeps_the_path() -> None:
    path = TwoParameter().trace(Brittle(), Stiff.start)
    assert not path.completed
    last = path.points[-1]
    assert 0.2 < last.level < 1.0
    assert len(path.points) > 3
    for words in (f"stopped at level {last.level:.6g}", "gamma =", "bulk modulus of", "admissible", "Try"):
        assert words in path.reason, path.reason


class Rigid(Stiff):
    """Offers no softer tissue."""

    def softened(self, bulk_modulus):
        return None


def test_a_problem_without_bulk_modulus_is_refused() -> None:
    with pytest.raises(mb.PluginError, match=r"bulk modulus that can be lowered.*'natural' or 'arclength'"):
        TwoParameter().trace(Rigid(), Stiff.start)


def test_exponents_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(mb.ParameterError, match=r"last_exponent: is 3; expected a number above first_exponent, 4"):
        TwoParameter(last_exponent=3.0)


@pytest.mark.parametrize("first", [3.0, 5.0])
def test_the_hardening_begins_and_ends_where_it_is_told(first) -> None:
    asked = []

    class Watched(Stiff):
        def softened(self, bulk_modulus):
            asked.append(bulk_modulus)
            return Stiff(bulk_modulus)

    TwoParameter(first_exponent=first, last_exponent=8.0, hardening=0.25).trace(Watched(1e9), Stiff.start)
    quarters = 4.0 * (np.log10(asked) - first) / (8.0 - first)
    assert {0.0, 1.0, 2.0, 3.0, 4.0} <= set(np.round(quarters, 9)), "quarters, and halved ones where it was hard"
    assert quarters.min() >= -1e-9
    assert quarters.max() <= 4.0 + 1e-9
