"""Initial data that violate the constraint: a body whose volume is 1.3 times what it may be."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import BLOCK

_SCENE = f"""
[scene]
name = "inflated"
effects = ["inertia", "incompressibility"]
duration = 0.02
step = 1e-3
{BLOCK}stretch_at_start = [1.3, 1.0]
"""


@final
class InconsistentStart(StabilityCase):
    """As given: refused."""

    summary = "a strictly incompressible block with J = 1.3 at the start is refused"
    scene = _SCENE
    limits = ()
    refused_with = "projected"
    vary = ("integrator",)
    bisect = False


@final
class ProjectedStart(StabilityCase):
    """Projected: runs."""

    summary = "a strictly incompressible block with J = 1.3 at the start is projected where the scene says so"
    scene = _SCENE.replace("step = 1e-3", 'step = 1e-3\nstart = "projected"')
    variants: ClassVar = {"": {"solid.mesh.cells": [8, 2]}}
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-10))
    vary = ("integrator",)
    bisect = False


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"inconsistent_start": InconsistentStart, "projected_start": ProjectedStart}
