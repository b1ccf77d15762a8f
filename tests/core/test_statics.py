"""Equilibria without time: closed forms, derivatives, limit points, constraints, kept scales, stability."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

import myobridge as mb
from myobridge.equilibria import Equilibria
from myobridge.static_run import UnstableEquilibrium

_SPEC = importlib.util.spec_from_file_location("toy_solids", Path(__file__).with_name("toy_solids.py"))
assert _SPEC is not None
assert _SPEC.loader is not None
toys = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(toys)

MODELS = ("prescribed", "hill", "huxley", "distributed_moment")
P_MAX = 5e4


def make(family: str, name: str, **parameters):
    return mb.registry().find(family, name).cls(**parameters)


def constant(level: float) -> mb.Signal:
    return make("signal", "constant", level=level)


# ---------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("strategy", ["natural", "arclength"])
@pytest.mark.parametrize("of", ["tension", "load", "tension_and_load"])
@pytest.mark.parametrize("model", MODELS)
def test_spring(model: str, of: str, strategy: str) -> None:
    """k x + A T = F, each at its scale; at rest every model pulls with its p_max."""
    k, area, force, to = 400.0, 1e-4, 3.0, 1.2
    statics = mb.Statics(
        solid=make("macro_solid", "spring", stiffness=k, area=area, load=constant(force)),
        cross_bridges=make("cross_bridge", model, p_max=P_MAX),
        continuation=make("continuation", strategy),
        of=of,
        to=to,
    )
    path = statics.trace()
    assert path.completed, path.reason
    pull = statics.tension.law(np.ones(1), 1.0).evaluate(np.ones(1), np.zeros(1)).tension[0]
    assert pull == pytest.approx(P_MAX, rel=1e-9)
    for point in path.points:
        scale = to * point.level
        raised = 1.0 if of == "load" else scale
        loaded = 1.0 if of == "tension" else scale
        assert point.unknowns[0] == pytest.approx((loaded * force - area * raised * pull) / k, abs=1e-12)
        assert statics.stretch_and_tension(point)[1][0] == pytest.approx(raised * pull, rel=1e-12)
        assert statics.reactions(point)["wall"][0] == pytest.approx(-loaded * force, abs=1e-10)
        assert point.negative_eigenvalues == 0


def test_activation_acts_with_its_value_at_the_start() -> None:
    """Prescribed tension is r p_max; Huxley's at r on the rate is r (f1 + g1) / (r f1 + g1) of it."""
    for model, share in (("prescribed", 0.4), ("huxley", 0.4 * 53.3 / (0.4 * 43.3 + 10.0))):
        statics = mb.Statics(
            solid=make("macro_solid", "spring", stiffness=400.0, area=1e-4),
            cross_bridges=make("cross_bridge", model, p_max=P_MAX),
            continuation=make("continuation", "natural"),
            activation=make("signal", "ramp", initial=0.4, final=1.0, end=1.0),
        )
        assert statics.trace().points[-1].unknowns[0] == pytest.approx(-1e-4 * share * P_MAX / 400.0, rel=1e-12)


def test_overlap_and_density_shape_the_tension() -> None:
    """k x + A s rho p_max o(1 + x / L) = 0."""
    overlap = make("overlap", "gaussian")
    statics = mb.Statics(
        solid=make("macro_solid", "spring", stiffness=100.0, area=1e-4, length=0.1),
        cross_bridges=make("cross_bridge", "hill", p_max=P_MAX, overlap=overlap),
        continuation=make("continuation", "natural"),
        sarcomere_density=make("sarcomere_density", "uniform", value=0.5),
        to=1.5,
    )

    def rest(x):
        return 100.0 * x + 1e-4 * 1.5 * 0.5 * P_MAX * overlap.fraction(np.array([1.0 + x / 0.1]))[0]

    found = statics.trace().points[-1].unknowns[0]
    assert found == pytest.approx(brentq(rest, -0.09, 0.0, xtol=1e-15), rel=1e-9)
    assert abs(found) < 0.9 * 1e-4 * 1.5 * 0.5 * P_MAX / 100.0, "the overlap was felt"


