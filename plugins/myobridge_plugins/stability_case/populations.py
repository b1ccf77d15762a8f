"""Populations on their own: stiff rates, large and sudden sliding, activation that comes and goes."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase

_FURTHER = {
    "huxley upwind": {"cross_bridges.discretisation": "upwind"},
    "huxley moving_frame_euler": {"cross_bridges.discretisation": "moving_frame_euler"},
    "distributed_moment explicit_euler": {
        "cross_bridges.plugin": "distributed_moment",
        "cross_bridges.method": "explicit_euler",
    },
}
_LIMITS = (
    Limit("halvings", 2),
    Limit("out_of_bounds", 1e-12),
    Limit("unrealizable", 1e-12),
    Limit("ledger_drift", 1e-10),
)


@final
class StiffRates(StabilityCase):
    """Rates a thousand times as fast, and a stretch by five reaches within one step."""

    summary = "rates 1000 times faster, a step stretch of 5 reaches in one step of 1 ms, activation a square wave"
    # A stretch of 5 reaches is 5 / gear = 0.0709.
    scene = """
[scene]
name = "stiff_rates"
effects = ["cross_bridges", "activation"]
duration = 0.1
step = 1e-3
[solid]
plugin = "clamp"
path = { plugin = "steps", times = [0.03, 0.031, 0.06, 0.061], values = [1.0, 1.0709, 1.0709, 1.0] }
[cross_bridges]
plugin = "huxley"
f1 = 43.3e3
g1 = 10e3
g2 = 209e3
[activation]
plugin = "square"
frequency = 50.0
pulses = 5
"""
    limits = _LIMITS
    vary = ("cross_bridges", "coupling")
    methods = _FURTHER
    expected: ClassVar = {
        "huxley moving_frame_euler": Expectation("fails", "explicit Euler beyond 1 / max(f + g)"),
        "huxley upwind": Expectation("fails", "explicit Euler beyond 2 / max(f + g)"),
        "distributed_moment explicit_euler": Expectation("fails", "explicit Euler beyond 1 / max(f + g)"),
    }


@final
class NoActivation(StabilityCase):
    """Heads die out."""

    summary = (
        "activation 0 from the start on: the population dies out while the fibre is pulled to and fro, steps of 20 ms"
    )
    scene = """
[scene]
name = "no_activation"
effects = ["cross_bridges", "activation"]
duration = 2.0
step = 2e-2
[solid]
plugin = "clamp"
path = { plugin = "sine", offset = 1.0, amplitude = 0.02, frequency = 2.0 }
[cross_bridges]
plugin = "huxley"
[activation]
plugin = "constant"
level = 0.0
"""
    limits = _LIMITS
    vary = ("cross_bridges", "coupling")
    methods = _FURTHER
    expected: ClassVar = {
        "distributed_moment explicit_euler": Expectation("fails", "explicit Euler beyond 1 / max(f + g)"),
    }


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"stiff_rates": StiffRates, "no_activation": NoActivation}
