"""Checks of energy: the law's potential, the work of sliding, the balance of the fluxes."""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import CrossBridgeModel
from myobridge.testing.cross_bridge_samples import sample

__all__ = [
    "check_exact_slide",
    "check_fluxes_of_advance",
    "check_fluxes_of_react",
    "check_gain_of_slide",
    "check_law_potential",
]


def check_law_potential(model: CrossBridgeModel) -> None:
    """A model that stores energy has a law with a potential, whose derivative is the tension."""
    state, activation, stretch, displacement, _ = sample(model, 6)
    law = model.active_law(state, activation, stretch)
    point, h = stretch + displacement / model.gear, 1e-5
    high, low = law.potential(point + h), law.potential(point - h)
    assert high is not None, "has_energy is True, but the law has no potential"
    assert low is not None
    tension = law.evaluate(point, np.zeros(6)).tension
    error = float(np.max(np.abs((high - low) / (2.0 * h) - tension) / (1.0 + np.abs(tension))))
    assert error <= 1e-8, f"the potential's derivative differs from the tension by {error} (relative)"


def check_exact_slide(model: CrossBridgeModel) -> None:
    """Sliding changes the stored energy by the work of the frozen law, and leads to the tension the law foretold."""
    moved = 0.0
    for seed in range(5):
        state, activation, stretch, displacement, _ = sample(model, 6, seed)
        law = model.active_law(state, activation, stretch)
        end = stretch + displacement / model.gear
        after = model.slide(state, displacement)
        work, start = law.potential(end), law.potential(stretch)
        assert work is not None, "has_energy is True, but the law has no potential"
        assert start is not None
        change = model.energy(after) - model.energy(state)
        scale = model.energy(after) + model.energy(state)
        error = float(np.max(np.abs(change - (work - start)) / np.maximum(scale, 1e-300)))
        assert error <= 1e-12, f"energy changes by {change}, the work is {work - start} (relative error {error})"
        rest = np.zeros(6)
        foretold = law.evaluate(end, rest).tension
        found = model.active_law(after, activation, end).evaluate(end, rest).tension
        error = float(np.max(np.abs(found - foretold)))
        assert error <= 1e-11, f"tension after sliding differs from the law by {error} (p_max)"
        moved = max(moved, float(np.max(np.abs(change) / np.maximum(scale, 1e-300))))
    assert moved > 1e-3, "nothing moved: the check has no force on this model"


def check_gain_of_slide(model: CrossBridgeModel) -> None:
    """`slide_and_gain` slides as `slide` does, and says what that adds to the energy; in place too."""
    for seed in range(5):
        state, _, _, displacement, _ = sample(model, 6, seed)
        expected, before = model.slide(state, displacement), model.energy(state)
        after, gained = model.slide_and_gain(state, displacement)
        assert np.array_equal(after, expected), "slide_and_gain leads elsewhere than slide"
        change = model.energy(expected) - before
        scale = np.maximum(model.energy(expected) + before, 1e-300)
        error = float(np.max(np.abs(gained - change) / scale))
        assert error <= 1e-12, f"energy changes by {change}, slide_and_gain says {gained} (relative error {error})"
        place = state.copy()
        again, same = model.slide_and_gain(place, displacement, place)
        assert np.array_equal(again, expected), "slide_and_gain in place leads elsewhere"
        assert np.array_equal(same, gained), "slide_and_gain in place gains something else"


def check_fluxes_of_react(model: CrossBridgeModel) -> None:
    """Energy after minus before is what attached minus what detached (plus what the numerics did); no work."""
    for seed in range(5):
        state, activation, stretch, _, dt = sample(model, 6, seed)
        after, fluxes = model.react(state, activation, stretch, dt)
        assert not np.any(fluxes.work), f"a reaction at held filaments did work: {fluxes.work}"
        _balance(model, state, after, fluxes)


def check_fluxes_of_advance(model: CrossBridgeModel) -> None:
    """The same along a path, with the work."""
    for seed in range(5):
        state, activation, stretch, displacement, dt = sample(model, 6, seed)
        after, fluxes = model.advance(state, activation, stretch, stretch + displacement / model.gear, dt)
        _balance(model, state, after, fluxes)


def _balance(model, before, after, fluxes) -> None:
    change = model.energy(after) - model.energy(before)
    booked = fluxes.attached - fluxes.detached + fluxes.work + fluxes.numerical
    scale = model.energy(after) + model.energy(before) + sum(np.abs(item) for item in fluxes)
    error = float(np.max(np.abs(change - booked) / np.maximum(scale, 1e-300)))
    assert error <= 1e-11, f"energy changes by {change}, booked are {booked} (relative error {error})"
