"""Attached fractions stay in [0, 1]: for any step (exact), or up to a known limit and not beyond (explicit schemes)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.window_layout import CELLS, LEFT, PART0, PART1, PARTS, START, ZONE
from myobridge_plugins.cross_bridge.zone_kernels import NEAR

ON = np.ones(1)
step = st.tuples(
    st.floats(1e-9, 0.2),
    st.one_of(st.just(0.0), st.floats(-30.0, 30.0), st.floats(-0.1, 0.1)),
    st.floats(0.0, 1.0),
    st.sampled_from(["advance", "split"]),
)


def _range(model: Huxley, state: np.ndarray) -> tuple[float, float]:
    """Least and greatest attached fraction; those of divided cells too."""
    rho = model.density(state)[1].ravel()
    if model.discretisation == "exact":
        faces = state[0, LEFT:PART0]
        count = int(np.sum(faces[1:] < CELLS)) + 1
        assert np.all(np.diff(faces[: count + 1]) > 0.0)
        assert count < PARTS, "no room for the next cut"
        cut = -state[0, START] * model.bins - state[0, ZONE]
        assert np.min(np.abs(faces - cut)) <= 3.0 * NEAR, "the cut is no face of its zone"
        rho = np.concatenate([rho, state[0, PART0 : PART0 + count], state[0, PART1 : PART1 + count]])
    return float(rho.min()), float(rho.max())


def _shaken(
    model: Huxley, steps: list[tuple[float, float, float, str]], longest: float = np.inf
) -> tuple[float, float]:
    state, low, high = model.initial_state(1), 1.0, 0.0
    for dt, path, r, way in steps:
        dt, activation = min(dt, longest), np.array([r])
        if way == "advance":
            state, _ = model.advance(state, activation, np.zeros(1), np.array([path / model.gear]), dt)
        else:
            state = model.react(model.slide(state, np.array([path])), activation, ON, dt)[0]
        assert np.all(np.isfinite(state))
        least, most = _range(model, state)
        low, high = min(low, least), max(high, most)
        moments = model.moments(state)[0]
        assert moments[0] >= 0.0
        assert moments[0] * moments[2] - moments[1] ** 2 >= -1e-12 * (moments[0] * moments[2])
    return low, high


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    steps=st.lists(step, min_size=1, max_size=15),
    faster=st.sampled_from([1.0, 1e3]),
    g3=st.sampled_from([0.0, 25.0]),
    scales=st.sampled_from(["rate", "fraction"]),
    start=st.sampled_from(["isometric", "empty"]),
)
@example(  # the window moves by as much as the heads slide: its start is where it was
    steps=[(1e-3, 1.0, 1.0, "split"), (1e-3, -1.0, 1.0, "split")], faster=1.0, g3=0.0, scales="rate", start="isometric"
)
def test_exact_for_any_step(steps, faster, g3, scales, start):
    model = Huxley(
        f1=43.3 * faster, g1=10.0 * faster, g2=209.0 * faster, g3=g3 * faster, activation_scales=scales, start=start,
        bins=16,
    )  # fmt: skip
    low, high = _shaken(model, steps)
    assert low >= 0.0
    assert high <= 1.0


@pytest.mark.parametrize(("discretisation", "limit"), [("upwind", 9.569e-3), ("moving_frame_euler", 4.785e-3)])
@settings(max_examples=25, deadline=None, derandomize=True)
@given(steps=st.lists(step, min_size=1, max_size=8))
def test_explicit_below_its_limit(discretisation, limit, steps):
    model = Huxley(discretisation=discretisation, bins=16)
    assert model.promises.largest_step == pytest.approx(limit, rel=1e-4)
    low, high = _shaken(model, steps, model.promises.largest_step)
    assert low >= -1e-15
    assert high <= 1.0 + 1e-14


@pytest.mark.parametrize(("factor", "breaks"), [(0.999, False), (1.02, True)])
@pytest.mark.parametrize("discretisation", ["upwind", "moving_frame_euler"])
def test_explicit_beyond_its_limit(discretisation, factor, breaks):
    """Heads that are released to q < 0 within a step become negative in its last part if it is too long."""
    model = Huxley(discretisation=discretisation)
    state, dt = model.initial_state(1), factor * model.promises.largest_step
    for path in (-0.5, 0.0) if discretisation == "moving_frame_euler" else (-0.5,):
        state, _ = model.advance(state, ON, np.zeros(1), np.array([path / model.gear]), dt)
    assert (_range(model, state)[0] < -1e-4) == breaks


def test_euler_grows_beyond_twice_its_limit():
    model = Huxley(discretisation="moving_frame_euler")
    state = model.slide(model.initial_state(1), np.array([-2.5]))
    before = np.max(np.abs(model.density(state)[1]))
    for _ in range(40):
        state, _ = model.react(state, np.zeros(1), ON, 2.1 / 209.0)
    assert np.max(np.abs(model.density(state)[1])) > 10.0 * before


def test_exact_forgets_in_one_long_step():
    """A second holds more than any explicit step; the population is then nearly isometric."""
    model = Huxley(start="empty")
    state, _ = model.react(model.initial_state(1), ON, ON, 10.0)
    assert model.active_law(state, ON, ON).tension[0] == pytest.approx(1.0, abs=1e-4)
