"""Cross-bridges that are stiffer than the tissue: where staggered coupling fails at every step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, final

import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge.simulation import Simulation
from myobridge.statics import Statics

_AMPLIFIES = "an error comes back -K_a/K_p times larger in every step, however small the step"


@final
class Isometric(StabilityCase):
    """A fibre held at both ends that is activated; its thin end gives way."""

    summary = "isometric contraction of a tapered fibre without inertia, K_a/K_p = 19"
    # K_a = 2 s p_max = 1.0295e7 Pa.
    scene = """
[scene]
name = "isometric"
effects = ["cross_bridges", "sarcomere_density"]
duration = 0.2
step = 2e-3
[solid]
plugin = "chain"
springs = 10
length = 0.1
modulus = 541843.0
right = "fixed"
[cross_bridges]
plugin = "huxley"
start = "empty"
[sarcomere_density]
plugin = "tapered"
"""
    variants: ClassVar = {f"{dt:g}": {"scene.step": dt} for dt in (2e-3, 5e-4)}
    reference: ClassVar = {"scene.step": 1e-4, "coupling.plugin": "monolithic"}
    limits = (Limit("halvings", 2), Limit("tension_error", 0.05))
    vary = ("coupling",)
    expected: ClassVar = {"staggered": Expectation("fails", _AMPLIFIES)}


@final
class Staggering(StabilityCase):
    """Frozen heads on a soft spring, without inertia."""

    summary = "frozen heads on a spring r times softer than they are, under a slow load, without inertia"
    scene = """
[scene]
name = "staggering"
effects = ["cross_bridges"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
length = 0.1
area = 1e-4
load = { plugin = "sine", offset = 7.3, amplitude = 0.05, frequency = 5.0 }
[cross_bridges]
plugin = "liouville"
"""
    variants: ClassVar = {
        f"r={ratio}, {dt:g}": {
            "solid.stiffness": 2.0 * 73e3 * (1.1e-6 / 15.6e-9) * 1e-4 / 0.1 / ratio,
            "scene.step": dt,
            "scene.duration": 20 * dt,
        }
        for ratio in (5, 20)
        for dt in (1e-3, 1e-5)
    }
    limits = (Limit("halvings", 2), Limit("amplification", at_least=-1.0, at_most=2.0))
    vary = ("coupling",)
    expected: ClassVar = {"staggered": Expectation("fails", _AMPLIFIES, {"amplification": 0.05})}
    bisect = False

    def predicted(self, composed: Simulation | Statics) -> Mapping[str, float]:
        assert isinstance(composed, Simulation)
        bus, solid = composed.bus, composed.solid
        assert bus is not None
        active = float(bus.active_law_at_rest().evaluate(bus.stretch, np.zeros(1)).stiffness[0])
        both = solid.balance(composed.motion, bus.active_law_at_rest(), 0.0, rate=False, tangent=True).stiffness
        passive = solid.balance(composed.motion, None, 0.0, rate=False, tangent=True).stiffness
        assert both is not None
        assert passive is not None
        assert active > 0.0
        return {"amplification": -float((both - passive).sum() / passive.sum())}


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"isometric": Isometric, "staggering": Staggering}
