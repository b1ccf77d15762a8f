"""Natural and pseudo-arclength continuation where the answer is known: folds, a truss, columns that buckle."""

from __future__ import annotations

from itertools import pairwise

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.solvers import inertia
from myobridge_plugins.continuation.arclength import Arclength
from myobridge_plugins.continuation.natural import Natural
from myobridge_plugins.macro_solid.chain import Chain


def told(name: str, path: mb.ContinuationPath) -> mb.ContinuationPath:
    """Prints what the path cost."""
    spent = sum(point.iterations for point in path.points)
    print(f"{name}: {len(path.points)} points, {spent} iterations {path.reason}")
    return path


def limit_levels(path: mb.ContinuationPath) -> list[float]:
    """Extremes of the level, by the parabola through the three points around each."""
    found = []
    for left, middle, right in zip(path.points, path.points[1:], path.points[2:], strict=False):
        if (middle.level - left.level) * (right.level - middle.level) < 0.0:
            first = float(np.linalg.norm(middle.unknowns - left.unknowns))
            second = float(np.linalg.norm(right.unknowns - middle.unknowns))
            a, b, _ = np.polyfit([-first, 0.0, second], [left.level, middle.level, right.level], 2)
            found.append(middle.level - b * b / (4.0 * a))
    return found


class Fold(mb.ContinuationProblem):
    """u^3 - u = l - 0.2: limit points where u^2 = 1/3, at l = 0.2 +- 2 / 3^1.5 = 0.585 and -0.185."""

    top = 0.2 + 2.0 / 3.0**1.5
    bottom = 0.2 - 2.0 / 3.0**1.5
    start = np.array([-1.1])

    def residual(self, unknowns, level):
        return unknowns**3 - unknowns + 0.2 - level

    def tangent(self, unknowns, level):
        return np.diag(3.0 * unknowns**2 - 1.0)

    def level_derivative(self, unknowns, level):
        return np.array([-1.0])

    def negative_eigenvalues(self, unknowns, level):
        return inertia(self.tangent(unknowns, level)).negative


def test_arclength_passes_both_folds_of_a_cubic():
    path = told("arclength, cubic", Arclength(lowest=-1.0, largest=0.1).trace(Fold(), Fold.start))
    assert path.completed
    assert path.points[-1].level == 1.0
    assert path.points[-1].unknowns[0] ** 3 - path.points[-1].unknowns[0] == pytest.approx(0.8, abs=1e-12)
    assert limit_levels(path) == pytest.approx([Fold.top, Fold.bottom], abs=2e-3)
    for point in path.points:
        assert point.negative_eigenvalues == (1 if abs(point.unknowns[0]) < 3.0**-0.5 else 0)
    assert {point.negative_eigenvalues for point in path.points} == {0, 1}


def test_natural_ends_at_the_fold_and_never_lands_on_the_other_branch():
    """At 0.585 Newton can find u = 1.15 on the far branch, a jump that a path must not make."""
    for step in (0.5, 0.2, 0.1, 0.037):
        path = told(f"natural, cubic, step {step}", Natural(step=step).trace(Fold(), Fold.start))
        assert not path.completed
        assert Fold.top - 2e-4 < path.points[-1].level < Fold.top
        assert all(point.unknowns[0] < 0.0 for point in path.points)
        assert np.diff([point.level for point in path.points]).min() >= 1e-4
        assert "try the strategy 'arclength'" in path.reason


@pytest.mark.parametrize("behind", [2, 5])
def test_arclength_goes_on_backwards_where_the_path_led_backwards(behind):
    """Between the two folds the level falls: without its direction the path would be retraced."""
    strategy = Arclength(lowest=-1.0, largest=0.1)
    whole = strategy.trace(Fold(), Fold.start)
    falling = next(i for i in range(1, len(whole.points)) if whole.points[i].level < whole.points[i - 1].level) + behind
    assert whole.points[falling].level < whole.points[falling - 1].level
    path = strategy.trace(Fold(), Fold.start, earlier=whole.points[falling - 1 : falling + 1])
    assert path.completed, path.reason
    assert min(point.level for point in path.points) == pytest.approx(Fold.bottom, abs=5e-3)
    assert np.all(np.diff([point.unknowns[0] for point in path.points]) > 0.0)