@pytest.mark.parametrize("model", MODELS)
def test_chain_under_its_weight(model: str) -> None:
    """A (E (l - 1) + s T) = s (F + weight below); the wall holds the whole scaled load."""
    area, modulus, force, mass = 1e-4, 1e6, 1.0, 0.2
    statics = mb.Statics(
        solid=make(
            "macro_solid",
            "chain",
            springs=4,
            length=0.1,
            area=area,
            modulus=modulus,
            mass=mass,
            load=constant(force),
            gravity=9.81,
        ),
        cross_bridges=make("cross_bridge", model, p_max=P_MAX),
        continuation=make("continuation", "natural", step=0.3),
        of="tension_and_load",
        to=1.5,
    )
    for point in statics.trace().points:
        scale = 1.5 * point.level
        stretch, tension = statics.stretch_and_tension(point)
        below = mass * 9.81 * (1.0 - (np.arange(4) + 0.5) / 4.0)  # end masses are half
        np.testing.assert_allclose(stretch, 1.0 + (scale * (force + below) / area - tension) / modulus, atol=1e-12)
        held = statics.reactions(point)["left"][0]
        assert held == pytest.approx(-scale * (force + mass * 9.81), rel=1e-10, abs=1e-10)


# ---------------------------------------------------------------------- limit points


def test_arclength_passes_the_limit_points_of_two_bars() -> None:
    solid = toys.TwoBars(push=1.0)
    solid = toys.TwoBars(push=2.0 * solid.limit)
    natural = mb.Statics(solid=solid, continuation=make("continuation", "natural", smallest=1e-6)).trace()
    assert not natural.completed
    assert natural.points[-1].level == pytest.approx(0.5, abs=1e-4), "half of twice the limit load"
    path = mb.Statics(solid=solid, continuation=make("continuation", "arclength", lowest=-1.0, largest=0.03)).trace()
    assert path.completed, path.reason
    levels = np.array([point.level for point in path.points])
    turns = np.flatnonzero(np.diff(levels)[:-1] * np.diff(levels)[1:] < 0.0) + 1
    assert len(turns) == 2
    assert levels[turns] == pytest.approx([0.5, -0.5], abs=2e-3)
    negative = np.array([point.negative_eigenvalues for point in path.points])
    assert set(negative[: turns[0]]) == {0}
    assert set(negative[turns[0] + 1 : turns[1]]) == {1}, "between the limit points it snaps through"
    assert set(negative[turns[1] + 1 :]) == {0}


def test_tension_raises_the_limit_load_of_two_bars() -> None:
    """An active tension T shifts l - 1 to l - 1 + T: P = 2 z (1 - (1 - T) / l), as bars of rest length 1 - T."""
    tension = 0.02
    solid = toys.TwoBars(push=1.0)
    rest = 1.0 - tension
    cosine = np.cos(solid.angle)
    assert cosine < rest, "the bars still push"
    limit = 2.0 * rest * (1.0 - (cosine / rest) ** (2.0 / 3.0)) ** 1.5
    statics = mb.Statics(
        solid=toys.TwoBars(push=2.0 * limit),
        cross_bridges=make("cross_bridge", "prescribed", p_max=tension),
        continuation=make("continuation", "natural", smallest=1e-6),
        of="load",
    )
    path = statics.trace()
    assert path.points[-1].level == pytest.approx(0.5, abs=1e-4)


# ---------------------------------------------------------------------- constraints


def block(strategy: str = "natural", p_max: float = 0.3, **parameters) -> mb.Statics:
    return mb.Statics(
        solid=toys.Block(**parameters),
        cross_bridges=make("cross_bridge", "prescribed", p_max=p_max),
        continuation=make("continuation", strategy),
        of="tension_and_load",
    )


