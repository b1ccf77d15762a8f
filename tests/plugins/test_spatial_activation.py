"""Where the muscle is stimulated, and how densely it is packed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge.errors import ParameterError
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.sarcomere_density.function import Function
from myobridge_plugins.sarcomere_density.table import Table
from myobridge_plugins.sarcomere_density.tapered import Tapered
from myobridge_plugins.signal.constant import Constant
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.signal.spatial import Spatial
from myobridge_plugins.signal.square import Square
from myobridge_plugins.signal.steps import Steps
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

LINE = np.linspace(0.0, 0.1, 401)[:, None]


def test_a_compartment_with_sharp_ends_holds_its_sites_and_no_others():
    there = Spatial(signal=Constant(level=0.8), start=0.02, end=0.06).located(LINE).value(0.0)
    inside = (LINE[:, 0] >= 0.02) & (LINE[:, 0] <= 0.06)
    assert np.array_equal(there, np.where(inside, 0.8, 0.0))
    assert 100 < inside.sum() < 200


def test_an_edge_is_half_at_the_end_and_smooth():
    half = Spatial(signal=Constant(level=1.0), start=0.05, edge=0.02).located(LINE).value(0.0)
    place = LINE[:, 0]
    assert half[place <= 0.04].max() == 0.0
    assert half[place >= 0.06].min() == 1.0
    assert half[200] == pytest.approx(0.5, abs=1e-12)
    # Width times the integral of S over [-1/2, 1/2] is half the width; the steepest slope is 3/2 over the width.
    assert np.trapezoid(half, place) == pytest.approx(0.05, abs=1e-9)
    assert np.max(np.diff(half) / np.diff(place)) == pytest.approx(1.5 / 0.02, rel=1e-3)


def test_two_compartments_that_share_an_edge_make_a_whole():
    signal = Ramp(initial=0.1, slope=2.0)
    left = Spatial(signal=signal, end=0.05, edge=0.03).located(LINE)
    right = Spatial(signal=signal, start=0.05, edge=0.03).located(LINE)
    assert left.mean(0.1, 0.3) + right.mean(0.1, 0.3) == pytest.approx(np.full(401, 0.5), rel=1e-14)


@given(speed=st.floats(0.5, 10.0), origin=st.floats(-0.05, 0.15), zones=st.integers(1, 40), time=st.floats(0.0, 0.3))
def test_excitation_arrives_late_by_the_way_over_the_speed(speed, origin, zones, time):
    """A ramp of slope one is its own clock: it tells the delay of each site, to within half a zone."""
    clock = Spatial(signal=Ramp(slope=1.0, start=-10.0), speed=speed, innervation=origin, delays=zones).located(LINE)
    way = np.abs(LINE[:, 0] - origin) / speed
    delay = time + 10.0 - clock.value(time)
    depth = np.ptp(way) / zones
    assert np.abs(delay - way).max() <= 0.5 * depth + 1e-12
    assert len(np.unique(delay.round(12))) <= zones


def test_jumps_of_all_zones_are_told_and_not_more():
    signal = Spatial(signal=Steps(times=[0.1], values=[1.0]), speed=5.0, delays=4).located(LINE)
    # Up to 20 ms on the way: zones of 5 ms, each as late as its middle.
    assert signal.jumps() == pytest.approx((0.1025, 0.1075, 0.1125, 0.1175), abs=1e-12)
    train = Square(frequency=400.0, duty=0.5, start=0.0, pulses=8)  # a jump every 1.25 ms: most fall together
    jumps = Spatial(signal=train, speed=5.0, delays=4).located(LINE).jumps()
    assert np.min(np.diff(jumps)) > 1e-3
    assert len(jumps) == 28  # those at 2.5 ms, 3.75, ... 36.25 ms


@given(time=st.floats(0.0, 1.0), speed=st.floats(0.5, 10.0))
def test_at_a_jump_the_zone_has_jumped(time, speed):
    """In spite of rounding: the value at a jump is the one after it."""
    signal = Steps(times=[time - 1.0, time], values=[0.0, 1.0], interpolation="hold")
    located = Spatial(signal=signal, speed=speed, delays=5).located(LINE)
    on = [np.count_nonzero(located.value(jump)) for jump in located.jumps() if jump > time]
    assert np.all(np.diff([0, *on]) > 0)
    assert on[-1] == 401


def test_an_inner_signal_with_its_own_values_keeps_them():
    own = tuple(np.linspace(0.2, 0.9, 401).tolist())
    both = Spatial(signal=Spatial(signal=Constant(level=own), end=0.07), start=0.03, speed=4.0).located(LINE)
    inside = (LINE[:, 0] >= 0.03) & (LINE[:, 0] <= 0.07)
    assert np.array_equal(both.value(0.0), np.where(inside, own, 0.0))


def test_the_axis_must_exist_and_the_place_be_known():
    with pytest.raises(ParameterError, match=r"along: is 'z'; the sites have x, y"):
        Spatial(signal=Constant(level=1.0), along="z").located(np.zeros((3, 2)))
    with pytest.raises(ParameterError, match=r"end: is 0\.01; expected a number in \(0\.02, inf\)"):
        Spatial(signal=Constant(level=1.0), start=0.02, end=0.01)
    with pytest.raises(ParameterError, match="drives the activation"):
        Spatial(signal=Constant(level=1.0)).value(0.0)


def chain(activation: mb.Signal | None, density: mb.SarcomereDensity | None = None) -> mb.Simulation:
    return mb.Simulation(
        solid=Chain(springs=4, length=0.1, right="fixed"),
        cross_bridges=Huxley(start="empty"),
        integrator=QuasiStatic(),
        activation=activation,
        sarcomere_density=density,
        dt=1e-3,
    )


def test_a_simulation_locates_its_activation():
    simulation = chain(Spatial(signal=Constant(level=1.0), end=0.05))
    simulation.run(0.02)
    assert simulation.bus.activation.tolist() == [1.0, 1.0, 0.0, 0.0]
    assert simulation.bus.tension[0] > 1e3
    assert simulation.bus.tension[3] == 0.0
    with pytest.raises(ParameterError, match=r"activation\.along: is 'y'"):
        chain(Spatial(signal=Constant(level=1.0), along="y"))


SCENE = """
[scene]
name = "half"
effects = ["activation", "cross_bridges", "sarcomere_density"]
duration = 0.02
step = 1e-3
[solid]
plugin = "chain"
springs = 4
length = 0.1
right = "fixed"
[cross_bridges]
plugin = "huxley"
[activation]
plugin = "spatial"
signal = { plugin = "constant", level = 0.7 }
along = "x"
end = 0.05
[sarcomere_density]
plugin = "tapered"
end = 0.1
"""


def test_a_scene_stimulates_a_part():
    simulation = mb.Plan.of(mb.Scene.from_toml(SCENE)).simulation()
    simulation.run(0.02)
    assert simulation.bus.activation.tolist() == [0.7, 0.7, 0.0, 0.0]
    assert 0.0 < simulation.bus.tension[0] < simulation.bus.tension[1]


@pytest.mark.parametrize("key", ["activation.along", "sarcomere_density.along"])
def test_a_scene_names_the_axis_that_is_not_there(key):
    with pytest.raises(mb.MyobridgeError, match=rf"{key}: is 'z'; the sites have x$"):
        mb.Plan.of(mb.Scene.from_toml(SCENE, settings={key: "z"})).simulation()


def test_tapered_density_rises_from_the_floor_to_the_top():
    density = Tapered(start=0.0, end=0.1, floor=0.25, top=1.0, taper=0.4).at(LINE)
    assert density[[0, -1]] == pytest.approx([0.25, 0.25], abs=1e-12)
    assert np.all(density[160:241] > 1.0 - 1e-12)
    assert density[80] == pytest.approx(0.625, rel=1e-12)  # half-way up at half the taper
    assert density == pytest.approx(density[::-1], rel=1e-12)
    assert np.all(np.diff(density[:161]) > 0.0)
    # Mean of u^2 (3 - 2u) is a half: what two tapers of 0.4 leave of 1 is 1 - 0.8 / 2.
    assert np.trapezoid(density, LINE[:, 0]) / 0.1 == pytest.approx(0.25 + 0.75 * 0.6, rel=1e-5)
    beyond = Tapered(floor=0.3).at(np.array([[-1.0], [2.0]]))
    assert beyond.tolist() == [0.3, 0.3]


def test_tapered_density_refuses_what_is_not_there():
    with pytest.raises(ParameterError, match="along: is 'y'; the sites have x"):
        Tapered(along="y").at(LINE)
    with pytest.raises(ParameterError, match="end: is"):
        Tapered(start=0.2, end=0.1)


def test_a_density_may_be_a_python_function():
    values = Function(lambda positions: 1.0 - 5.0 * positions[:, 0]).at(LINE)
    assert values == pytest.approx(1.0 - 5.0 * LINE[:, 0])
    assert Function(lambda positions: 0.5).at(LINE).shape == (401,)
    with pytest.raises(ParameterError, match=r"answers shape \(2,\); expected \(\) or \(401,\)"):
        Function(lambda positions: [1.0, 2.0]).at(LINE)
    with pytest.raises(ParameterError, match=r"answers -0\.\d+; expected numbers in \[0, inf\)"):
        Function(lambda positions: 0.05 - positions[:, 0]).at(LINE)
    by_function = chain(None, Function(lambda positions: np.where(positions[:, 0] < 0.05, 1.0, 0.5))).run(0.02)
    by_table = chain(None, Table(values=[1.0, 1.0, 0.5, 0.5])).run(0.02)
    assert np.array_equal(by_function.bus.tension, by_table.bus.tension)
    assert np.all(by_table.bus.tension < 0.9 * chain(None).run(0.02).bus.tension)
