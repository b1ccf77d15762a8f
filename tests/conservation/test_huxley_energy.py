"""Energy and heads of Huxley's population: what slides, what attaches, what detaches, what the grid invents."""

from __future__ import annotations

import itertools

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from myobridge_plugins.cross_bridge.exact_solution import carried, exact_moments
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.label_kernels import carry
from myobridge_plugins.cross_bridge.rates import Rates

ON = np.ones(1)


def _quadrature(rho, p, D, dt, delta, f, a, g1, g2, g3):
    """New value, work, detached and attached energy of a label, by an ordinary solver that stops at q=0 and q=1."""
    v = D / dt
    cuts = sorted({0.0, dt, *(t for t in ((0.0 - p) / v, (1.0 - p) / v) if 0.0 < t < dt)}) if D != 0.0 else [0.0, dt]
    total = np.zeros(3)
    for t0, t1 in itertools.pairwise(cuts):
        centre = p + v * 0.5 * (t0 + t1)

        def slope(t, y, centre=centre):
            q = p + v * t
            gain = f * q * max(a - y[0], 0.0) if 0.0 < centre < 1.0 else 0.0
            loss = (g2 if centre < 0.0 else g1 * q + (g3 * (q - 1.0) if centre > 1.0 else 0.0)) * y[0]
            weight = 0.5 * (q - delta) ** 2
            return [gain - loss, (q - delta) * v * y[0], weight * loss, weight * gain]

        y = solve_ivp(slope, (t0, t1), [rho, 0.0, 0.0, 0.0], rtol=1e-11, atol=1e-14, max_step=(t1 - t0) / 50).y[:, -1]
        rho, total = y[0], total + y[1:]
    return rho, *total


@numba.njit
def _carry(rho, p, D, dt, delta, f, a, g1, g2, g3):
    """Entry for Python, which the kernel itself is compiled without."""
    return carry(rho, p, D, dt, delta, f, a, g1, g2, g3)


@pytest.mark.parametrize("discretisation", ["exact", "upwind", "moving_frame_euler"])
def test_gain_of_a_slide(discretisation):
    """What a slide says to have added to the energy is the difference of the energies, in place or not."""
    model, x = Huxley(discretisation=discretisation), np.array([0.0, 0.013, -0.4, 2.0, -30.0])
    before = model.initial_state(x.size)
    kept = before.copy()
    after, gained = model.slide_and_gain(before, x)
    assert np.array_equal(before, kept)
    assert np.array_equal(after, model.slide(before, x))
    assert np.ptp(gained) > model.energy(before).max(), "the slides change the energy by more than there was"
    assert np.allclose(gained, model.energy(after) - model.energy(before), rtol=1e-13, atol=1e-16)
    again, same = model.slide_and_gain(kept, x, kept)
    assert again is kept
    assert np.array_equal(again, after)
    assert np.array_equal(same, gained)


@pytest.mark.parametrize("seed", range(40))
def test_label_along_a_path(seed):
    """Each energy of a label against an ordinary solver: regions, both directions, g3, above and below a."""
    generator = np.random.default_rng(seed)
    f, g1, g2, g3 = generator.uniform(1.0, 60.0), generator.uniform(0.0, 20.0), generator.uniform(10.0, 200.0), 0.0
    if seed % 3 == 0:
        g3 = generator.uniform(1.0, 30.0)
    a = 1.0 if seed % 2 else generator.uniform(0.1, 0.9)
    rho, p = generator.uniform(0.0, 1.0), generator.uniform(-0.5, 1.5)
    D = 0.0 if seed % 5 == 0 else generator.uniform(-1.2, 1.2)
    dt, delta = 10.0 ** generator.uniform(-3.5, -2.0), generator.choice([0.0, 0.01, -0.012])
    arguments = (rho, p, D, dt, delta, f, a, g1, g2, g3)
    assert np.allclose(_carry(*arguments), _quadrature(*arguments), rtol=1e-7, atol=1e-9)


def _exact_fluxes(rates: Rates, times, positions):
    """Attached, detached energy and work along a path (kappa = 1), by Gauss' rule over the exact solution."""
    labels = np.unique(np.concatenate([-positions, 1.0 - positions, np.arange(-1.5, 2.5, 0.02)]))
    nodes, weights = np.polynomial.legendre.leggauss(6)
    width = np.diff(labels)
    label = (labels[:-1, None] + 0.5 * width[:, None] * (1.0 + nodes)).ravel()
    mass = (0.5 * width[:, None] * weights).ravel()
    rho = np.where((label + positions[0] > 0.0) & (label + positions[0] < 1.0), rates.duty(), 0.0)
    total = np.zeros(3)
    for k, (x0, x1) in enumerate(itertools.pairwise(positions)):
        dt = times[k + 1] - times[k]
        for part, weight in zip(0.5 * (1.0 + nodes), 0.5 * weights * dt, strict=True):
            now = carried(rates, rho, label + x0, part * (x1 - x0), part * dt)
            q = label + x0 + part * (x1 - x0)
            gain, loss = rates.attachment(q) * (1.0 - now), rates.detachment(q) * now
            total += weight * np.array(
                [mass @ (0.5 * q * q * gain), mass @ (0.5 * q * q * loss), (x1 - x0) / dt * (mass @ (q * now))]
            )
        rho = carried(rates, rho, label + x0, x1 - x0, dt)
    return total


