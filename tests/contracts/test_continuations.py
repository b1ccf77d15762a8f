"""Every registered continuation strategy on problems that all must solve, and on problems that all must refuse."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse

import myobridge as mb
from myobridge.registry import registry
from myobridge.solvers import inertia

STRATEGIES = registry().names("continuation")


class Watched(mb.ContinuationProblem):
    """A problem that refuses to be asked where it is inadmissible, and is judged by its inertia."""

    n_constraints = 0
    start = np.zeros(1)

    def residual(self, unknowns, level):
        assert self.admissible(unknowns), f"asked at an inadmissible state {unknowns}"
        return self.force(unknowns, level)

    def negative_eigenvalues(self, unknowns, level):
        return inertia(self.tangent(unknowns, level)).negative - self.n_constraints

    def softened(self, bulk_modulus):
        return self  # as soft as it can be


class Hardening(Watched):
    """u + 20 u^3 = 3 l, with a state at level 0 that has to be found first."""

    start = np.array([0.4])

    def force(self, u, level):
        return u + 20.0 * u**3 - 3.0 * level

    def tangent(self, u, level):
        return np.diag(1.0 + 60.0 * u**2)

    def level_derivative(self, u, level):
        return np.array([-3.0])


class Barrier(Watched):
    """log u = -8 l: full steps of Newton lead to negative u, which is forbidden."""

    start = np.ones(1)

    def force(self, u, level):
        return np.log(u) + 8.0 * level

    def tangent(self, u, level):
        return np.diag(1.0 / u)

    def level_derivative(self, u, level):
        return np.array([8.0])

    def admissible(self, unknowns):
        return bool(unknowns[0] > 0.0)


class SlowStart(Watched):
    """u = l^2 in a tiny unit: nothing moves at first."""

    def force(self, u, level):
        return 1e6 * u - level**2

    def tangent(self, u, level):
        return np.array([[1e6]])

    def level_derivative(self, u, level):
        return np.array([-2.0 * level])

    def magnitude(self, unknowns, level):
        return level**2


class Lattice(Watched):
    """300 hardening springs in a row, sparse, held at both ends and loaded in the middle."""

    start = np.zeros(299)
    difference = sparse.diags_array([np.ones(299), -np.ones(299)], offsets=[0, -1], shape=(300, 299)).tocsc()
    load = np.bincount([149], minlength=299) * 2.0

    def force(self, u, level):
        strain = self.difference @ u
        return self.difference.T @ (strain + strain**3) - level * self.load

    def tangent(self, u, level):
        strain = self.difference @ u
        return sparse.csc_array(self.difference.T @ sparse.diags_array(1.0 + 3.0 * strain**2) @ self.difference)

    def level_derivative(self, u, level):
        return -self.load


class Saddle(Watched):
    """Two hardening springs [m] whose ends are tied by a multiplier [Pa] of another size; it is left out of lengths."""

    n_constraints = 1
    start = np.zeros(3)

    def force(self, u, level):
        x, p = u[:2], u[2]
        return (
            np.array([*(1e5 * x + 1e9 * x**3), 0.0])
            + np.array([1e-4 * p, -1e-4 * p, 1e-4 * (x[0] - x[1])])
            - (level * np.array([1e3, 0.0, 0.0]))
        )

    def tangent(self, u, level):
        matrix = np.diag([*(1e5 + 3e9 * u[:2] ** 2), 0.0])
        matrix[0, 2] = matrix[2, 0] = 1e-4
        matrix[1, 2] = matrix[2, 1] = -1e-4
        return matrix

    def level_derivative(self, u, level):
        return np.array([-1e3, 0.0, 0.0])

    def weights(self):
        return np.array([1.0, 1.0, 0.0])


@pytest.mark.parametrize("kind", [Hardening, Barrier, SlowStart, Lattice, Saddle])
@pytest.mark.parametrize("name", STRATEGIES)
def test_a_path_without_limit_points_is_followed_to_the_end(name, kind):
    problem = kind()
    start = problem.start.copy()
    path = registry().find("continuation", name).cls().trace(problem, start)
    assert path.completed, path.reason
    assert path.reason == ""
    np.testing.assert_array_equal(start, problem.start, err_msg="the start was written to")
    levels = [point.level for point in path.points]
    assert levels[0] == 0.0
    assert levels[-1] == 1.0
    assert np.all(np.diff(levels) > 0.0)
    for point in path.points:
        rest = np.linalg.norm(problem.force(point.unknowns, point.level))
        assert rest <= 1e-9 * np.linalg.norm(problem.level_derivative(point.unknowns, 1.0))
        assert point.negative_eigenvalues == 0
    spent = sum(point.iterations for point in path.points)
    print(f"{name} on {kind.__name__}: {len(levels)} points, {spent} iterations")
    assert len(levels) - 1 <= spent <= 10 * len(levels)
    assert len({id(point.unknowns) for point in path.points}) == len(levels)


class Nothing(Hardening):
    """u^2 + 1 = l: no equilibrium at level 0."""

    def force(self, u, level):
        return u**2 + 1.0 - level

    def tangent(self, u, level):
        return np.diag(2.0 * u)


class Wall(Hardening):
    """Nothing beyond u = 0.2 is possible, which is met at level 0.12."""

    start = np.zeros(1)

    def admissible(self, unknowns):
        return bool(unknowns[0] < 0.2)


@pytest.mark.parametrize("name", STRATEGIES)
def test_no_equilibrium_at_the_start_is_told(name):
    path = registry().find("continuation", name).cls().trace(Nothing(), np.array([0.4]))
    assert not path.completed
    assert path.points == ()
    assert "no equilibrium at level 0" in path.reason
    beyond = registry().find("continuation", name).cls().trace(Wall(), np.array([0.4]))
    assert not beyond.completed
    assert "not admissible" in beyond.reason


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_path_that_ends_early_is_kept_and_says_where_why_and_what_to_try(name):
    path = registry().find("continuation", name).cls().trace(Wall(), np.zeros(1))
    assert not path.completed
    last = path.points[-1]
    assert last.level == pytest.approx(0.12, abs=1e-3)
    assert f"level {last.level:.6g}" in path.reason
    assert "admissible" in path.reason
    assert "ry " in path.reason
    assert len(path.points) > 2


@pytest.mark.parametrize("kind", [Hardening, Barrier, SlowStart, Lattice])
@pytest.mark.parametrize("name", STRATEGIES)
def test_stops_are_points_of_the_path_exactly_and_every_point_is_told_at_once(name, kind):
    problem, told = kind(), []
    stops = (1.0 / 3.0, 0.34, 0.9)
    path = registry().find("continuation", name).cls().trace(problem, problem.start, stops=stops, watch=told.append)
    assert path.completed, path.reason
    levels = [point.level for point in path.points]
    assert set(stops) <= set(levels), "to the last digit"
    assert np.all(np.diff(levels) > 0.0)
    assert [id(point) for point in told] == [id(point) for point in path.points]


@pytest.mark.parametrize("kind", [Hardening, Lattice, Saddle])
@pytest.mark.parametrize("name", STRATEGIES)
def test_a_path_that_was_interrupted_is_continued(name, kind):
    """Ctrl-C after the third point; the last two points are all that is needed to go on."""
    strategy, problem, told = registry().find("continuation", name).cls(), kind(), []

    def interrupt(point):
        told.append(point)
        if len(told) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        strategy.trace(problem, problem.start, watch=interrupt)
    assert 0.0 < told[-1].level < 1.0
    more = []
    path = strategy.trace(problem, np.full_like(problem.start, np.nan), earlier=told[1:], watch=more.append)
    assert path.completed, path.reason
    assert [id(point) for point in path.points] == [id(point) for point in (*told[1:], *more)]
    levels = [point.level for point in (*told, *more)]
    assert np.all(np.diff(levels) > 0.0)
    whole = strategy.trace(problem, problem.start)
    np.testing.assert_allclose(path.points[-1].unknowns, whole.points[-1].unknowns, rtol=1e-7, atol=1e-12)


def test_something_is_registered():
    assert {"natural", "arclength", "two_parameter"} <= set(STRATEGIES)
