"""Error of the exact scheme along paths that were invented to hurt it, against the solution by characteristics."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from myobridge_plugins.cross_bridge.exact_solution import exact_moments
from myobridge_plugins.cross_bridge.huxley import Huxley

STEP = 1.25e-3
REFERENCE = Path(__file__).parents[3] / "shared" / "reference"
# The error of a moment is its greatest difference over the greatest value of that moment.
CONSTANT_SPEED = 6e-4
ANY_PATH = 7.2e-3
# Speeds are within v_max: at constant greater ones heads travel so far that the default window ends too early.


def _joined(*parts: tuple[float, int]) -> np.ndarray:
    """Speeds [1/s]: each part is (speed, number of steps)."""
    return np.concatenate([np.full(count, float(speed)) for speed, count in parts])


def _at_once(x: float) -> float:
    """Speed of a displacement `x` within one step."""
    return x / STEP


def _random(seed: int, n_steps: int = 240) -> np.ndarray:
    """Holds, walks, creeps and jolts in random order."""
    generator = np.random.default_rng(seed)
    longest, parts = int(generator.integers(3, 40)), []
    while sum(count for _, count in parts) < n_steps:
        count = int(generator.integers(1, longest + 1))
        spread = (0.0, 60.0, 1.5, 300.0 / count)[generator.integers(0, 4)]
        parts.append((float(generator.normal()) * spread, count))
    return _joined(*parts)[:n_steps]


CONSTANT = {f"{v:+g}": _joined((v, 100)) for v in (-100, -60, -30, -7, 30, 100)}
NASTY = {
    **{f"creep {v:+g}": _joined((v, 240)) for v in (-3.0, -1.0, -0.3, -0.05, 0.05, 0.3, 1.0, 3.0, 10.0)},
    "stop after shortening": _joined((-61.3, 17), (0, 200)),
    "stop after lengthening": _joined((53.7, 13), (0, 200)),
    "stop within a cell": _joined((0.5 / 32 / 3 / STEP, 3), (0, 240)),
    "stop, on": _joined((-37.1, 5), (0, 160), (-41.7, 40)),
    "stop, back": _joined((33.3, 7), (0, 160), (-47.0, 40), (0, 100)),
    "stop, creep shorter": _joined((33.3, 7), (0, 160), (-0.21, 200)),
    "stop, creep longer": _joined((-33.3, 7), (0, 160), (0.21, 200)),
    "quick release": _joined((_at_once(-0.37), 1), (0, 200)),
    "quick release within a cell": _joined((0, 40), (_at_once(-0.0156), 1), (0, 240)),
    "quick stretch": _joined((_at_once(0.43), 1), (0, 200)),
    "release beyond the reach": _joined((_at_once(-1.7), 1), (0, 200)),
    "stretch by just the reach": _joined((_at_once(1.013), 1), (0, 200)),
    "release and restretch": _joined(*(((0, 40), (_at_once(-0.437), 1), (0, 3), (_at_once(0.437), 1)) * 3), (0, 60)),
    "part of it back": _joined(*(((0, 40), (_at_once(-0.337), 1), (0, 30), (_at_once(0.237), 1)) * 3)),
    "stairs down": _joined(*(((0, 24), (_at_once(-0.111), 1)) * 10)),
    "stairs up": _joined(*(((0, 24), (_at_once(0.0871), 1)) * 10)),
    "small stairs": _joined(*(((0, 8), (_at_once(-0.0103), 1)) * 30)),
    "buzz": _joined(*(((8.0, 1), (-8.0, 1)) * 120)),
    "buzz of a cell": _joined(*(((12.5, 2), (-12.5, 2)) * 70)),
    "buzz of two cells": _joined(*(((25.0, 2), (-25.0, 2)) * 70)),
    "buzz of three cells": _joined(*(((25.0, 3), (-25.0, 3)) * 50)),
    "wobble": 20.0 * np.sin(0.31 * np.arange(240)),
    "slow sine": 5.0 * np.cos(4.0 * np.pi * STEP * np.arange(320)),
    "fast sine": 200.0 * np.cos(40.0 * np.pi * STEP * np.arange(160)),
    "ever faster, then back": np.linspace(-120.0, 120.0, 200),
    "coming to rest, shortening": -80.0 * np.exp(-0.03 * np.arange(240)),
    "coming to rest, lengthening": 80.0 * np.exp(-0.03 * np.arange(240)),
    "ever smaller reversals": 60.0 * (-0.93) ** np.arange(240),
    **{f"random {seed}": _random(seed) for seed in range(8)},
    **{f"noise {s}": s * np.random.default_rng(int(s)).normal(size=240) for s in (5.0, 20.0, 60.0, 150.0)},
}


def _path(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return STEP * np.arange(speeds.size + 1), np.concatenate([[0.0], np.cumsum(STEP * speeds)])


def _moments(model: Huxley, positions: np.ndarray, dt: float = STEP) -> np.ndarray:
    """Moments after each step of `advance`, shape (n_times, 3)."""
    state, on = model.initial_state(1), np.ones(1)
    found = [model.moments(state)[0]]
    for before, after in itertools.pairwise(positions):
        # Stretches are counted from the position, so that no digits are lost in them.
        state, _ = model.advance(state, on, np.zeros(1), np.array([(after - before) / model.gear]), dt, state)
        found.append(model.moments(state)[0])
    return np.array(found)


def _error(speeds: np.ndarray, start: str, bins: int = 32) -> np.ndarray:
    """Greatest difference of each moment over its greatest value, shape (3,)."""
    times, positions = _path(speeds)
    model = Huxley(start=start, bins=bins)
    exact = exact_moments(model.rates, times, positions, start == "isometric")
    return np.max(np.abs(_moments(model, positions) - exact), axis=0) / np.max(np.abs(exact), axis=0)


@pytest.mark.parametrize("start", ["isometric", "empty"])
@pytest.mark.parametrize("name", CONSTANT)
def test_constant_speed(name, start):
    error = _error(CONSTANT[name], start)
    assert np.max(error) <= CONSTANT_SPEED, f"error of the moments {error}"


@pytest.mark.parametrize("start", ["isometric", "empty"])
@pytest.mark.parametrize("name", NASTY)
def test_nasty_path(name, start):
    error = _error(NASTY[name], start)
    assert np.max(error) <= ANY_PATH, f"error of the moments {error}"


speed = st.one_of(st.just(0.0), st.floats(-100.0, 100.0), st.floats(-3.0, 3.0), st.sampled_from([-12.5, 12.5, -25.0]))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    parts=st.lists(st.tuples(speed, st.integers(1, 40)), min_size=1, max_size=12),
    start=st.sampled_from(["isometric", "empty"]),
)
@example(parts=[(0.0, 8), (5e-324, 1)], start="isometric")
def test_any_path(parts, start):
    parts = [*parts, (0.0, 20)]  # an empty population must first attach before an error can be relative to it
    error = _error(_joined(*parts), start)
    assert np.max(error) <= ANY_PATH, f"error of the moments {error}"


@pytest.mark.parametrize(
    "name", ["v+0_iso", "v+0_zero", "v-100_iso", "v-100_zero", "v-30_iso", "v+100_iso", "v+100_zero"]
)
def test_recorded_trajectory(name):
    file = REFERENCE / f"traj_{name}.csv"
    if not file.exists():
        pytest.skip("the recorded trajectories are not shipped with the sources")
    times, positions, *moments = np.loadtxt(file, delimiter=",").T
    recorded = np.array(moments).T
    start = "isometric" if name.endswith("iso") else "empty"
    exact = exact_moments(Huxley().rates, times, positions, start == "isometric")
    assert np.max(np.abs(exact - recorded)) <= 1e-13
    # The finest steps that hit the recorded times and are not longer than STEP.
    parts = int(np.ceil((times[1] - times[0]) / STEP - 1e-9))
    fine = np.interp(np.arange(parts * (times.size - 1) + 1) / parts, np.arange(times.size), positions)
    found = _moments(Huxley(start=start), fine, (times[1] - times[0]) / parts)[::parts]
    error = np.max(np.abs(found - recorded), axis=0) / np.max(np.abs(recorded), axis=0)
    assert np.max(error) <= CONSTANT_SPEED, f"error of the moments {error}"