def test_a_stop_is_met_once_however_often_the_path_crosses_its_level():
    path = Arclength(lowest=-1.0, largest=0.1).trace(Fold(), Fold.start, stops=(0.3, 0.7))
    levels = np.array([point.level for point in path.points])
    assert list(levels).count(0.3) == list(levels).count(0.7) == 1
    assert path.points[list(levels).index(0.3)].unknowns[0] < -1.0 / np.sqrt(3.0), "the first time, before the fold"
    assert np.sum(np.diff(np.sign(levels - 0.3)) != 0.0) >= 3


def test_a_path_that_comes_back_is_told():
    path = Arclength().trace(Fold(), Fold.start)
    assert not path.completed
    assert "returns to level 0 after 1 limit points, the first near level 0.58" in path.reason
    assert "'lowest' below 0" in path.reason
    assert path.points[-1].level > 0.0


def test_too_many_points_are_told():
    path = Arclength(max_points=5).trace(Fold(), Fold.start)
    assert not path.completed
    assert len(path.points) == 5
    assert "as many as allowed" in path.reason


def test_a_start_that_moves_freely_has_no_direction():
    class Free(Fold):
        def tangent(self, unknowns, level):
            return np.zeros((1, 1))

        def residual(self, unknowns, level):
            return np.array([-level])

    path = Arclength().trace(Free(), np.zeros(1))
    assert "the tangent is singular" in path.reason
    assert len(path.points) == 1


def test_steps_are_halved_where_it_is_hard_and_grow_where_it_is_easy():
    class Bend(Fold):
        """atan(50 (u - s)) = 0 with s = tanh((l - 0.5) / 0.05): Newton diverges from further than 0.028."""

        def gap(self, unknowns, level):
            return 50.0 * (unknowns - np.tanh((level - 0.5) / 0.05))

        def residual(self, unknowns, level):
            return np.arctan(self.gap(unknowns, level))

        def tangent(self, unknowns, level):
            return np.diag(50.0 / (1.0 + self.gap(unknowns, level) ** 2))

        def level_derivative(self, unknowns, level):
            slope = 20.0 / np.cosh((level - 0.5) / 0.05) ** 2
            return -50.0 * slope / (1.0 + self.gap(unknowns, level) ** 2)

    for strategy in (Natural(), Arclength()):
        path = told(f"{type(strategy).__name__}, bend", strategy.trace(Bend(), np.array([-1.0])))
        assert path.completed, path.reason
        assert path.points[-1].unknowns[0] == pytest.approx(1.0, abs=1e-8)
        steps = np.diff([point.level for point in path.points])
        assert steps.min() < 0.03
        assert steps[-5:].max() > 4.0 * steps.min()


@pytest.mark.parametrize("top", [0.7, 0.8, 0.9, 0.95, 0.99])
def test_a_limit_point_below_level_1_is_not_jumped_over(top):
    """At level 1 Newton finds the far branch; even large steps go there through both limit points."""

    class Late(Fold):
        def residual(self, unknowns, level):
            return unknowns**3 - unknowns + top - 2.0 / 3.0**1.5 - level

    start = np.array([-1.2])
    path = told(
        f"arclength, fold at {top}", Arclength(step=0.5, largest=0.5, turn=80.0, lowest=-1.0).trace(Late(), start)
    )
    assert path.completed
    assert limit_levels(path) == pytest.approx([top, top - 4.0 / 3.0**1.5], abs=0.05)
    assert not Natural().trace(Late(), start).completed


class Stiffening(Fold):
    """u + p = 3 l, p = 20 u^3: the second unknown is a multiplier in a unit of its own, left out of lengths."""

    def __init__(self, unit: float = 1.0) -> None:
        self.unit = unit

    def residual(self, unknowns, level):
        u, p = unknowns[0], unknowns[1] / self.unit
        return np.array([u + p - 3.0 * level, p - 20.0 * u**3])

    def tangent(self, unknowns, level):
        return np.array([[1.0, 1.0 / self.unit], [-60.0 * unknowns[0] ** 2, 1.0 / self.unit]])

    def level_derivative(self, unknowns, level):
        return np.array([-3.0, 0.0])

    def weights(self):
        return np.array([1.0, 0.0])


