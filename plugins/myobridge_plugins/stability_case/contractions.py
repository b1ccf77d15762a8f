"""The complete model in motion: incompressible tissue with a population at every point, made hard in every way."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import FURTHER_INTEGRATORS

_EXPLICIT = Expectation("fails", "explicit, and the step is far beyond its limit")


@final
class Contraction(StabilityCase):
    """A free end, an inhomogeneous activation, and heads that are stiffer or faster than any."""

    summary = "active contraction of a strictly incompressible block with a free end, 100 steps of 1 ms"
    scene = """
[scene]
name = "contraction"
effects = ["inertia", "incompressibility", "cross_bridges", "activation"]
duration = 0.1
step = 1e-3
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025], cells = [8, 2] }
material = { plugin = "mooney_rivlin", parameters = "thesis" }
[[support]]
boundary = "left"
[cross_bridges]
plugin = "huxley"
start = "empty"
[activation]
plugin = "ramp"
end = 0.01
final = 1.0
"""
    variants: ClassVar = {
        "plain": {},
        # Stiffness is p_max times the gear: a reach a hundred times shorter.
        "stiffness x 100": {"cross_bridges.reach": 15.6e-11},
        "rates x 1e3": {
            "cross_bridges.f1": 43.3e3,
            "cross_bridges.g1": 10e3,
            "cross_bridges.g2": 209e3,
        },
        "50 Hz": {"activation.plugin": "square", "activation.frequency": 50.0, "activation.pulses": 5},
        "kappa 1e6": {"solid.bulk_modulus": 1e6},
    }
    limits = (
        Limit("halvings", 2),
        Limit("energy_growth", 1e-6),
        Limit("constraint_error", 1e-10),
        Limit("out_of_bounds", 1e-12),
        Limit("unrealizable", 1e-12),
    )
    vary = ("integrator", "coupling", "cross_bridges")
    methods = FURTHER_INTEGRATORS
    # With strict incompressibility the last two refuse the scene.
    expected: ClassVar = {
        "half_explicit*": _EXPLICIT,
        "kappa 1e6:symplectic_euler": _EXPLICIT,
        "kappa 1e6:stoermer_verlet": _EXPLICIT,
    }
    default_only = ("stiffness*", "rates*", "50 Hz", "kappa*")
    bisect = False


@final
class ClosedLedger(StabilityCase):
    """What the energy does is accounted for."""

    summary = "the energy ledger of an active contraction closes in every step, as far as the method conserves energy"
    scene = Contraction.scene.replace("duration = 0.1", "duration = 0.03")
    limits = (Limit("halvings", 2), Limit("ledger_residual", 1e-9), Limit("ledger_drift", 1e-9))
    vary = ("integrator", "coupling", "cross_bridges")
    bisect = False


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"contraction": Contraction, "closed_ledger": ClosedLedger}
