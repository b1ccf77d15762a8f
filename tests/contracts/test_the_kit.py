"""The contract checks catch what they are for: a sound model with one fault fails the check that names it."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

from myobridge.interfaces import AffineLaw, CrossBridgeModel, Fluxes, Promises, Signal
from myobridge.parameters import number, text
from myobridge.testing import cross_bridge_checks, signal_checks
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.signal.ramp import Ramp

SOUND = DistributedMoment(method="extrapolated")


@attrs.frozen
class Faulty(CrossBridgeModel):
    """The distributed-moment model with one fault."""

    summary: ClassVar[str] = "a model with a fault"
    p_max: float = number(73e3, unit="Pa", doc="isometric tension")
    fault: str = text("", doc="which fault")

    gear = SOUND.gear
    promises = Promises(bounds=False, order=2)

    def initial_state(self, n_sites: int) -> Any:
        state = SOUND.initial_state(n_sites)
        return np.asfortranarray(state) if self.fault == "layout" else state

    def react(self, state: Any, activation: Any, stretch: Any, dt: float, out: Any = None) -> Any:
        if self.fault == "writes" and out is None:
            activation *= 0.5
        if self.fault == "no out":
            out = None
        if self.fault == "neighbours":
            activation = np.full_like(activation, activation.mean())
        new, fluxes = SOUND.react(state, activation, stretch, dt, out)
        if self.fault == "loses energy":
            fluxes = Fluxes(fluxes.attached, 0.9 * fluxes.detached, fluxes.work, fluxes.numerical)
        if self.fault == "unrealizable":
            new[:, 2] = np.minimum(new[:, 2], 0.5 * new[:, 1] ** 2 / np.maximum(new[:, 0], 1e-300))
        if self.fault == "nan at rest":
            new[:, 1] += 0.0 * new[:, 0] / np.where(activation > 0.0, 1.0, np.nan)
        if self.fault == "first order":
            new, fluxes = DistributedMoment().react(state, activation, stretch, dt, out)
        return new, fluxes

    def slide(self, state: Any, displacement: Any, out: Any = None) -> Any:
        new = SOUND.slide(state, displacement, out)
        if self.fault == "loses heads":
            new[:, 0] *= 1.0 - 1e-6 * np.abs(displacement)
        if self.fault == "slides short":
            new[:, 2] -= 1e-3 * displacement
        return new

    def slide_and_gain(self, state: Any, displacement: Any, out: Any = None) -> Any:
        new, gained = super().slide_and_gain(state, displacement, out)
        return new, (1.0 + 1e-6) * gained if self.fault == "gains too much" else gained

    def active_law(self, state: Any, activation: Any, stretch: Any) -> Any:
        law: Any = SOUND.active_law(state, activation, stretch)
        if self.fault == "stiffness":
            return Stiff(law.stretch, law.tension, law.stiffness)
        return law

    def steady_law(self, activation: Any, stretch: Any) -> Any:
        factor = 1.1 if self.fault == "steady" else 1.0
        return SOUND.steady_law(activation, stretch).scaled(np.full_like(activation, factor))

    def moments(self, state: Any) -> Any:
        return state.copy()

    def energy(self, state: Any) -> Any:
        return SOUND.energy(state) * (1.01 if self.fault == "energy unit" else 1.0)


class Stiff(AffineLaw):  # pyright: ignore[reportGeneralTypeIssues]
    """Affine law that tells a wrong stiffness."""

    def evaluate(self, stretch: Any, stretch_rate: Any) -> Any:
        value = super().evaluate(stretch, stretch_rate)
        return value._replace(stiffness=1.001 * value.stiffness)

    def scaled(self, factor: Any) -> Any:
        return Stiff(self.stretch, factor * self.tension, factor * self.stiffness)


def failing(model: CrossBridgeModel) -> set[str]:
    names = set()
    for check in cross_bridge_checks(model):
        try:
            check()
        except AssertionError:
            names.add(check.__name__.removeprefix("check_"))
    return names


def test_the_sound_model_passes():
    assert failing(Faulty()) == set()


@pytest.mark.parametrize(
    ("fault", "check"),
    [
        ("layout", "shapes"),
        ("writes", "inputs_unchanged"),
        ("no out", "out"),
        ("neighbours", "batch_is_single"),
        ("gains too much", "gain_of_slide"),
        ("loses energy", "fluxes_of_react"),
        ("loses energy", "fluxes_of_advance"),
        ("unrealizable", "realizable"),
        ("nan at rest", "zero_activation"),
        ("first order", "order"),
        ("loses heads", "conserves_heads"),
        ("slides short", "exact_slide"),
        ("stiffness", "law_derivatives"),
        ("steady", "steady_law"),
        ("energy unit", "exact_slide"),
    ],
)
def test_a_fault_fails_its_check(fault, check):
    checks = {item.__name__.removeprefix("check_"): item for item in cross_bridge_checks(Faulty(fault=fault))}
    with pytest.raises(AssertionError):
        checks[check]()


class WrongMean(Signal):
    """A ramp whose mean is the value at the end."""

    ramp = Ramp(final=1.0, end=0.5)

    def value(self, time: float) -> Any:
        return self.ramp.value(time)

    def mean(self, start: float, end: float) -> Any:
        return self.ramp.value(end)


def test_signal_checks_catch_a_wrong_mean():
    caught = []
    for check in signal_checks(WrongMean()):
        try:
            check()
        except AssertionError:
            caught.append(check.__name__)
    assert "check_mean_is_the_integral" in caught