@pytest.mark.parametrize("strategy", [Natural(), Arclength()])
def test_the_unit_of_a_multiplier_does_not_move_the_points(strategy):
    levels = [[point.level for point in strategy.trace(Stiffening(unit), np.zeros(2)).points] for unit in (1.0, 1e6)]
    assert levels[0] == pytest.approx(levels[1], abs=1e-9)
    assert levels[0][-1] == 1.0


@pytest.mark.parametrize("step", np.linspace(0.2, 1.0, 33))
def test_no_point_lies_beyond_level_1(step):
    """A path that stiffens ends above the straight line that predicts it."""
    path = Arclength(step=step, largest=step, turn=80.0).trace(Stiffening(), np.zeros(2))
    assert path.completed
    assert max(point.level for point in path.points) == path.points[-1].level == 1.0


class Barrier(Fold):
    """log u = -20 l^power: both predictions and corrections lead to u < 0, where nothing may be asked."""

    def __init__(self, power: int) -> None:
        self.power = power

    def residual(self, unknowns, level):
        assert unknowns[0] > 0.0
        return np.log(unknowns) + 20.0 * level**self.power

    def tangent(self, unknowns, level):
        return np.diag(1.0 / unknowns)

    def level_derivative(self, unknowns, level):
        return np.array([20.0 * self.power * level ** (self.power - 1)])

    def admissible(self, unknowns):
        return bool(unknowns[0] > 0.0)


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("strategy", [Natural(step=0.25), Arclength(step=1.0, largest=1.0, turn=80.0)])
def test_what_is_not_admissible_is_never_asked_about(strategy, power):
    path = told(f"{type(strategy).__name__}, barrier", strategy.trace(Barrier(power), np.ones(1)))
    assert path.completed, path.reason
    assert path.points[-1].unknowns[0] == pytest.approx(np.exp(-20.0), rel=1e-6)
    if isinstance(strategy, Natural):  # Newton goes round it, without smaller steps
        assert len(path.points) == 5


# --- a truss of two bars: the chain of two springs in space, its apex above the line of its supports


@attrs.frozen(eq=False)
class Truss(mb.ContinuationProblem):
    """Two bars of 0.1 m at 20 degrees, pushed down at the apex; a spring holds it out of the plane (axis 1)."""

    solid: mb.MacroSolid
    full_load: float
    spring: float = 50.0

    def residual(self, unknowns, level):
        motion = mb.Motion(unknowns, np.zeros_like(unknowns))
        force = self.solid.balance(motion, None, 0.0).force
        return force + np.array([0.0, self.spring, 0.0]) * unknowns + level * np.array([0.0, 0.0, self.full_load])

    def tangent(self, unknowns, level):
        motion = mb.Motion(unknowns, np.zeros_like(unknowns))
        return self.solid.balance(motion, None, 0.0, tangent=True).stiffness + np.diag([0.0, self.spring, 0.0])

    def level_derivative(self, unknowns, level):
        return np.array([0.0, 0.0, self.full_load])

    def negative_eigenvalues(self, unknowns, level):
        return inertia(self.tangent(unknowns, level)).negative

    def admissible(self, unknowns):
        return self.solid.admissible(unknowns)

    def magnitude(self, unknowns, level):
        return self.solid.balance(mb.Motion(unknowns, np.zeros_like(unknowns)), None, 0.0).magnitude


ANGLE, BAR, STIFFNESS = np.radians(20.0), 0.1, 1e5 * 1e-4  # E A [N]
# P(z) = 2 EA (z/l - z/L) with l^2 = z^2 + (L cos a)^2 is largest where l = L cos^(2/3) a.
LIMIT = 2.0 * STIFFNESS * (1.0 - np.cos(ANGLE) ** (2.0 / 3.0)) ** 1.5
LIMIT_HEIGHT = BAR * np.cos(ANGLE) ** (2.0 / 3.0) * np.sqrt(1.0 - np.cos(ANGLE) ** (2.0 / 3.0))


