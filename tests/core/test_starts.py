"""Starts: what is refused, what is projected, and equilibria in closed form."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import myobridge as mb
import myobridge.simulation as simulation_module
from myobridge.cli import main
from myobridge.interfaces import Fluxes
from myobridge.plan import Plan
from myobridge.run import resume, start
from myobridge.solvers import constraint_at, gradient_at
from myobridge.steady_population import steady_population
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.clamp import Clamp
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.overlap.gordon_huxley_julian import GordonHuxleyJulian
from myobridge_plugins.signal.constant import Constant
from myobridge_plugins.signal.steps import Steps
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

RELEASE = Steps(times=(-1.0, 0.0), values=(1.0, 0.0), interpolation="hold")
SCENE = """
[scene]
name = "release"
effects = ["inertia", "incompressibility", "cross_bridges", "activation"]
duration = 0.004
step = 1e-3
start = "equilibrium"
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025], cells = [3, 1] }
material = { plugin = "neo_hooke", shear_modulus = 1e5 }
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [3e4, 0.0]
scale = { plugin = "steps", times = [-1.0, 0.0], values = [1.0, 0.0], interpolation = "hold" }
[cross_bridges]
plugin = "huxley"
p_max = 2e4
[activation]
plugin = "steps"
times = [-1.0, 0.0]
values = [0.4, 0.9]
interpolation = "hold"
"""


def body(**options):
    options.setdefault("bulk_modulus", np.inf)
    mesh = Block(size=(0.1, 0.025), cells=(4, 2))
    return FiniteElement(mesh=mesh, material=NeoHooke(shear_modulus=1e5), **options)


def begun(solid, how="as_given", integrator=None, **parts):
    return mb.Simulation(solid=solid, integrator=integrator or EnergyMomentum(), start=how, **parts)


# ---------------------------------------------------------------------- as given


def test_a_volume_of_1_3_at_the_start_is_refused_and_the_message_says_how_to_go_on() -> None:
    with pytest.raises(mb.SceneError, match=r"J - 1 is about 0\.3, .* set scene.start = 'projected'"):
        begun(body(stretch_at_start=(1.3, 1.0)))
    kept = begun(body(stretch_at_start=(1.3, 1.0 / 1.3)))
    assert kept.begun.said == ""
    kept.step()


def test_a_velocity_that_changes_the_volume_is_refused_and_a_rotation_is_not() -> None:
    stretched = {"stretch_at_start": (1.25, 0.8)}
    begun(body(**stretched, spin_at_start=30.0, velocity_at_start=(1.0, 2.0))).step()
    clamped = body(velocity_at_start=(1.0, 0.0), support=(Support(boundary="left"),))
    with pytest.raises(mb.SceneError, match=r"velocity at the start .* J changes at about [\d.]+ 1/s"):
        begun(clamped)


def test_the_message_names_the_line_of_the_scene() -> None:
    written = SCENE.replace('start = "equilibrium"\n', "").replace(
        "cells = [3, 1] }", "cells = [3, 1] }\nstretch_at_start = [1.3, 1.0]"
    )
    with pytest.raises(mb.SceneError, match=r"^scene:7: solid: the displacement at the start"):
        Plan.of(mb.Scene.from_toml(written, source="scene")).simulation()


def test_without_inertia_the_first_step_repairs_what_is_given() -> None:
    simulation = begun(body(stretch_at_start=(1.3, 1.0), support=(Support(boundary="left"),)), integrator=QuasiStatic())
    simulation.step()
    assert np.abs(simulation.motion.displacement).max() < 1e-9
    with pytest.raises(mb.SceneError, match=r"scene.start: is 'projected', and without inertia"):
        begun(body(), "projected", QuasiStatic())


def test_a_compressible_body_starts_with_the_pressure_of_its_volume() -> None:
    simulation = begun(body(bulk_modulus=1e5, stretch_at_start=(1.1, 1.0)))
    np.testing.assert_allclose(simulation.motion.multiplier, 1e4, rtol=1e-10)


# ---------------------------------------------------------------------- projected


def test_projected_the_start_keeps_the_volume_and_little_else_changes() -> None:
    solid = body(stretch_at_start=(1.3, 0.85), velocity_at_start=(1.0, 0.0), support=(Support(boundary="left"),))
    given = solid.rest_motion()
    simulation = begun(solid, "projected")
    motion = simulation.motion
    violation, size = constraint_at(solid, motion.displacement, 0.0)
    assert np.linalg.norm(violation) < 1e-13 * size
    rate = gradient_at(solid, motion.displacement, 0.0, motion.multiplier) @ motion.velocity
    assert np.linalg.norm(rate) < 1e-12 * size
    moved = np.abs(motion.displacement - given.displacement).max()
    assert 1e-4 < moved < 0.2 * np.abs(given.displacement).max()
    assert "projected in" in simulation.begun.said
    assert f"changed by at most {moved:.2g} m" in simulation.begun.said
    energy = simulation.ledger.kinetic + simulation.ledger.elastic
    for _ in range(5):
        simulation.step()
    assert simulation.ledger.kinetic + simulation.ledger.elastic == pytest.approx(energy, rel=1e-6)


def test_what_is_on_the_constraint_already_stays_where_it_is() -> None:
    solid = body(stretch_at_start=(1.25, 0.8), spin_at_start=20.0)
    given, found = solid.rest_motion(), begun(solid, "projected").motion
    np.testing.assert_allclose(found.displacement, given.displacement, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(found.velocity, given.velocity, rtol=0.0, atol=1e-13)


def test_a_stiff_body_may_be_projected_and_a_soft_one_keeps_its_pressure() -> None:
    stiff = begun(body(bulk_modulus=1e9, stretch_at_start=(1.3, 1.0)), "projected")
    violation, size = constraint_at(stiff.solid, stiff.motion.displacement, 0.0)
    assert np.linalg.norm(violation) < 1e-13 * size
    soft = begun(body(bulk_modulus=1e5, stretch_at_start=(1.1, 1.0)), "projected")
    np.testing.assert_allclose(soft.motion.multiplier, 1e4, rtol=1e-10)


# ---------------------------------------------------------------------- in equilibrium


def test_a_spring_starts_where_its_load_before_the_start_holds_it() -> None:
    """x = (F - A T) / k, with the load and the activation just before t = 0; then it swings about the new one."""
    activation = Steps(times=(-1.0, 0.0), values=(0.25, 0.75), interpolation="hold")
    for model, tension in ((None, 0.0), (Prescribed(p_max=2e4), 0.25 * 2e4)):
        spring = Spring(mass=0.1, stiffness=500.0, area=1e-4, load=attrs.evolve(RELEASE, values=(3.0, 1.0)))
        parts = {} if model is None else {"cross_bridges": model, "activation": activation}
        simulation = begun(spring, "equilibrium", **parts)
        assert simulation.motion.displacement[0] == pytest.approx((3.0 - 1e-4 * tension) / 500.0, rel=1e-12)
        assert simulation.motion.velocity[0] == 0.0
        simulation.run(0.05)
        assert abs(simulation.motion.displacement[0] - 3.0 / 500.0) > 1e-3


def test_a_chain_that_hangs_is_stretched_by_the_weight_below_each_spring() -> None:
    """E A (lambda - 1) = m g times the share of the mass below; a start of the solid's own is only the first guess."""
    n, mass, modulus, area = 5, 0.4, 1e5, 1e-4
    chain = Chain(springs=n, length=0.5, mass=mass, modulus=modulus, area=area, gravity=9.81, stretch_at_start=1.3)
    simulation = begun(chain, "equilibrium")
    below = mass * (1.0 - (np.arange(n) + 0.5) / n)
    expected = 1.0 + below * 9.81 / (modulus * area)
    # The held end stays where the solid's own start puts it.
    np.testing.assert_allclose(chain.stretch(simulation.motion.displacement, 0.0), expected, rtol=1e-10)
    simulation.run(0.01)
    assert np.abs(simulation.motion.velocity).max() < 1e-9


