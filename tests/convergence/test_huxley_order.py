"""Observed orders of Huxley's discretisations in the width of a cell and in the step."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from myobridge_plugins.cross_bridge.exact_solution import exact_moments
from myobridge_plugins.cross_bridge.huxley import Huxley

ON = np.ones(1)


def _error(model: Huxley, times: np.ndarray, positions: np.ndarray, skip: int = 1, parts: int = 1) -> float:
    """Greatest error of a moment relative to its greatest value.

    The model sees every `skip`-th corner of the path, and goes from one to the next in `parts` equal steps.
    """
    exact = exact_moments(model.rates, times, positions, model.start == "isometric")[::skip]
    state, found = model.initial_state(1), [model.moments(model.initial_state(1))[0]]
    dt = (times[skip] - times[0]) / parts
    for before, after in itertools.pairwise(positions[::skip]):
        change = np.array([(after - before) / model.gear / parts])
        for _ in range(parts):
            state, _ = model.advance(state, ON, np.zeros(1), change, dt, state)
        found.append(model.moments(state)[0])
    return float(np.max(np.max(np.abs(np.array(found) - exact), axis=0) / np.max(np.abs(exact), axis=0)))


def _slope(x: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(x), np.log(errors), 1)[0])


@pytest.mark.parametrize(("discretisation", "parts", "expected"), [("exact", 1, 2.0), ("upwind", 40, 1.0)])
def test_order_in_the_width_of_a_cell(discretisation, parts, expected):
    """From rest at constant speed: kinks only, no jumps."""
    times = 1e-3 * np.arange(31)
    bins = [16, 32, 64, 128]
    models = [Huxley(discretisation=discretisation, bins=n, start="empty") for n in bins]
    errors = [_error(model, times, -40.0 * times, parts=parts) for model in models]
    order = -_slope([float(n) for n in bins], errors)
    message = f"{discretisation}: observed order {order:.2f} in dq, expected {expected}; errors {errors} at {bins} bins"
    print(message)
    assert abs(order - expected) <= 0.15, message


def test_order_in_the_step():
    """On a sine; the exact scheme is exact at constant speed, so this is the error of the path alone."""
    fine = 1e-2 / 512 * np.arange(1025)
    path = 0.4 * np.sin(2.0 * np.pi * 50.0 * fine)
    skips = [64, 32, 16]
    errors = [_error(Huxley(bins=256), fine, path, skip) for skip in skips]
    order = _slope([float(skip) for skip in skips], errors)
    message = f"observed order {order:.2f} in dt, expected 2; errors {errors}"
    print(message)
    assert abs(order - 2.0) <= 0.15, message


def test_order_of_the_splitting():
    """React, slide, react, as a solid does it."""
    errors = []
    times = np.linspace(0.0, 0.02, 1025)
    path = 0.4 * np.sin(2.0 * np.pi * 50.0 * times)
    model = Huxley(bins=256)
    exact = exact_moments(model.rates, times, path)[-1]
    counts = [16, 32, 64]
    for n in counts:
        state, dt = model.initial_state(1), 0.02 / n
        for before, after in itertools.pairwise(path[:: 1024 // n]):
            state, _ = model.react(state, ON, ON, 0.5 * dt, state)
            state = model.slide(state, np.array([after - before]), state)
            state, _ = model.react(state, ON, ON, 0.5 * dt, state)
        errors.append(float(np.max(np.abs(model.moments(state)[0] - exact))))
    order = -_slope([float(n) for n in counts], errors)
    message = f"observed order {order:.2f} in dt, expected 2; errors {errors} in {counts} steps"
    print(message)
    assert order >= 1.85, message
