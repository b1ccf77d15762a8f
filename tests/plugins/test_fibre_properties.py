"""Overlap, calcium and sarcomere density: corners, exact steps, shapes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from myobridge.errors import ParameterError
from myobridge.registry import registry
from myobridge_plugins.calcium.first_order import FirstOrder
from myobridge_plugins.overlap.gaussian import Gaussian
from myobridge_plugins.overlap.gordon_huxley_julian import GordonHuxleyJulian
from myobridge_plugins.sarcomere_density.table import Table
from myobridge_plugins.sarcomere_density.uniform import Uniform


def test_gordon_huxley_julian_has_the_published_corners():
    overlap = GordonHuxleyJulian(sarcomere_length=2.2e-6)
    lengths = np.array([1.0, 1.27, 1.67, 2.0, 2.1, 2.25, 2.95, 3.65, 4.0])
    expected = [0.0, 0.0, 0.84, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0]
    assert overlap.fraction(lengths / 2.2) == pytest.approx(expected, abs=1e-12)
    slopes = overlap.derivative(np.array([1.1, 1.5, 1.8, 2.1, 3.0, 4.0]) / 2.2)
    assert slopes == pytest.approx(2.2 * np.array([0.0, 2.1, 0.16 / 0.33, 0.0, -1.0 / 1.4, 0.0]), rel=1e-12)


def test_gaussian_is_one_at_its_optimum_and_1_over_e_at_its_width():
    overlap = Gaussian(optimum=1.1, width=0.45)
    stretch = np.array([1.1, 1.1 + np.sqrt(0.45), 1.1 - np.sqrt(0.45)])
    assert overlap.fraction(stretch) == pytest.approx([1.0, np.exp(-1.0), np.exp(-1.0)], rel=1e-14)


@pytest.mark.parametrize("name", registry().names("overlap"))
def test_overlap_is_a_fraction_and_its_derivative_is_one(name):
    overlap = registry().find("overlap", name).cls()
    stretch = np.random.default_rng(0).uniform(0.3, 2.0, 400)
    fraction = overlap.fraction(stretch)
    assert fraction.shape == stretch.shape
    assert np.all((fraction >= 0.0) & (fraction <= 1.0))
    h = 1e-6
    difference = (overlap.fraction(stretch + h) - overlap.fraction(stretch - h)) / (2.0 * h)
    assert overlap.derivative(stretch) == pytest.approx(difference, abs=1e-8)


@given(r0=st.floats(0.0, 1.0), u=st.floats(0.0, 1.0), dt=st.floats(0.0, 10.0), parts=st.integers(2, 5))
def test_calcium_step_is_exact_for_constant_stimulation(r0, u, dt, parts):
    """One step is many; the mean is the change over the time constants; all stays in [0, 1]."""
    kinetics = FirstOrder()
    stimulation = np.array([u])
    state, mean = kinetics.advance(np.array([r0]), stimulation, dt)
    assert 0.0 <= state[0] <= 1.0
    assert 0.0 <= mean[0] <= 1.0
    tau = kinetics.rise if u > r0 else kinetics.decay
    assert state[0] == pytest.approx(u + (r0 - u) * np.exp(-dt / tau), abs=1e-15)
    # Integral of dr/dt = (u - r) / tau over the step.
    assert (state[0] - r0) * tau == pytest.approx((u - mean[0]) * dt, abs=1e-14 * (1.0 + dt))
    many, total = np.array([r0]), 0.0
    for _ in range(parts):
        many, part = kinetics.advance(many, stimulation, dt / parts)
        total += part[0] / parts
    assert many == pytest.approx(state, abs=1e-14)
    assert total == pytest.approx(mean[0], abs=1e-13)


def test_calcium_rises_faster_than_it_decays():
    kinetics = FirstOrder(rise=0.015, decay=0.05, initial=0.0)
    risen, _ = kinetics.advance(kinetics.initial_state(1), np.ones(1), 0.015)
    fallen, _ = kinetics.advance(np.ones(1), np.zeros(1), 0.05)
    assert risen[0] == pytest.approx(1.0 - np.exp(-1.0), rel=1e-14)
    assert fallen[0] == pytest.approx(np.exp(-1.0), rel=1e-14)


def test_densities_answer_one_value_a_site():
    positions = np.zeros((3, 2))
    assert Uniform(value=0.8).at(positions).tolist() == [0.8, 0.8, 0.8]
    assert Table(values=[0.1, 0.5, 1.0]).at(positions).tolist() == [0.1, 0.5, 1.0]
    with pytest.raises(ParameterError, match="has 2 entries for 3 sites"):
        Table(values=[0.1, 0.5]).at(positions)
