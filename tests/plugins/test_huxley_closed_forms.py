"""Huxley's model against what is known in closed form: moments, force and velocity, isometric states, overlap."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.rates import Rates
from myobridge_plugins.overlap.gordon_huxley_julian import GordonHuxleyJulian

ON = np.ones(1)
RATES = {"huxley": Rates(), "with g3": Rates(40.0, 8.0, 150.0, 30.0)}


@pytest.mark.parametrize("activation", [1.0, 0.3])
@pytest.mark.parametrize("speed", [-180.0, -20.0, -1.0, 0.0, 2.0, 45.0])
@pytest.mark.parametrize("name", RATES)
def test_steady_moments_are_those_of_the_steady_state(name, speed, activation):
    rates = RATES[name]
    faces = [-40.0, -10.0, -3.0, -1.0, -0.3, -0.1, -0.03, 0.0, 0.1, 0.9, 1.0, 1.03, 1.1, 1.5, 3.0, 8.0, 20.0, 40.0]
    for k, moment in enumerate(rates.steady_moments(speed, activation)):

        def weighted(q: float, power: int = k) -> float:
            return q**power * float(rates.steady_state(np.array([q]), speed, activation)[0])

        total = sum(quad(weighted, *pair, epsabs=1e-13)[0] for pair in itertools.pairwise(faces))
        assert moment == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize("name", RATES)
def test_steady_state_solves_the_equation(name):
    rates, h = RATES[name], 1e-6
    q = np.array([-0.7, -0.1, 0.2, 0.8, 1.3, 2.0])
    for speed in (-50.0, 30.0):
        slope = (rates.steady_state(q + h, speed) - rates.steady_state(q - h, speed)) / (2.0 * h)
        rho = rates.steady_state(q, speed)
        source = rates.attachment(q) * (1.0 - rho) - rates.detachment(q) * rho
        assert np.allclose(speed * slope, source, rtol=1e-7, atol=1e-8)


def test_fastest_shortening():
    # The zero of Huxley's force-velocity formula for f1=43.3, g1=10, g2=209; 4.0019 (f1+g1)/2.
    assert Rates().fastest_shortening() == pytest.approx(106.6516179847633, rel=1e-12)


def _steady_tension(speed: float, bins: int = 64) -> float:
    """Tension of the running population, averaged over a period of the lattice."""
    model = Huxley(bins=bins, low=-8.0, high=16.0)
    state, per_cell = model.initial_state(1), 8
    dt = 1.0 / (bins * per_cell * abs(speed))
    change = np.array([np.sign(speed) / (bins * per_cell * model.gear)])
    # Until the population of the start has left the window, in long steps.
    long = max(1, int(1e-3 / dt))
    for _ in range(int(np.ceil(max(20.0 / abs(speed), 0.2 if speed < 0.0 else 0.5) / (long * dt)))):
        state, _ = model.advance(state, ON, np.zeros(1), long * change, long * dt, state)
    tensions = []
    for _ in range(per_cell):
        state, _ = model.advance(state, ON, np.zeros(1), change, dt, state)
        tensions.append(model.active_law(state, ON, ON).tension[0])
    return float(np.mean(tensions))


@pytest.mark.parametrize("speed", [-100.0, -60.0, -34.5, -10.0, -2.0, 2.0, 10.0, 40.0])
def test_force_velocity(speed):
    model = Huxley()
    expected = model.rates.steady_moments(speed)[1] / model.rates.isometric_moments()[1]
    assert abs(_steady_tension(speed) - expected) <= 1e-4


def test_unloaded_shortening_is_found():
    low, high = -106.65 * 1.01, -106.65 * 0.99
    t_low, t_high = _steady_tension(low), _steady_tension(high)
    zero = low - t_low * (high - low) / (t_high - t_low)
    assert abs(-zero / 106.6516179847633 - 1.0) <= 1e-3


@pytest.mark.parametrize("discretisation", ["exact", "upwind", "moving_frame_euler"])
def test_isometric_start_stays(discretisation):
    model = Huxley(discretisation=discretisation)
    state = model.initial_state(2)
    expected = model.rates.isometric_moments()
    # Heads count at their cell's centre, so Q2 lacks a twelfth of a cell squared.
    expected[2] -= model.rates.duty() / (12.0 * model.bins**2)
    for _ in range(20):
        assert np.allclose(model.moments(state), expected, rtol=1e-13)
        state, fluxes = model.react(state, np.ones(2), np.ones(2), 2e-3)
        assert np.allclose(fluxes.attached, fluxes.detached, rtol=1e-11)
        assert np.all(fluxes.attached > 1e-6)
    law = model.active_law(state, np.ones(2), np.ones(2))
    assert np.allclose(law.tension, 1.0, rtol=1e-12)
    assert np.allclose(law.stiffness, 2.0 * model.gear, rtol=1e-12)


@pytest.mark.parametrize("scales", ["rate", "fraction"])
def test_activation_and_overlap(scales):
    """From above and from below the isometric tension becomes k f1 a / (k f1 + g1), relative to its greatest value."""
    r, overlap = 0.4, GordonHuxleyJulian()
    stretch = np.array([1.25])
    o = float(overlap.fraction(stretch)[0])
    assert 0.1 < o < 0.9
    k, a = (r, o) if scales == "rate" else (1.0, r * o)
    expected = k * 43.3 * a / (k * 43.3 + 10.0) / (43.3 / 53.3)
    for start in ("isometric", "empty"):
        model = Huxley(activation_scales=scales, overlap=overlap, start=start)
        assert model.steady_law(np.array([r]), stretch).tension[0] == pytest.approx(expected, rel=1e-12)
        state = model.initial_state(1)
        for _ in range(100):
            state, _ = model.react(state, np.array([r]), stretch, 0.05, state)
        assert model.active_law(state, ON, stretch).tension[0] == pytest.approx(expected, abs=2e-3)


def test_decay_above_the_attachable_fraction():
    """Above a, no head attaches: each mean decays at g1 q until it is a, then relaxes; also along a path."""
    model = Huxley(activation_scales="fraction", bins=8)
    state, r = model.initial_state(1), np.array([0.5])
    q, rho = model.density(state)
    dt = 0.11
    after, fluxes = model.react(state, r, ON, dt)
    inside = (q > 0.0) & (q < 1.0)
    m, x, F = q[inside], rho[inside], 0.5 * 43.3 / 53.3
    until = np.log(x / 0.5) / (10.0 * m)
    expected = np.where(until > dt, x * np.exp(-10.0 * m * dt), F + (0.5 - F) * np.exp(-53.3 * m * (dt - until)))
    assert 0 < np.sum(until > dt) < m.size
    # Parts are carried from two points, cells from their centre.
    assert np.allclose(model.density(after)[1][inside], expected, atol=2e-3)
    assert np.all(fluxes.detached > fluxes.attached)
    assert model.energy(after) - model.energy(state) == pytest.approx(fluxes.attached - fluxes.detached, rel=1e-10)


def test_parameters():
    assert set(Huxley.parameter_sets) == {"huxley_1957"}
    assert Huxley(**Huxley.parameter_sets["huxley_1957"]) == Huxley()
    assert Huxley().gear == pytest.approx(70.5128, rel=1e-5)