@pytest.mark.parametrize(
    "model",
    [Huxley(p_max=2e4, bins=16), DistributedMoment(p_max=2e4), Hill(p_max=2e4)],
    ids=["huxley", "distributed_moment", "hill"],
)
@pytest.mark.parametrize("overlap", [None, GordonHuxleyJulian()], ids=["", "overlap"])
def test_cross_bridges_start_in_their_steady_state_and_in_balance_with_the_solid(model, overlap) -> None:
    model = attrs.evolve(model, overlap=overlap)
    activation = Steps(times=(-1.0, 0.0), values=(0.6, 0.6), interpolation="hold")
    solid = body(support=(Support(boundary="left"),))
    simulation = begun(solid, "equilibrium", cross_bridges=model, activation=activation)
    bus = simulation.bus
    assert bus is not None
    balance = solid.balance(simulation.motion, bus.active_law_at_rest(), 0.0)
    assert np.linalg.norm(balance.force) < 1e-9 * 2e4 * 0.025
    assert bus.stretch.min() < 0.97
    np.testing.assert_array_equal(bus.stretch, solid.stretch(simulation.motion.displacement, 0.0))
    for _ in range(5):
        simulation.step()
    # The closure of moments rests where its step says, to the second order: half a step rests elsewhere.
    assert np.abs(simulation.motion.velocity).max() < (1e-4 if isinstance(model, DistributedMoment) else 1e-8)
    expected = model.steady_law(np.full(bus.n_sites, 0.6), bus.stretch).evaluate(bus.stretch, 0.0 * bus.stretch).tension
    np.testing.assert_allclose(bus.tension, 2e4 * expected, rtol=5e-3)


def test_a_model_without_a_steady_state_is_refused() -> None:
    with pytest.raises(
        mb.SceneError, match=r"scene.start: is 'equilibrium', and Liouville has no isometric steady state"
    ):
        begun(Spring(), "equilibrium", cross_bridges=Liouville())


