"""Distributed moments: the closure's own equations, the exact reaction of a Gaussian, published numbers."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import erfc, roots_legendre

from myobridge.testing import fitted_order
from myobridge.testing.strategies import histories
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.moment_kernels import slopes
from myobridge_plugins.cross_bridge.truncated_gaussian import inner, left, right
from myobridge_plugins.overlap.gordon_huxley_julian import GordonHuxleyJulian

ISOMETRIC = np.array([0.684179, 0.437663, 0.321696])  # physics of the closure with Huxley's rates, six digits
HUXLEY = 43.3 / 53.3 * np.array([1.0, 1.0 / 2.0, 1.0 / 3.0])
REFERENCE = Path(__file__).parents[3] / "shared" / "reference"
NODES, WEIGHTS = roots_legendre(48)


def points(low: float, high: float, pieces: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of a composite Gauss rule."""
    edges = np.linspace(low, high, pieces + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (NODES + 1.0)).ravel(), (half * WEIGHTS).ravel()


def gaussian(q: np.ndarray, moments: np.ndarray) -> np.ndarray:
    mean = moments[1] / moments[0]
    width = np.sqrt(moments[2] / moments[0] - mean**2)
    return moments[0] * np.exp(-0.5 * ((q - mean) / width) ** 2) / (width * np.sqrt(2.0 * np.pi))


