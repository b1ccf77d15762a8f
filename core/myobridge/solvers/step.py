"""What all one-step integrators share: the mass, the energy of motion, and the works that a step did."""

from __future__ import annotations

import math

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Matrix, Motion, StepReport, Works
from myobridge.midpoint_pair import active_work
from myobridge.solvers.linear import times

__all__ = ["effective_mass", "finished", "kinetic_energy", "step_report"]


def effective_mass(solid: MacroSolid, inertance: Array | None) -> Matrix:
    """Mass of the solid and, where they have some, of the attached heads [kg]."""
    return solid.mass_matrix if inertance is None else solid.mass_matrix + solid.added_mass(inertance)


def kinetic_energy(solid: MacroSolid, inertance: Array | None, velocity: Array) -> float:
    """Kinetic energy of solid and heads [J]."""
    return 0.5 * float(np.dot(velocity, times(effective_mass(solid, inertance), velocity)))


def step_report(
    solid: MacroSolid,
    law: ActiveLaw | None,
    start: Motion,
    end: Motion,
    stage: Motion,
    stage_time: float,
    times: tuple[float, float],
    iterations: int = 0,
) -> StepReport:
    """Report of a step between two `times` that saw loads and tension at `stage`: the works they did."""
    change = end.displacement - start.displacement
    external = float(np.dot(solid.external_force(stage.displacement, stage_time), change))
    external += solid.support_work(stage, law, stage_time, *times)
    active = active_work(solid, law, stage, stage_time, start, end)
    viscous = solid.viscous_force(stage, stage_time)
    taken = 0.0 if viscous is None else float(np.dot(viscous, change))
    return finished(end, iterations, Works(external, active, taken))


def finished(end: Motion, iterations: int, works: Works) -> StepReport:
    """Report of a step that was solved: a motion that is not finite has failed all the same."""
    # A sum is finite only if every term is, and costs a fifth of asking each.
    finite = math.isfinite(end.displacement.sum() + end.velocity.sum())
    reason = "" if finite else "the motion is not finite"
    return StepReport(finite, reason, iterations, works.external, works.active, works.viscous, works.numerical)