def truss(full_load: float, spring: float = 50.0) -> tuple[Truss, np.ndarray]:
    solid = Chain(springs=2, length=2 * BAR, dimension="3", right="fixed", stretch_at_start=float(np.cos(ANGLE)))
    start = solid.rest_motion().displacement + np.array([0.0, 0.0, BAR * np.sin(ANGLE)])
    assert solid.stretch(start, 0.0) == pytest.approx(1.0, rel=1e-14)
    return Truss(solid, full_load, spring), start


def test_arclength_finds_both_limit_loads_of_the_truss():
    problem, start = truss(2.0 * LIMIT)
    path = told("arclength, truss", Arclength(lowest=-1.0, largest=0.05).trace(problem, start))
    assert path.completed
    assert limit_levels(path) == pytest.approx([0.5, -0.5], abs=1e-4)
    heights = np.array([point.unknowns[2] for point in path.points])
    assert np.all(np.diff(heights) < 0.0)
    for point in path.points:
        height = point.unknowns[2]
        bar = np.hypot(height, BAR * np.cos(ANGLE))
        load = 2.0 * STIFFNESS * height * (1.0 / bar - 1.0 / BAR)
        assert point.level * problem.full_load == pytest.approx(load, abs=1e-9 * LIMIT)
        assert point.negative_eigenvalues == int(abs(height) < LIMIT_HEIGHT)
    assert path.points[-1].level == 1.0
    assert path.points[-1].unknowns[2] < -BAR * np.sin(ANGLE)
    assert len(path.points) < 120


@pytest.mark.parametrize("step", [0.07, 0.1])  # of 0.1, a level is the limit load itself, where the slope is infinite
def test_natural_fails_at_the_first_limit_load_of_the_truss(step):
    """The far branch, the truss turned over, exists at this load; no step may jump there."""
    problem, start = truss(2.0 * LIMIT)
    path = told("natural, truss", Natural(step=step).trace(problem, start))
    assert not path.completed
    assert 0.4998 < path.points[-1].level < 0.5 + 1e-12
    assert f"stopped at level {path.points[-1].level:.6g} after {len(path.points)} points" in path.reason
    assert "limit point: try the strategy 'arclength'" in path.reason
    assert len(path.points) > 5
    assert all(point.unknowns[2] > LIMIT_HEIGHT * (1.0 - 1e-5) for point in path.points)
    assert all(point.negative_eigenvalues == 0 for point in path.points[:-1])


@pytest.mark.parametrize("strategy", [Natural(), Arclength()])
def test_both_agree_below_the_limit_load(strategy):
    problem, start = truss(0.9 * LIMIT)
    path = told(f"{type(strategy).__name__}, truss below its limit", strategy.trace(problem, start))
    assert path.completed
    height = path.points[-1].unknowns[2]
    bar = np.hypot(height, BAR * np.cos(ANGLE))
    assert 2.0 * STIFFNESS * height * (1.0 / bar - 1.0 / BAR) == pytest.approx(0.9 * LIMIT, rel=1e-9)
    assert height > LIMIT_HEIGHT


def test_a_truss_that_is_held_too_softly_sideways_is_flagged():
    """The compressed bars push the apex out of the plane with 2 N / l; once that beats the spring, the count is 1."""
    problem, start = truss(0.9 * LIMIT, spring=2.0)
    path = Natural().trace(problem, start)
    assert path.completed
    counts = [point.negative_eigenvalues for point in path.points]
    for point, count in zip(path.points, counts, strict=True):
        bar = np.hypot(point.unknowns[2], BAR * np.cos(ANGLE))
        assert count == int(2.0 * STIFFNESS * (1.0 / bar - 1.0 / BAR) > 2.0)
    assert set(counts) == {0, 1}


# --- columns of rigid links and rotational springs (Hencky): the straight state solves every load


