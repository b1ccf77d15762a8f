"""Bodies in free flight: nothing acts on them, so nothing may change that is conserved."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import BLOCK, FURTHER_INTEGRATORS

_FLIGHT = f"""
[scene]
name = "flight"
effects = ["inertia", "incompressibility"]
duration = 0.1
step = 1e-3
{BLOCK}
"""
_KEPT = (
    Limit("halvings", 2),
    Limit("momentum_drift", 1e-10),
    Limit("angular_momentum_drift", 1e-10),
    Limit("energy_growth", 1e-10),
    Limit("energy_loss", 1e-10),
)


@final
class FreeFlight(StabilityCase):
    """Stretched, turning, flying."""

    summary = "free flight of a block stretched by 20 % and turning at 20 rad/s, 100 steps of 1 ms"
    scene = (
        _FLIGHT
        + """
stretch_at_start = [1.2, 0.8333333333333334]
velocity_at_start = [0.3, 0.1]
spin_at_start = 20.0
"""
    )
    limits = _KEPT
    vary = ("integrator",)
    methods = FURTHER_INTEGRATORS
    expected: ClassVar = {
        "generalised_alpha*": Expectation("fails", "it damps"),
        "backward_euler": Expectation("fails", "it damps"),
        "bdf2": Expectation("fails", "it damps"),
        "bathe": Expectation("fails", "it damps"),
    }
    bisect = False


@final
class TenTurns(StabilityCase):
    """Large rotations in large steps."""

    summary = "ten turns of a block in 200 steps of 18 degrees"
    scene = (
        _FLIGHT.replace("duration = 0.1", "duration = 1.0").replace("step = 1e-3", "step = 5e-3")
        + """
spin_at_start = 62.83185307179586
"""
    )
    variants: ClassVar = {"": {"solid.mesh.cells": [4, 1]}}
    # It rests, so there is no momentum; Newton's tolerance adds up over a second.
    limits = (
        Limit("halvings", 2),
        Limit("angular_momentum_drift", 1e-9),
        Limit("energy_growth", 1e-9),
        Limit("energy_loss", 1e-9),
    )
    vary = ("integrator",)
    bisect = False


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"free_flight": FreeFlight, "ten_turns": TenTurns}