def test_a_clamp_starts_with_steady_cross_bridges() -> None:
    simulation = begun(Clamp(path=Constant(level=0.95)), "equilibrium", QuasiStatic(), cross_bridges=Huxley(p_max=2e4))
    assert simulation.bus is not None
    np.testing.assert_allclose(simulation.bus.tension, 2e4, rtol=2e-3)


def test_a_load_that_nothing_bears_is_refused() -> None:
    heavy = Chain(springs=3, load=Steps(times=(-1.0, 0.0), values=(-2e3, 0.0), interpolation="hold"))
    with pytest.raises(mb.SceneError, match=r"scene.start: there is no equilibrium to start from"):
        begun(heavy, "equilibrium")
    with pytest.raises(mb.SceneError, match=r"solid: can move as a rigid body in 3 ways"):
        begun(body(), "equilibrium")
    with pytest.raises(mb.SceneError, match=r"scene.start: is 'resting'; expected one of as_given"):
        begun(body(), "resting")


@pytest.mark.parametrize("bins", [8, 64])
def test_steady_population_of_huxley_is_the_closed_form(bins) -> None:
    """rho = k f1 / (k f1 + g1) on (0, 1), nothing elsewhere: tension within the width of a bin."""
    model = Huxley(p_max=1.0, bins=bins)
    activation, stretch = np.array([0.0, 0.3, 1.0]), np.ones(3)
    population = steady_population(model, activation, stretch)
    density = model.density(population)
    inside = (density[0] > 0.0) & (density[0] < 1.0)
    for row, k in enumerate(activation):
        expected = k * 43.3 / (k * 43.3 + 10.0)
        np.testing.assert_allclose(density[1][row][inside[row]], expected, atol=1e-12)
        assert not density[1][row][~inside[row]].any()
    again, _ = model.react(population, activation, stretch, 0.02)
    np.testing.assert_allclose(again, population, atol=1e-13)


def test_a_population_that_never_rests_is_said() -> None:
    class Restless(Huxley):  # pyright: ignore[reportGeneralTypeIssues]
        def react(self, state, activation, stretch, dt, out=None):
            return 1.0 - state, Fluxes.zero(len(state))

    with pytest.raises(mb.SceneError, match="has not come to rest"):
        steady_population(Restless(bins=8), np.ones(1), np.ones(1))


# ---------------------------------------------------------------------- scenes


def test_a_scene_starts_in_equilibrium_and_round_trips() -> None:
    scene = mb.Scene.from_toml(SCENE)
    assert mb.Scene.from_toml(scene.to_toml()) == scene
    simulation = Plan.of(scene).simulation()
    assert simulation.begun.iterations > 3
    assert "levels" in simulation.begun.said
    assert simulation.bus is not None
    # The activation before the start is .4, and that of the steps is .9.
    steady = 2e4 * (0.4 * 43.3 / (0.4 * 43.3 + 10.0)) / (43.3 / 53.3)
    np.testing.assert_allclose(simulation.bus.tension, steady, rtol=1e-2)
    before = simulation.ledger.elastic
    simulation.run(0.004)
    assert simulation.ledger.kinetic > 0.01 * before
    assert abs(simulation.ledger.residual) < 1e-9 * before


def test_a_resumed_run_is_the_same_to_the_last_bit_and_does_not_begin_again(tmp_path, monkeypatch) -> None:
    scene = mb.Scene.from_toml(SCENE)
    whole = mb.run(scene)
    start(Plan.of(scene), tmp_path / "r.h5").to(scene.duration, until=0.002)  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setattr(simulation_module, "begun", None)
    continued, _ = resume(tmp_path / "r.h5")
    result = continued.to(scene.duration)  # pyright: ignore[reportAttributeAccessIssue]
    for name, array in whole.checkpoint.arrays.items():
        np.testing.assert_array_equal(result.checkpoint.arrays[name], array, err_msg=name)
    np.testing.assert_array_equal(result["tension"], whole["tension"])


def test_a_start_is_for_scenes_with_time() -> None:
    static = """
[scene]
effects = []
start = "equilibrium"
[solid]
plugin = "spring"
load = { plugin = "constant", value = 1.0 }
[continuation]
plugin = "natural"
"""
    with pytest.raises(mb.SceneError, match=r"scene.start: steps through time"):
        mb.Scene.from_toml(static)
    with pytest.raises(mb.SceneError, match=r"scene.start: is 'equilibrum'.*Did you mean 'equilibrium'"):
        mb.Scene.from_toml(SCENE.replace('"equilibrium"', '"equilibrum"'))


def test_explain_shows_the_start_and_does_not_look_for_the_equilibrium(tmp_path, monkeypatch, capsys) -> None:
    """Not once it knows what a run costs; to measure that it begins as a run does, on a coarse mesh."""
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    assert main(["explain", str(path)]) == 0
    capsys.readouterr()
    monkeypatch.setattr(simulation_module, "begun", None)
    assert main(["explain", str(path)]) == 0
    assert "equilibrium" in capsys.readouterr().out


def test_a_run_says_how_it_began(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    assert main(["run", str(path), "-o", str(tmp_path / "r.h5")]) == 0
    assert "start: equilibrium under the loads before t = 0, in 11 levels and" in capsys.readouterr().out
