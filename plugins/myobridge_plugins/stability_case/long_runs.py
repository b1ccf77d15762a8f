"""Long runs: what drifts slowly shows."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import FURTHER_INTEGRATORS, RELEASE


@final
class LongSpring(StabilityCase):
    """A hundred thousand steps of an oscillator with heads that never let go."""

    summary = "a spring with frozen heads, 0.2 rad a step: 10 000 steps, in the full atlas 100 000"
    scene = """
[scene]
name = "long_spring"
effects = ["inertia", "cross_bridges"]
duration = 100.0
step = 0.01
[solid]
plugin = "spring"
mass = 1.0
stiffness = 300.0
displacement = 0.001
area = 1e-6
[cross_bridges]
plugin = "liouville"
p_max = 70e3
"""
    longer: ClassVar = {"scene.duration": 1000.0}
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-8), Limit("energy_loss", 1e-8))
    vary = ("integrator",)
    methods = FURTHER_INTEGRATORS
    expected: ClassVar = {
        "backward_euler": Expectation("fails", "it damps"),
        "half_explicit": Expectation("fails", "it grows at the rate omega^2 dt / 2"),
    }
    bisect = False
    seconds = 300.0


@final
class LongBlock(StabilityCase):
    """Ten thousand steps of a small body."""

    summary = "a 30 % release of a small block without viscosity: 300 steps of 1 ms, in the full atlas 10 000"
    scene = RELEASE.replace(', "viscosity"', "").replace("duration = 0.2", "duration = 0.3")
    variants: ClassVar = {"": {"solid.mesh.cells": [4, 1]}}
    longer: ClassVar = {"scene.duration": 10.0}
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-9), Limit("energy_loss", 1e-9))
    vary = ("integrator",)
    bisect = False
    seconds = 900.0


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"long_spring": LongSpring, "long_block": LongBlock}