@pytest.mark.parametrize("strategy", ["natural", "arclength", "two_parameter"])
@pytest.mark.parametrize("bulk_modulus", [1e2, 1e6, float("inf")])
def test_a_block_that_keeps_its_area(bulk_modulus: float, strategy: str) -> None:
    """Strict: y = 1 / (1 + x) - 1, p = -(x + T) / (1 + y), and p (1 + x) + y = F (1 + x), a scalar equation for x."""
    statics = block(strategy, load=0.2, bulk_modulus=bulk_modulus)
    path = statics.trace()
    assert path.completed, path.reason
    for point in path.points:
        s = point.level

        def rest(x, s=s):
            y = 1.0 / (1.0 + x) - 1.0
            return -(x + 0.3 * s) * (1.0 + x) ** 2 + y - 0.2 * s * (1.0 + x)

        x, y = statics.motion(point).displacement
        (p,) = statics.motion(point).multiplier
        if np.isinf(bulk_modulus):
            assert x == pytest.approx(brentq(rest, -0.5, 0.5, xtol=1e-15), abs=1e-9)
        assert (1.0 + x) * (1.0 + y) - 1.0 == pytest.approx(p / bulk_modulus, abs=1e-10)
        assert x + 0.3 * s + p * (1.0 + y) == pytest.approx(0.0, abs=1e-10)
        assert y + p * (1.0 + x) == pytest.approx(0.2 * s * (1.0 + x), abs=1e-10)
        assert point.unknowns[2] == pytest.approx(p / 7.0, rel=1e-14), "the multiplier in its unit"
        assert point.negative_eigenvalues == 0


@pytest.mark.parametrize(("soft", "unstable"), [(0.5, 0), (-0.5, 0), (-1.5, 1)])
def test_only_directions_that_the_constraint_allows_can_be_unstable(soft: float, unstable: int) -> None:
    """At rest x = -y is left: the block is stable while k_x + k_y > 0, though one stiffness alone is negative."""
    statics = block(stiffness=(soft, 1.0))
    assert statics.problem.negative_eigenvalues(np.zeros(3), 0.0) == unstable


def test_a_block_is_stable_where_its_load_is_turned_into_pressure() -> None:
    """A multiplier enters the stiffness: [[k, p], [p, k]] on x = -y is 2 (k - p)."""
    statics = block()
    for p, unstable in ((0.9, 0), (1.1, 1)):
        assert statics.problem.negative_eigenvalues(np.array([0.0, 0.0, p / 7.0]), 0.0) == unstable


UNKNOWNS = st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3).map(np.array)


@given(UNKNOWNS, st.floats(0.0, 1.5), st.sampled_from(["tension", "load", "tension_and_load"]), st.floats(-2.0, 2.0))
def test_derivatives_are_those_of_the_residual(unknowns, level, of, load) -> None:
    """With a follower load, a finite bulk modulus and a tension that depends on the stretch."""
    model = make("cross_bridge", "hill", p_max=2.0, overlap=make("overlap", "gaussian"))
    statics = mb.Statics(
        solid=toys.Block(load=load, bulk_modulus=3.0),
        cross_bridges=model,
        continuation=make("continuation", "natural"),
        of="tension",
        to=1.3,
    )
    problem = Equilibria(statics.solid, statics.tension, of=of, to=1.3)
    step = 1e-6
    change = np.column_stack(
        [
            (problem.residual(unknowns + step * axis, level) - problem.residual(unknowns - step * axis, level))
            for axis in np.eye(3)
        ]
    )
    matrix = problem.system(unknowns, level).matrix()
    np.testing.assert_allclose(matrix.toarray(), change / (2.0 * step), atol=2e-7)
    by_level = (problem.residual(unknowns, level + step) - problem.residual(unknowns, level - step)) / (2.0 * step)
    np.testing.assert_allclose(problem.level_derivative(unknowns, level), by_level, atol=2e-8)


