"""Liouville and discrete heads: closed forms, convergence of one to the other, the multiplier with mass."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from myobridge.build import build
from myobridge.errors import ParameterError
from myobridge.registry import registry
from myobridge.testing import fitted_order
from myobridge_plugins.cross_bridge.discrete import Discrete
from myobridge_plugins.cross_bridge.liouville import Liouville

F1 = 43.3 / 53.3


def tension(model, state: np.ndarray) -> np.ndarray:
    n = len(state)
    return model.active_law(state, np.ones(n), np.ones(n)).evaluate(np.ones(n), np.zeros(n)).tension


def test_initial_population_is_huxleys_isometric_one_and_pulls_with_p_max():
    model = Liouville()
    state = model.initial_state(2)
    assert model.moments(state)[1] == pytest.approx([F1, F1 / 2.0, F1 / 3.0], rel=1e-14)
    assert tension(model, state) == pytest.approx([1.0, 1.0], rel=1e-14)


@given(x=st.floats(-20.0, 20.0), y=st.floats(-20.0, 20.0))
def test_sliding_is_a_translation(x, y):
    """Moments of the translated uniform density in closed form; two slides are one; there and back is nothing."""
    model = Liouville()
    state = model.initial_state(1)
    once = model.slide(state, np.array([x]))
    assert once[0] == pytest.approx([F1, F1 * (x + 0.5), F1 * ((x + 0.5) ** 2 + 1.0 / 12.0)], rel=1e-12, abs=1e-12)
    twice = model.slide(once, np.array([y]))
    assert twice == pytest.approx(model.slide(state, np.array([x + y])), rel=1e-11, abs=1e-11)
    assert model.slide(once, np.array([-x])) == pytest.approx(state, abs=1e-11)


@pytest.mark.parametrize("model", [Liouville(), Discrete(), Discrete(sampling="random", heads=7)], ids=repr)
def test_work_of_a_closed_path_is_zero_and_of_an_open_one_the_energy(model):
    """Integral of tension over stretch by Simpson (exact, tension is affine) against the stored energy."""
    state, stretch, work = model.initial_state(3), 1.0, np.zeros(3)
    first = model.energy(state)
    for change in (0.02, -0.05, 0.01, 0.02):
        half = model.slide(state, np.full(3, 0.5 * change * model.gear))
        end = model.slide(state, np.full(3, change * model.gear))
        piece = change / 6.0 * (tension(model, state) + 4.0 * tension(model, half) + tension(model, end))
        work += piece
        assert model.energy(end) - model.energy(state) == pytest.approx(piece, rel=1e-10)
        assert np.max(np.abs(piece)) > 1e-3
        state, stretch = end, stretch + change
    assert stretch == pytest.approx(1.0)
    assert work == pytest.approx(np.zeros(3), abs=1e-15)
    assert model.energy(state) == pytest.approx(first, rel=1e-13)


def test_stratified_heads_converge_to_liouville_with_order_2():
    exact = Liouville().initial_state(1)[0]
    counts = (4, 8, 16, 32, 64)
    errors = []
    for heads in counts:
        model = Discrete(heads=heads)
        found = model.moments(model.initial_state(1))[0]
        assert found[:2] == pytest.approx(exact[:2], rel=1e-14)
        errors.append(abs(found[2] - exact[2]))
    observed = fitted_order([1.0 / n for n in counts], errors)
    assert observed == pytest.approx(2.0, abs=0.01), f"observed order {observed:.3f}, errors {errors}"


def test_random_heads_converge_to_liouville_like_a_mean():
    """Root mean square over 2000 sites: the standard error of the mean of a uniform density, 1/sqrt(12 N)."""
    for heads in (10, 1000):
        model = Discrete(heads=heads, sampling="random", seed=3)
        first = model.moments(model.initial_state(2000))[:, 1] / F1
        spread = float(np.sqrt(np.mean((first - 0.5) ** 2)))
        # The spread of 2000 samples is itself known to 1/sqrt(4000) = 1.6 %, here four times that.
        assert spread == pytest.approx(1.0 / np.sqrt(12.0 * heads), rel=0.064)


def test_sample_is_seeded_and_does_not_depend_on_the_number_of_sites():
    model = Discrete(sampling="random", seed=5)
    assert np.array_equal(model.initial_state(3), model.initial_state(9)[:3])
    assert not np.array_equal(model.initial_state(3), Discrete(sampling="random", seed=6).initial_state(3))


def test_multiplier_of_heads_with_mass():
    """mu_i = kappa q_i + m q_f'': the law with its inertance is the sum of the multipliers over the heads."""
    mass, stiffness, reach, half = 2e-14, 2e-3, 15.6e-9, 1.1e-6
    model = Discrete(heads=5, head_mass=mass, head_stiffness=stiffness, reach=reach, half_sarcomere_length=half)
    state = model.initial_state(1)
    law = model.active_law(state, np.ones(1), np.ones(1)).scaled(np.array([model.p_max]))
    acceleration = 3.7e7  # of the stretch [1/s2]
    multipliers = stiffness * reach * state[0] + mass * half * acceleration  # [N]
    # All heads at the isometric mean h/2 pull with p_max: that fixes how many there are per area.
    per_head = model.p_max / (stiffness * reach * 0.5)
    expected = per_head * float(np.mean(multipliers))
    assert law.inertance is not None
    found = law.evaluate(np.ones(1), np.zeros(1)).tension[0] + law.inertance[0] * acceleration
    assert found == pytest.approx(expected, rel=1e-12)
    assert law.inertance[0] * acceleration > 1e-6 * found


def test_mass_is_an_effect_of_the_scene():
    plain = build(registry(), "cross_bridge", {"plugin": "discrete"}, effects={"cross_bridges"})
    heavy = build(registry(), "cross_bridge", {"plugin": "discrete"}, effects={"cross_bridges", "cross_bridge_mass"})
    assert plain.active_law(plain.initial_state(1), np.ones(1), np.ones(1)).inertance is None
    assert heavy.active_law(heavy.initial_state(1), np.ones(1), np.ones(1)).inertance[0] > 0.0
    with pytest.raises(ParameterError, match="cross_bridge_mass"):
        build(registry(), "cross_bridge", {"plugin": "discrete", "head_mass": 1e-22}, effects={"cross_bridges"})