@pytest.mark.parametrize("rates", [Rates(), Rates(43.3, 10.0, 209.0, 40.0)])
@pytest.mark.parametrize("speeds", [(-40.0, -40.0), (30.0, 0.0), (0.0, -25.0), (50.0, -50.0)])
def test_fluxes_of_a_population(rates, speeds):
    times = 1e-3 * np.arange(21)
    positions = np.concatenate([[0.0], np.cumsum(1e-3 * np.repeat(speeds, 10))])
    model = Huxley(bins=128, f1=rates.f1, g1=rates.g1, g2=rates.g2, g3=rates.g3)
    state = model.initial_state(1)
    found = np.zeros(4)
    for before, after in itertools.pairwise(positions):
        state, fluxes = model.advance(state, ON, np.zeros(1), np.array([(after - before) / model.gear]), 1e-3, state)
        found += np.concatenate(fluxes)
    expected = _exact_fluxes(rates, times, positions) * 2.0 / (rates.duty() * model.gear)
    assert np.all(expected[:2] > 1e-4)
    assert np.allclose(found[:3], expected, rtol=5e-4)
    assert found[3] == 0.0


step = st.tuples(
    st.floats(1e-6, 0.05),
    st.one_of(st.just(0.0), st.floats(-8.0, 8.0), st.floats(-0.05, 0.05)),
    st.floats(0.0, 1.0),
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(steps=st.lists(step, min_size=1, max_size=12), scales=st.sampled_from(["rate", "fraction"]))
def test_balance_closes(steps, scales):
    """E1 - E0 = attached - detached + work + numerical to round-off, for any step; no flux is negative."""
    model = Huxley(activation_scales=scales, bins=16)
    state, size = model.initial_state(1), 0.0
    for dt, path, r in steps:
        before = model.energy(state)
        state, flux = model.advance(state, np.array([r]), np.zeros(1), np.array([path / model.gear]), dt, state)
        size = max(size, *(float(np.abs(item[0])) for item in flux), float(before[0]))
        gap = model.energy(state) - before - flux.attached + flux.detached - flux.work - flux.numerical
        assert abs(gap[0]) <= 1e-13 * size
        assert flux.attached[0] >= -1e-9 * size
        assert flux.detached[0] >= -1e-9 * size


@pytest.mark.parametrize("discretisation", ["exact", "moving_frame_euler"])
@settings(max_examples=40, deadline=None, derandomize=True)
@given(slides=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=20))
def test_slide_shifts_the_moments(discretisation, slides):
    """Q0 stays, Q1 and Q2 shift exactly; the moments of the header are those of the cells."""
    model = Huxley(discretisation=discretisation, low=-25.0, high=25.0, bins=16)
    state = model.initial_state(1)
    q0, q1, q2 = model.moments(state)[0]
    at = 0.0
    for x in slides:
        state, at = model.slide(state, np.array([x]), state), at + x
        found = model.moments(state)[0]
        assert found == pytest.approx([q0, q1 + at * q0, q2 + 2.0 * at * q1 + at * at * q0], rel=1e-12, abs=1e-12)
        q, rho = (item[0] for item in model.density(state))
        assert found == pytest.approx([np.sum(rho) / 16, q @ rho / 16, q * q @ rho / 16], rel=1e-11, abs=1e-11)


def test_slide_moves_something():
    model = Huxley()
    before = model.initial_state(1)
    after = model.slide(before, np.array([0.37]))
    assert abs(model.moments(after)[0, 0] - model.moments(before)[0, 0]) == 0.0
    assert model.moments(after)[0, 1] - model.moments(before)[0, 1] > 0.1
    assert model.energy(after)[0] > 1.5 * model.energy(before)[0]


def test_heads_that_leave_the_window_are_booked():
    model = Huxley(low=-2.0, high=3.0)
    state = model.initial_state(1)
    end = np.array([6.0 / model.gear])
    after, flux = model.advance(state, np.zeros(1), np.zeros(1), end, 1e-6)
    assert model.moments(after)[0, 0] == 0.0
    assert model.energy(after)[0] == 0.0
    assert flux.numerical[0] < -10.0 * model.energy(state)[0]


@pytest.mark.parametrize("x", [0.4, -0.7, 3.3])
def test_upwind_adds_energy(x):
    """n steps of a part nu of a cell each add Q0 |x| (dq - |x| / n) / 2: the thesis reports a loss."""
    model = Huxley(discretisation="upwind")
    before = model.initial_state(1)
    after = model.slide(before, np.array([x]))
    q0, q1, q2 = model.moments(before)[0]
    n = np.ceil(abs(x) * 32)
    invented = q0 * abs(x) * (1.0 / 32 - abs(x) / n)
    assert model.moments(after)[0] == pytest.approx(
        [q0, q1 + x * q0, q2 + 2.0 * x * q1 + x * x * q0 + invented], rel=1e-12
    )
    assert invented > 0.0


def test_exact_solution_is_smooth_where_it_should():
    """The reference itself: more points, and shorter intervals, change nothing."""
    times = 1.25e-3 * np.arange(41)
    positions = 0.3 * np.sin(200.0 * times)
    coarse = exact_moments(Rates(), times, positions)
    fine = exact_moments(Rates(), times, positions, spacing=0.01, points=10)
    assert np.max(np.abs(coarse - fine)) <= 1e-12
    energy = quad(lambda q: 0.5 * q * q * Rates().duty(), 0.0, 1.0)[0]
    assert coarse[0, 2] == pytest.approx(2.0 * energy, rel=1e-12)
