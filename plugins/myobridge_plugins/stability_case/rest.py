"""A body at rest must stay there."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import BLOCK


@final
class Rest(StabilityCase):
    """200 steps without a load."""

    summary = "a block without load at kappa = 1e6 Pa stays at rest for 200 steps"
    scene = f"""
[scene]
name = "rest"
effects = ["inertia", "incompressibility"]
duration = 0.2
step = 1e-3
{BLOCK}bulk_modulus = 1e6
[[support]]
boundary = "left"
"""
    limits = (Limit("halvings", 2), Limit("volume_error", 1e-12))
    vary = ("integrator", "solid.material.form")
    expected: ClassVar = {
        "printed": Expectation("fails", "the printed law is not free of stress at rest"),
    }
    bisect = False


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"rest": Rest}