@attrs.frozen(eq=False)
class Column(mb.ContinuationProblem):
    r"""Angles of `n` links; springs between them, and, of a cantilever, at the foot.

    Energy in spring constants: 1/2 |D a|^2 - l P sum(1 - cos a) - l Q sum(sin a). The pinned column ties its top to
    its axis, sum(sin a) = 0, by a multiplier.
    """

    links: int
    load: float
    across: float = 0.0
    pinned: bool = False

    @property
    def difference(self):
        inner = np.diff(np.eye(self.links), axis=0)
        return inner if self.pinned else np.vstack([np.eye(self.links)[0], inner])

    def critical_loads(self):
        k = np.arange(1, self.links if self.pinned else self.links + 1)
        wave = k * np.pi / (2 * self.links) if self.pinned else (2 * k - 1) * np.pi / (2 * (2 * self.links + 1))
        return 4.0 * np.sin(wave) ** 2

    def residual(self, unknowns, level):
        angles, tie = unknowns[: self.links], unknowns[self.links :]
        force = self.difference.T @ (self.difference @ angles) - level * self.load * np.sin(angles)
        force -= level * self.across * np.cos(angles)
        if not self.pinned:
            return force
        return np.append(force + tie * np.cos(angles), np.sin(angles).sum())

    def tangent(self, unknowns, level):
        angles, tie = unknowns[: self.links], unknowns[self.links :]
        bending = self.difference.T @ self.difference - level * self.load * np.diag(np.cos(angles))
        bending += level * self.across * np.diag(np.sin(angles))
        if not self.pinned:
            return bending
        row = np.cos(angles)[None]
        return np.block([[bending - tie * np.diag(np.sin(angles)), row.T], [row, np.zeros((1, 1))]])

    def level_derivative(self, unknowns, level):
        angles = unknowns[: self.links]
        force = -self.load * np.sin(angles) - self.across * np.cos(angles)
        return np.append(force, 0.0) if self.pinned else force

    def negative_eigenvalues(self, unknowns, level):
        return inertia(self.tangent(unknowns, level)).negative - int(self.pinned)

    def weights(self):
        return np.append(np.ones(self.links), 0.0) if self.pinned else 1.0


@pytest.mark.parametrize("pinned", [False, True])
@pytest.mark.parametrize("strategy", [Natural(step=0.05), Arclength(largest=0.05)])
def test_the_straight_column_is_flagged_beyond_each_critical_load(strategy, pinned):
    column = Column(links=20, load=0.0, pinned=pinned)
    critical = column.critical_loads()
    bending = (
        np.pi if pinned else np.pi / 2
    ) ** 2  # Euler: E I / L^2 times this; E I is a spring constant times a link
    assert critical[0] * 20**2 == pytest.approx(bending, rel=0.06)
    column = attrs.evolve(column, load=0.97 * critical[2])
    path = told(f"{type(strategy).__name__}, straight column", strategy.trace(column, np.zeros(20 + pinned)))
    assert path.completed
    for point in path.points:
        assert point.negative_eigenvalues == int((critical < point.level * column.load).sum())
    assert {point.negative_eigenvalues for point in path.points} == {0, 1, 2}


@pytest.mark.parametrize("strategy", [Natural(), Arclength()])
def test_a_small_load_across_leads_to_the_stable_branch(strategy):
    """Twice the critical load, a thousandth of it across: the column bends, and is stable all the way."""
    column = Column(links=20, load=2.0 * Column(20, 0.0).critical_loads()[0])
    column = attrs.evolve(column, across=1e-3 * column.load)
    path = told(f"{type(strategy).__name__}, imperfect column", strategy.trace(column, np.zeros(20)))
    assert path.completed
    assert {point.negative_eigenvalues for point in path.points} == {0}
    end = path.points[-1].unknowns
    # Inextensible elastica, clamped and free: P / P_cr = (2 K(sin(a/2)) / pi)^2 = 2 at a tip angle of 1.937 rad or so.
    from scipy.optimize import brentq
    from scipy.special import ellipk

    tip = brentq(lambda a: (2.0 * ellipk(np.sin(a / 2) ** 2) / np.pi) ** 2 - 2.0, 0.1, 3.0)
    assert end[-1] == pytest.approx(tip, rel=0.03)
    assert all(a.level < b.level for a, b in pairwise(path.points))
