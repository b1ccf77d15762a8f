"""Checks of the active law: derivatives against differences, scaling, statics."""

from __future__ import annotations

import numpy as np

from myobridge.errors import PluginError
from myobridge.interfaces import ActiveLaw, Array, CrossBridgeModel
from myobridge.testing.cross_bridge_samples import sample

__all__ = ["check_law_derivatives", "check_law_scales", "check_statics_refused", "check_steady_law", "differences"]

_WIDTHS = (1e-3, 1e-4, 1e-5, 1e-6)


def differences(law: ActiveLaw, stretch: Array, rate: Array) -> tuple[float, float]:
    """Least error of stiffness and rate sensitivity against central differences of decreasing width, relative."""
    value = law.evaluate(stretch, rate)
    sensitivity = np.zeros_like(rate) if value.rate_sensitivity is None else value.rate_sensitivity
    worst = []
    for derivative, by_stretch, by_rate in ((value.stiffness, 1.0, 0.0), (sensitivity, 0.0, 1.0)):
        errors = []
        for h in _WIDTHS:
            high = law.evaluate(stretch + h * by_stretch, rate + h * by_rate).tension
            low = law.evaluate(stretch - h * by_stretch, rate - h * by_rate).tension
            errors.append(np.abs((high - low) / (2.0 * h) - derivative))
        scale = 1.0 + np.abs(derivative) + np.abs(value.tension)
        worst.append(float(np.max(np.min(errors, axis=0) / scale)))
    return worst[0], worst[1]


def check_law_derivatives(model: CrossBridgeModel) -> None:
    """Stiffness and rate sensitivity are the derivatives of the tension."""
    for seed in range(5):
        state, activation, stretch, displacement, _ = sample(model, 8, seed)
        law = model.active_law(state, activation, stretch)
        # Away from the point of expansion, at rates of both signs.
        errors = differences(law, stretch + displacement / model.gear, 20.0 * displacement)
        assert errors[0] <= 1e-8, f"stiffness is off by {errors[0]} (relative)"
        assert errors[1] <= 1e-8, f"rate sensitivity is off by {errors[1]} (relative)"


def check_law_scales(model: CrossBridgeModel) -> None:
    """`scaled` multiplies tension, derivatives, potential and inertance."""
    state, activation, stretch, displacement, _ = sample(model, 4)
    factor = np.array([0.0, 0.5, 2.0, 73e3])
    law = model.active_law(state, activation, stretch)
    scaled = law.scaled(factor)
    point = stretch + displacement / model.gear
    for plain, large in zip(law.evaluate(point, displacement), scaled.evaluate(point, displacement), strict=True):
        assert (plain is None) == (large is None)
        if plain is not None and large is not None:
            assert np.allclose(large, factor * plain, rtol=1e-13, atol=0.0), "scaled law differs from factor times law"
    for plain, large in ((law.potential(point), scaled.potential(point)), (law.inertance, scaled.inertance)):
        assert (plain is None) == (large is None)
        if plain is not None and large is not None:
            assert np.allclose(large, factor * plain, rtol=1e-12, atol=1e-300), "scaled potential or inertance differs"


def check_steady_law(model: CrossBridgeModel) -> None:
    """The steady law is where reactions at rest lead, its derivative is right, and nothing pulls at activation 0."""
    activation, stretch = np.array([0.0, 0.1, 0.4, 1.0]), np.array([1.0, 0.9, 1.0, 1.2])
    law = model.steady_law(activation, stretch)
    tension = law.evaluate(stretch, np.zeros(4)).tension
    assert abs(tension[0]) <= 1e-12, f"steady tension at activation 0 is {tension[0]}"
    assert np.all(tension[1:] > 0.0), f"steady tension is not positive: {tension}"
    assert differences(law, stretch, np.zeros(4))[0] <= 1e-8, "stiffness of the steady law is off"
    state = model.initial_state(4)
    dt = min(2e-3, 0.5 * model.promises.largest_step)
    for _ in range(1500):
        state, _ = model.react(state, activation, stretch, dt, state)
    reached = model.active_law(state, activation, stretch).evaluate(stretch, np.zeros(4)).tension
    # After 3 s heads close to q = 0, which turn over at rates proportional to q, and the step's error are left.
    error = float(np.max(np.abs(reached - tension)))
    assert error <= 0.02, f"reactions at rest lead to {reached}, the steady law says {tension}"


def check_statics_refused(model: CrossBridgeModel) -> None:
    """A model without isometric steady state says so."""
    said = ""
    try:
        model.steady_law(np.ones(1), np.ones(1))
    except PluginError as error:
        said = str(error)
    assert said, "steady_law answers although has_statics is False"
    assert type(model).__name__ in said, f"the error does not name the model: {said}"