def test_a_tissue_that_is_soft_is_asked_once_for_every_bulk_modulus() -> None:
    problem = block().problem
    assert problem.softened(1e4) is problem.softened(1e4)
    assert problem.softened(1e4).solid.bulk_modulus == 1e4
    assert Equilibria(toys.TwoBars(push=1.0), None, of="load").softened(1e4) is None


# ---------------------------------------------------------------------- rows


def run(**parameters) -> mb.Result:
    return mb.StaticRun(
        mb.Statics(
            solid=make("macro_solid", "spring", stiffness=400.0, area=1e-4, load=constant(3.0)),
            cross_bridges=make("cross_bridge", "prescribed", p_max=P_MAX),
            **parameters,
        )
    ).trace()


REPORTS = [(0.0, 0.4, 0.8, 1.2), (0.1, 1.0 / 3.0, 0.35, 1.1), (1.2,), ()]


@pytest.mark.parametrize("strategy", ["natural", "arclength"])
@pytest.mark.parametrize("report", REPORTS)
def test_reported_scales_are_met_to_the_last_digit(strategy: str, report) -> None:
    result = run(continuation=make("continuation", strategy), to=1.2, report=report)
    kept = result["scale"][result["kept"] == 1.0]
    assert list(kept) == (sorted({*report, 1.2}) if report else [0.0, 1.2])
    assert len(result["scale"]) > len(kept)
    np.testing.assert_allclose(result["scale"], 1.2 * result["level"], rtol=1e-15)
    x = (3.0 - 1e-4 * result["scale"] * P_MAX) / 400.0
    np.testing.assert_allclose(result["stretch"][:, 0], 1.0 + x / 0.1, rtol=1e-12)
    np.testing.assert_allclose(result["tension"][:, 0], result["scale"] * P_MAX, rtol=1e-12)
    np.testing.assert_allclose(result["energy/elastic"], 0.5 * 400.0 * x**2, rtol=1e-9, atol=1e-18)
    assert set(result["negative_eigenvalues"]) == {0.0}


def test_an_unstable_state_is_never_silently_accepted() -> None:
    limit = toys.TwoBars(push=1.0).limit
    statics = mb.Statics(
        solid=toys.TwoBars(push=2.0 * limit),
        continuation=make("continuation", "arclength", lowest=-1.0, largest=0.05),
    )
    with pytest.warns(UnstableEquilibrium, match=r"\d+ of \d+ states are unstable, at scales from -0\.4.* to 0\.4"):
        result = mb.StaticRun(statics).trace()
    assert set(result["negative_eigenvalues"]) == {0.0, 1.0}


def test_parts_that_do_not_go_together() -> None:
    natural = make("continuation", "natural")
    spring = make("macro_solid", "spring", stiffness=400.0)
    with pytest.raises(mb.SceneError, match=r"continuation\.of: is 'tension', and there is no tension"):
        mb.Statics(solid=spring, continuation=natural, of="tension")
    with pytest.raises(mb.SceneError, match="activation: acts on cross-bridges"):
        mb.Statics(solid=spring, continuation=natural, activation=constant(1.0))
    model = make("cross_bridge", "hill")
    with pytest.raises(mb.SceneError, match=r"activation: is 1\.5 at t = 0 s"):
        mb.Statics(solid=spring, continuation=natural, cross_bridges=model, activation=constant(1.5))
    with pytest.raises(mb.SceneError, match=r"continuation\.to: is 0"):
        mb.Statics(solid=spring, continuation=natural, to=0.0)
    slack = make("macro_solid", "chain", dimension="3", load=constant(1.0))
    with pytest.raises(mb.SceneError, match=r"solid: .*slack"):
        mb.Statics(solid=slack, continuation=natural)
