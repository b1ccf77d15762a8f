"""Explicit methods where theory knows them: growth at the rate omega^2 dt / 2, and the limit 2 / omega_max."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, final

from myobridge.atlas import exact_largest_frequency
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge.simulation import Simulation
from myobridge.statics import Statics
from myobridge_plugins.stability_case.scenes import FURTHER_INTEGRATORS, RELEASE

_GROWS = "explicit Euler on an undamped oscillator: the amplitude grows at the rate omega^2 dt / 2"


def _growth(composed: Simulation | Statics) -> Mapping[str, float]:
    assert isinstance(composed, Simulation)
    omega = exact_largest_frequency(composed.solid)
    return {"growth_rate": 0.5 * omega**2 * composed.control.dt}


@final
class SpringGrowth(StabilityCase):
    """One oscillator."""

    summary = "an undamped spring of 1000 rad/s, 1000 steps of 0.1 ms"
    scene = """
[scene]
name = "oscillator"
effects = ["inertia"]
duration = 0.1
step = 1e-4
[solid]
plugin = "spring"
mass = 1.0
stiffness = 1e6
displacement = 1e-3
"""
    limits = (Limit("halvings", 2), Limit("energy_growth", 0.3))
    vary = ("integrator",)
    methods = FURTHER_INTEGRATORS
    expected: ClassVar = {"half_explicit": Expectation("fails", _GROWS, {"growth_rate": 0.1})}

    def predicted(self, composed: Simulation | Statics) -> Mapping[str, float]:
        return _growth(composed)


@final
class BlockGrowth(StabilityCase):
    """The fastest mode of a body."""

    summary = "a strictly incompressible block, released from 1 Pa, 0.02 s in steps of 10 us"
    scene = RELEASE.replace(', "viscosity"', "")
    variants: ClassVar = {
        "": {
            "scene.step": 1e-5,
            "scene.duration": 0.02,
            "solid.mesh.cells": [8, 2],
            "load[0].traction": [1.0, 0.0],
        }
    }
    limits = (Limit("halvings", 2), Limit("energy_growth", 0.1))
    methods: ClassVar = {
        "half_explicit": {"integrator.plugin": "half_explicit"},
        "rattle": {"integrator.plugin": "rattle"},
    }
    expected: ClassVar = {"half_explicit": Expectation("fails", _GROWS, {"growth_rate": 0.1})}
    bisect = False

    def predicted(self, composed: Simulation | Statics) -> Mapping[str, float]:
        return _growth(composed)


@final
class RattleLimit(StabilityCase):
    """Below and beyond the limit."""

    summary = "a strictly incompressible block, released from 1 kPa, below and beyond the limit of rattle"
    scene = RELEASE.replace(', "viscosity"', "")
    variants: ClassVar = {
        f"{dt:g}": {"scene.step": dt, "scene.duration": 0.01, "load[0].traction": [1e3, 0.0]} for dt in (6e-5, 1e-4)
    }
    limits = (Limit("halvings", 0), Limit("energy_growth", 0.05), Limit("constraint_error", 1e-10))
    methods: ClassVar = {
        "rattle unlimited": {"integrator.plugin": "rattle", "integrator.limit": "ignore"},
    }
    expected: ClassVar = {
        "6e-05:rattle unlimited": Expectation("holds", "below 2 / omega_max", {"largest_step": 0.1}),
        "0.0001:rattle unlimited": Expectation("fails", "beyond 2 / omega_max"),
    }

    def predicted(self, composed: Simulation | Statics) -> Mapping[str, float]:
        assert isinstance(composed, Simulation)
        return {"largest_step": 2.0 / exact_largest_frequency(composed.solid)}


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"spring_growth": SpringGrowth, "block_growth": BlockGrowth, "rattle_limit": RattleLimit}
