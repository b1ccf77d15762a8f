"""Hill and prescribed tension: the two relations, their limits, their independence of any state."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge.build import build
from myobridge.registry import registry
from myobridge.testing.cross_bridge_law import differences
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.overlap.gaussian import Gaussian

NO_STATE = np.empty((1, 0))


def tension(model, activation: float, stretch: float, rate: float) -> float:
    law = model.active_law(NO_STATE, np.array([activation]), np.array([stretch]))
    return float(law.evaluate(np.array([stretch]), np.array([rate])).tension[0])


def test_force_velocity_has_its_published_points():
    model = Hill(force_velocity=True)
    rate = model.max_rate * np.array([-3.0, -1.0, -0.5, 0.0, 1e9])
    factor, _ = model.force_velocity_factor(rate)
    # At half v_max Hill's hyperbola with a/P0 = 1/4 gives (1 - 1/2) / (1 + 2) = 1/6.
    assert factor == pytest.approx([0.0, 0.0, 1.0 / 6.0, 1.0, 1.4], abs=1e-9)


def test_hill_product_is_constant():
    """Hill (1938): (P + a)(v + b) = (P0 + a) b with a = A P0 and b = A v_max, for shortening."""
    model = Hill(force_velocity=True)
    v = np.linspace(0.0, model.max_rate, 50)
    force, _ = model.force_velocity_factor(-v)
    product = (force + 0.25) * (v + 0.25 * model.max_rate)
    assert product == pytest.approx(np.full(50, 1.25 * 0.25 * model.max_rate), rel=1e-13)


def test_slope_is_continuous_at_rest():
    model = Hill(force_velocity=True)
    _, slope = model.force_velocity_factor(np.array([-1e-9, 0.0, 1e-9]))
    assert slope == pytest.approx(np.full(3, 5.0 / model.max_rate), rel=1e-6)


def test_derivatives_against_differences():
    model = Hill(force_velocity=True, overlap=Gaussian())
    generator = np.random.default_rng(0)
    stretch, rate = generator.uniform(0.6, 1.6, 200), generator.uniform(-9.5, 9.5, 200)
    law = model.active_law(np.empty((200, 0)), generator.uniform(0.0, 1.0, 200), stretch)
    assert max(differences(law, stretch, rate)) < 1e-8


def test_effects_switch_the_factors():
    assert tension(Hill(), 0.7, 1.4, -5.0) == 0.7
    assert tension(Hill(force_velocity=True), 0.7, 1.4, -5.0) == pytest.approx(0.7 / 6.0, rel=1e-14)
    bell = np.exp(-(0.4**2) / 0.45)
    assert tension(Hill(overlap=Gaussian()), 0.7, 1.4, -5.0) == pytest.approx(0.7 * bell, rel=1e-14)
    both = build(registry(), "cross_bridge", {"plugin": "hill"}, effects={"force_velocity", "length_dependence"})
    assert tension(both, 0.7, 1.4, -5.0) == pytest.approx(0.7 * bell / 6.0, rel=1e-14)


def test_without_force_velocity_the_law_knows_no_rate():
    law = Hill(overlap=Gaussian()).active_law(NO_STATE, np.ones(1), np.ones(1))
    assert law.evaluate(np.ones(1), np.ones(1)).rate_sensitivity is None


def test_prescribed_tension_is_the_activation():
    model = Prescribed(p_max=1e5)
    law = model.active_law(NO_STATE, np.array([0.3]), np.ones(1)).scaled(np.array([model.p_max]))
    value = law.evaluate(np.array([1.7]), np.array([-4.0]))
    assert value.tension[0] == pytest.approx(3e4, rel=1e-15)
    assert value.stiffness[0] == 0.0
    assert law.potential(np.ones(1)) is None
