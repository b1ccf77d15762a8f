r"""What all one-step integrators share: the implicit stage, and the works that a step did.

The stage of a one-step method with end :math:`u_1` and fraction :math:`\theta` (1: backward Euler; 1/2: midpoint):

.. math:: u_\theta = u_0 + \theta (u_1 - u_0), \quad v_\theta = (u_1 - u_0)/\Delta t, \quad
          \frac{M (v_\theta - v_0)}{\theta\,\Delta t} + f(u_\theta, v_\theta, t_0 + \theta\,\Delta t) = 0
"""

from __future__ import annotations

import math

import numpy as np

from myobridge.instant import just_before
from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Matrix, Memory, Motion, StepReport, StepResult
from myobridge.solvers.linear import add_scaled, times
from myobridge.solvers.newton import newton

__all__ = ["effective_mass", "implicit_stage", "kinetic_energy", "step_report"]


def effective_mass(solid: MacroSolid, inertance: Array | None) -> Matrix:
    """Mass of the solid and, where they have some, of the attached heads [kg]."""
    return solid.mass_matrix if inertance is None else solid.mass_matrix + solid.added_mass(inertance)


def kinetic_energy(solid: MacroSolid, inertance: Array | None, velocity: Array) -> float:
    """Kinetic energy of solid and heads [J]."""
    return 0.5 * float(np.dot(velocity, times(effective_mass(solid, inertance), velocity)))


def implicit_stage(
    solid: MacroSolid,
    law: ActiveLaw | None,
    motion: Motion,
    memory: Memory,
    time: float,
    dt: float,
    *,
    stage: float,
    inertia: bool,
    tolerance: float,
) -> StepResult:
    """One step of a one-step method whose stage is at `stage`; without `inertia` no mass is asked for."""
    start, velocity = motion.displacement, motion.velocity
    if start.size == 0:
        return StepResult(motion, memory, StepReport())
    mass = effective_mass(solid, law and law.inertance) if inertia else None
    stage_time = time + stage * dt if stage < 1.0 else just_before(time + dt, dt)
    held = 0.0 if mass is None else times(mass, velocity) / (stage * dt)

    def at(end: Array) -> Motion:
        change = end - start
        return Motion(start + stage * change, change / dt, motion.multiplier)

    def evaluate(end: Array) -> tuple[Array, Matrix, float]:
        here = at(end)
        balance = solid.balance(here, law, stage_time, tangent=True)
        force = balance.force
        assert balance.stiffness is not None
        tangent: Matrix = stage * balance.stiffness
        if balance.damping is not None:
            tangent = add_scaled(tangent, 1.0 / dt, balance.damping)
        magnitude = balance.magnitude
        if mass is not None:
            momentum = times(mass, here.velocity) / (stage * dt)
            force = force + (momentum - held)
            tangent = add_scaled(tangent, 1.0 / (stage * dt * dt), mass)
            magnitude += math.sqrt(float(momentum @ momentum))
        return force, tangent, magnitude

    guess = start + dt * velocity if inertia else start
    if not solid.admissible(guess):
        guess = start
    found = newton(evaluate, guess, admissible=solid.admissible, tolerance=tolerance)
    mean = (found.unknowns - start) / dt
    end_velocity = velocity + (mean - velocity) / stage if inertia else mean
    end = Motion(found.unknowns, end_velocity, motion.multiplier)
    if not found.converged:
        return StepResult(end, memory, StepReport(converged=False, reason=found.reason, iterations=found.iterations))
    report = step_report(solid, law, motion, end, at(found.unknowns), stage_time, found.iterations)
    return StepResult(end, memory, report)


def step_report(
    solid: MacroSolid,
    law: ActiveLaw | None,
    start: Motion,
    end: Motion,
    stage: Motion,
    stage_time: float,
    iterations: int = 0,
) -> StepReport:
    """Report of a step that saw loads and tension at `stage`: the works they did between `start` and `end`."""
    change = end.displacement - start.displacement
    external = float(np.dot(solid.external_force(stage.displacement, stage_time), change))
    active = 0.0
    if law is not None and not law.has_potential:
        stretch = solid.stretch(stage.displacement, stage_time)
        rate = solid.stretch_rate(stage.displacement, stage.velocity, stage_time)
        tension = law.evaluate(stretch, rate).tension
        moved = solid.stretch(end.displacement, stage_time) - solid.stretch(start.displacement, stage_time)
        active = -float(np.dot(solid.site_volumes * tension, moved))
    # A sum is finite only if every term is, and costs a fifth of asking each.
    finite = math.isfinite(end.displacement.sum() + end.velocity.sum())
    reason = "" if finite else "the motion is not finite"
    return StepReport(finite, reason, iterations, external_work=external, active_work=active)
