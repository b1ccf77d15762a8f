"""Balance and works of a step for a solid that has no discrete gradient of its own: those of the middle of the step."""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, Balance, MacroSolid, Motion, Works
from myobridge.solvers.linear import add_scaled

__all__ = ["step_balance", "step_works"]


def _middle(start: Motion, end: Motion, times: tuple[float, float], multiplier: Array | None) -> Motion:
    change = end.displacement - start.displacement
    acting = end.multiplier if multiplier is None else multiplier
    return Motion(start.displacement + 0.5 * change, change / (times[1] - times[0]), acting)


def step_balance(
    solid: MacroSolid,
    start: Motion,
    end: Motion,
    law: ActiveLaw | None,
    times: tuple[float, float],
    multiplier: Array | None,
    *,
    tangent: bool,
) -> Balance:
    """Balance half-way, constraint at the end: see `MacroSolid.step_balance`."""
    middle, half = _middle(start, end, times, multiplier), 0.5 * (times[0] + times[1])
    found = solid.balance(middle, law, half, tangent=tangent)
    if tangent:
        assert found.stiffness is not None
        stiffness = 0.5 * found.stiffness
        if found.damping is not None:
            stiffness = add_scaled(stiffness, 1.0 / (times[1] - times[0]), found.damping)
        found = found._replace(stiffness=stiffness, damping=None)
    if end.multiplier.size == 0:
        return found
    last = solid.balance(end, None, times[1], rate=False, tangent=tangent)
    return found._replace(
        constraint=last.constraint,
        constraint_gradient=last.constraint_gradient,
        constraint_compliance=last.constraint_compliance,
        constraint_magnitude=last.constraint_magnitude,
        acting_gradient=found.constraint_gradient,
        symmetric=False,
    )


def step_works(
    solid: MacroSolid,
    start: Motion,
    end: Motion,
    law: ActiveLaw | None,
    times: tuple[float, float],
    multiplier: Array | None,
) -> Works:
    """Works at the loads, the tension and the viscosity half-way: see `MacroSolid.step_works`."""
    middle, half = _middle(start, end, times, multiplier), 0.5 * (times[0] + times[1])
    change = end.displacement - start.displacement
    external = float(np.dot(solid.external_force(middle.displacement, half), change))
    external += solid.support_work(middle, law, half, *times)
    viscous = solid.viscous_force(middle, half)
    taken = 0.0 if viscous is None else float(np.dot(viscous, change))
    return Works(external, active_work(solid, law, middle, half, start, end), taken)


def active_work(
    solid: MacroSolid, law: ActiveLaw | None, stage: Motion, stage_time: float, start: Motion, end: Motion
) -> float:
    """Work [J] of a law without potential between two motions, at the tension of a stage; 0 for one that has it."""
    if law is None or law.has_potential:
        return 0.0
    stretch = solid.stretch(stage.displacement, stage_time)
    rate = solid.stretch_rate(stage.displacement, stage.velocity, stage_time)
    moved = solid.stretch(end.displacement, stage_time) - solid.stretch(start.displacement, stage_time)
    return -float(np.dot(solid.site_volumes * law.evaluate(stretch, rate).tension, moved))