def line(moments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quadrature over all q where the Gaussian is, cut at 0 and 1."""
    mean = moments[1] / moments[0]
    width = np.sqrt(moments[2] / moments[0] - mean**2)
    edges = [min(-1.0, mean - 12.0 * width), 0.0, 1.0, max(2.0, mean + 12.0 * width)]
    parts = [points(a, b) for a, b in pairwise(edges)]
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def rates(q: np.ndarray, model: DistributedMoment) -> tuple[np.ndarray, np.ndarray]:
    f = np.where((q > 0.0) & (q < 1.0), model.f1 * q, 0.0)
    g = np.where(q < 0.0, model.g2, model.g1 * q + model.g3 * np.maximum(q - 1.0, 0.0))
    return f, g


def closure(moments: np.ndarray, r: float, speed: float, model: DistributedMoment) -> np.ndarray:
    """Right-hand side of the moment equations by quadrature, independent of the kernels."""
    q, w = line(moments)
    rho = gaussian(q, moments)
    f, g = rates(q, model)
    change = r * f * (1.0 - rho) - g * rho
    carried = np.array([0.0, moments[0], 2.0 * moments[1]])
    return np.array([np.sum(w * q**k * change) for k in range(3)]) + speed * carried


def test_isometric_state_is_that_of_the_closure():
    model = DistributedMoment()
    found = model.moments(model.initial_state(1))[0]
    assert found == pytest.approx(ISOMETRIC, abs=5e-7)
    assert np.max(np.abs(closure(found, 1.0, 0.0, model))) < 1e-11
    assert model.active_law(found[None], np.ones(1), np.ones(1)).evaluate(np.ones(1), np.zeros(1)).tension == (
        pytest.approx(1.0, rel=1e-12)
    )


def test_normalisation_huxley_shows_the_closure_error():
    model = DistributedMoment(normalisation="huxley")
    tension = model.steady_law(np.ones(1), np.ones(1)).evaluate(np.ones(1), np.zeros(1)).tension
    assert tension == pytest.approx(0.437663 / 0.4061914, rel=1e-5)


@pytest.mark.parametrize("r", [1e-6, 0.02, 0.4, 1.0])
@pytest.mark.parametrize("g3", [0.0, 300.0])
def test_steady_state_has_no_slope(r, g3):
    model = DistributedMoment(g3=g3)
    tension = model.steady_law(np.array([r]), np.ones(1)).evaluate(np.ones(1), np.zeros(1)).tension[0]
    state = model.initial_state(1) if r == 1.0 else None
    if state is None:
        # Newton's answer is hidden behind the law: reach it by reactions of the second-order method.
        slow = DistributedMoment(g3=g3, method="extrapolated")
        state = slow.initial_state(1)
        for dt in (0.2, 0.05, 0.02, 0.01):
            for _ in range(100):
                state, _ = slow.react(state, np.array([r]), np.ones(1), dt)
        reached = slow.active_law(state, np.ones(1), np.ones(1)).evaluate(np.ones(1), np.zeros(1)).tension[0]
        assert tension == pytest.approx(reached, rel=2e-2)
    else:
        assert np.max(np.abs(closure(state[0], r, 0.0, model))) < 1e-10


@pytest.mark.parametrize("mean", [-400.0, -3.0, -0.2, 0.1, 0.5, 1.4, 6.0, 300.0])
@pytest.mark.parametrize("sd", [1e-6, 0.02, 0.3, 1.0, 20.0, 500.0])
@pytest.mark.parametrize("a", [0.0, 0.3, 5.0, 2000.0])
def test_truncated_moments_against_quadrature(mean, sd, a):
    """Relative accuracy also where a piece holds next to nothing: variances are differences of these numbers."""

    def by_rule(low, high, weight):
        # Around the largest value of the integrand in the piece, at the scale on which it falls.
        tilt = mean - weight * sd * sd
        peak = float(np.clip(tilt, low, high))
        slope = abs(peak - tilt) / sd**2
        scale = min(sd, 1.0 / slope) if slope > 0.0 else sd
        q, w = points(max(low, peak - 42.0 * scale), min(high, peak + 42.0 * scale), 200)
        exponent = -weight * q - 0.5 * ((q - mean) / sd) ** 2
        largest = float(np.max(exponent))
        value = w * np.exp(exponent - largest) / (sd * np.sqrt(2.0 * np.pi))
        return np.array([np.sum(value * q**k) for k in range(4)]) * np.exp(largest)

    far = abs(mean) + 50.0 * sd + 10.0
    # The rule's own nodes are rounded: (q - mean)/sd is known to eps |mean|/sd only.
    tolerance = 1e-11 + np.finfo(float).eps * (1.0 + abs(mean)) / sd
    for name, found, expected in (
        ("left", left(mean, sd), by_rule(-far, 0.0, 0.0)),
        ("inner", inner(mean, sd, a), by_rule(0.0, 1.0, a)),
        ("right", right(mean, sd, a, 0.0), by_rule(1.0, far, a)),
    ):
        # Below 1e-200 the rule's own product with exp(largest) loses digits.
        scale = np.maximum(np.abs(expected), 1e-200)
        assert np.max(np.abs(np.array(found) - expected) / scale) < tolerance, (name, found, expected)


def test_half_a_gaussian():
    assert left(0.0, 2.0)[:3] == pytest.approx((0.5, -2.0 / np.sqrt(2.0 * np.pi), 2.0), rel=1e-14)
    assert right(1.0, 0.5, 0.0, 0.0)[0] == pytest.approx(0.5, rel=1e-15)
    assert right(-3.0, 0.5, 0.0, 0.0)[0] == pytest.approx(0.5 * erfc(8.0 / np.sqrt(2.0)), rel=1e-12)


@pytest.mark.parametrize("g3", [0.0, 150.0])
@pytest.mark.parametrize("r", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("dt", [1e-4, 3e-3, 0.05])
def test_reaction_is_the_exact_one_of_the_gaussian(g3, r, dt):
    """Every q follows its own exponential; the projection keeps the moments of the result, energy included."""
    model = DistributedMoment(g3=g3)
    state = np.array([[0.6, 0.25, 0.3], [0.4, -0.3, 0.5], [0.7, 1.1, 2.0], [0.684, 0.4377, 0.3217]])
    after, fluxes = model.react(state, np.full(4, r), np.ones(4), dt)
    energy = 1.0 / model.energy(np.array([[0.0, 0.0, 1.0]]))[0]  # turns energies into second moments
    for i, moments in enumerate(state):
        q, w = line(moments)
        f, g = rates(q, model)
        rate = r * f + g
        rest = np.divide(r * f, rate, out=np.zeros_like(q), where=rate > 0.0)
        start = gaussian(q, moments)
        decay = np.exp(-rate * dt)
        end = rest + (start - rest) * decay
        expected = [np.sum(w * q**k * end) for k in range(3)]
        assert after[i] == pytest.approx(expected, rel=1e-11, abs=1e-14)
        mean = rest * dt + (start - rest) * np.divide(1.0 - decay, rate, out=np.zeros_like(q), where=rate > 0.0)
        assert energy * fluxes.attached[i] == pytest.approx(
            np.sum(w * q**2 * r * f * (dt - mean)), rel=1e-10, abs=1e-14
        )
        assert energy * fluxes.detached[i] == pytest.approx(np.sum(w * q**2 * g * mean), rel=1e-10, abs=1e-14)
    # What is booked as numerical is the rounding of the stored energy.
    assert np.max(np.abs(fluxes.numerical)) < 1e-14 * np.max(model.energy(state))
    assert np.max(fluxes.detached) > 1e-6


def march(model: DistributedMoment, start: np.ndarray, speed: float, duration: float, n: int) -> np.ndarray:
    state, ends = np.array([start]), 1.0 + np.linspace(0.0, speed * duration, n + 1)[:, None] / model.gear
    for before, after in pairwise(ends):
        state, _ = model.advance(state, np.ones(1), before, after, duration / n, state)
    return state[0]


@pytest.mark.parametrize("speed", [-100.0, 60.0])
def test_converges_to_the_moment_equations(speed):
    """Order 1 and 2 against an ODE solver on a right-hand side by quadrature; the second-order one to 1e-6."""
    duration, counts = 0.02, (50, 100, 200, 400)
    exact = solve_ivp(
        lambda t, y: closure(y, 1.0, speed, DistributedMoment()), (0, duration), HUXLEY, rtol=1e-10, atol=1e-12
    ).y[:, -1]
    for method, order, bound in (("projection", 1, 6e-3), ("extrapolated", 2, 1e-6)):
        model = DistributedMoment(method=method)
        errors = [float(np.max(np.abs(march(model, HUXLEY, speed, duration, n) - exact))) for n in counts]
        observed = fitted_order([1.0 / n for n in counts], errors)
        assert observed > order - 0.15, f"{method}: observed order {observed:.2f}, errors {errors}"
        if order == 2:
            finest = float(np.max(np.abs(march(model, HUXLEY, speed, duration, 3200) - exact)))
            assert finest < bound, f"{method}: {finest}"


@pytest.mark.skipif(not (REFERENCE / "dm_traj_v-100_iso.csv").exists(), reason="reference data are not beside the repo")
def test_reference_trajectory():
    table = np.loadtxt(REFERENCE / "dm_traj_v-100_iso.csv", delimiter=",")
    model = DistributedMoment(method="extrapolated")
    row = table[4]
    found = march(model, table[0, 1:], -100.0, row[0], 4000)
    assert found == pytest.approx(row[1:], abs=1e-6)


@pytest.mark.skipif(not (REFERENCE / "dm_force_velocity.csv").exists(), reason="reference data are not beside the repo")
def test_reference_force_velocity():
    table = np.loadtxt(REFERENCE / "dm_force_velocity.csv", delimiter=",")
    model = DistributedMoment()
    for speed, *moments in table:
        found = np.zeros((1, 3))
        slopes(np.array([moments]), np.ones(1), np.ones(1), model._rates, found)
        carried = speed * np.array([0.0, moments[0], 2.0 * moments[1]])
        assert np.max(np.abs(found[0] + carried)) < 2e-6 * (1.0 + abs(speed)), speed


STIFFNESS: dict[float, dict[str, Any]] = {
    scale: {"f1": 43.3 * scale, "g1": 10.0 * scale, "g2": 209.0 * scale} for scale in (1.0, 1e3)
}
HARD = [
    DistributedMoment(method=method, activation_scales=what, **STIFFNESS[scale])
    for method in ("projection", "extrapolated")
    for what in ("rate", "fraction")
    for scale in STIFFNESS
]


@settings(max_examples=1000, deadline=None)
@given(history=histories(n_sites=100, n_steps=3, fastest=2000.0, longest=0.05), which=st.integers(0, len(HARD) - 1))
def test_realizable_for_any_step_and_speed(history, which):
    """1000 examples of 100 sites and 3 steps: Q0 >= 0, Q0 Q2 >= Q1^2, finite; starting full and empty."""
    model = HARD[which]
    start = model.initial_state(100)
    start[::7] = 0.0
    for state in history.states(model, start):
        q0, q1, q2 = state.T
        assert np.all(np.isfinite(state))
        assert np.all(q0 >= 0.0)
        # In floating point as it stands, without tolerance.
        assert np.all(q0 * q2 >= q1 * q1)


@given(mean=st.floats(-300.0, 300.0), x=st.floats(-300.0, 300.0), dt=st.floats(1e-7, 1e-3))
def test_heads_all_at_one_place_stay_realizable(mean, x, dt):
    """Zero variance is the edge of what is realizable, where every rounding counts."""
    model = DistributedMoment()
    state = 0.7 * np.array([[1.0, mean, mean**2 * (1.0 + 1e-15)]])
    for _ in range(3):
        state = model.slide(state, np.array([x]))
        assert state[0, 0] * state[0, 2] >= state[0, 1] ** 2
        state, _ = model.react(state, np.zeros(1), np.ones(1), dt)
        assert state[0, 0] * state[0, 2] >= state[0, 1] ** 2


def test_explicit_euler_becomes_unrealizable_at_once():
    model = DistributedMoment(method="explicit_euler")
    assert not model.promises.realizable
    state = model.initial_state(1)
    realizable = []
    for _ in range(4):
        state, _ = model.react(state, np.ones(1), np.ones(1), 0.01)
        state = model.slide(state, np.array([-1.0]))
        q0, q1, q2 = state[0]
        realizable.append(bool(q0 >= 0.0 and q0 * q2 >= q1 * q1))
    assert not all(realizable)


def test_nothing_comes_from_nothing():
    """Zero activation, down to the last head and below the smallest number: no NaN, and it recovers."""
    model = DistributedMoment()
    state = np.array([[1e-310, 0.0, 0.0], [0.0, 0.0, 0.0], [1e-200, 1e-200, 1e-200], [0.6, 0.3, 0.2]])
    stretch = np.ones(4)
    for _ in range(2000):
        state, fluxes = model.react(state, np.zeros(4), stretch, 0.05)
        state = model.slide(state, np.full(4, 0.01))
        assert np.all(np.isfinite(state))
        assert np.all(np.isfinite(fluxes.detached))
    assert np.max(state[:, 0]) < 1e-12
    for _ in range(400):
        state, _ = model.react(state, np.ones(4), stretch, 5e-3)
    assert state == pytest.approx(np.tile(model.initial_state(1), (4, 1)), rel=2e-2)


def test_activation_scales_rate_or_fraction():
    """Scaling the rate leaves .78 of the force at r = 0.4 or so; scaling the fraction leaves 0.4 exactly."""
    half, stretch = np.array([0.4]), np.ones(1)
    rest = np.zeros(1)
    by_rate = DistributedMoment().steady_law(half, stretch).evaluate(stretch, rest).tension[0]
    by_fraction = DistributedMoment(activation_scales="fraction").steady_law(half, stretch).evaluate(stretch, rest)
    assert 0.7 < by_rate < 0.85
    assert by_fraction.tension[0] == pytest.approx(0.4, rel=1e-12)


def test_half_the_overlap_is_half_the_force():
    model = DistributedMoment(overlap=GordonHuxleyJulian())
    stretch = np.array([2.95 / 2.2])
    assert model.steady_law(np.ones(1), stretch).evaluate(stretch, np.zeros(1)).tension[0] == pytest.approx(0.5)
    state = model.initial_state(1)
    for _ in range(1000):
        state, _ = model.react(state, np.ones(1), stretch, 2e-3, state)
    tension = model.active_law(state, np.ones(1), stretch).evaluate(stretch, np.zeros(1)).tension[0]
    assert tension == pytest.approx(0.5, abs=5e-3)
