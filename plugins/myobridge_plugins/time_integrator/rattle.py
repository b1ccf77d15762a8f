"""RATTLE."""

from __future__ import annotations

import math
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.instant import just_before
from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Memory, Motion, StepReport, StepResult, TimeIntegrator
from myobridge.parameters import choice
from myobridge.solvers import (
    ConstrainedMass,
    PointForce,
    SingularMatrix,
    UnsolvedSystem,
    constraint_rate,
    largest_frequency,
    onto_constraint,
    point_force,
    step_report,
)

__all__ = ["Rattle"]

# Steps after which the largest frequency is looked at again.
_REFRESH = 32
_LIMIT, _SHAPE = "rattle/limit", "rattle/shape"


@final
@attrs.frozen
class Rattle(TimeIntegrator):
    r"""RATTLE (Andersen [1]_): velocity Verlet with positions and velocities projected onto the constraint.

    .. math:: v_{1/2} = v_0 - \tfrac{\Delta t}{2} M^{-1} \bigl(f(u_0, v_0, t_0) + B(u_0)^T p\bigr), \quad
              u_1 = u_0 + \Delta t\,v_{1/2}, \quad c(u_1) = 0

    .. math:: v_1 = v_{1/2} - \tfrac{\Delta t}{2} M^{-1} \bigl(f(u_1, v_{1/2}, t_1) + B(u_1)^T p_1\bigr), \quad
              B(u_1)\,v_1 + \dot c_{support} = 0

    Explicit but for the multipliers, symplectic, order 2, energy error bounded for ever, the constraint kept to
    round-off. Without constraint it is velocity Verlet; one with compliance acts like a spring. Forces that depend on
    the rate see the rate of half a step ago, so that the order is 1 for them.

    Stable for :math:`\Delta t < 2/\omega_{max}`, the largest frequency of the constrained body about its motion, active
    stiffness included. It is found by a few Lanczos iterations, looked at again every 32 steps, and part of the memory.

    Parameters
    ----------
    limit : "halve" or "ignore"
        What happens to a step beyond that limit: it fails, so that the simulation halves it, or is taken all the same.

    References
    ----------
    .. [1] H. C. Andersen, J. Comput. Phys. 52 (1983) 24-34.
    """

    summary: ClassVar[str] = "RATTLE; explicit, symplectic, order 2, keeps constraints, knows its own stability limit"
    order: ClassVar[int] = 2
    explicit: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"bounded_energy", "momentum", "angular_momentum"})

    limit: str = choice("halve", ("halve", "ignore"), doc="a step beyond the stability limit fails, or is taken")

    @property
    def stage(self) -> float:
        return 0.5

    def largest_step(self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, time: float) -> float:
        r"""Largest stable step :math:`2/\omega_{max}` about a motion [s]; infinite where nothing swings.

        Raises
        ------
        UnsolvedSystem, SingularMatrix
            If the constraint has not full rank.
        """
        omega = largest_frequency(solid, law, motion, time).omega
        return 2.0 / omega if omega > 0.0 else math.inf

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        if motion.displacement.size == 0:
            return StepResult(motion, memory, StepReport())
        try:
            reason = ""
            if self.limit == "halve":
                memory = self._looked_at(solid, law, motion, memory, time)
                reason = _too_long(dt, float(memory[_LIMIT][0]))
            if reason:
                return StepResult(motion, memory, StepReport(converged=False, reason=reason))
            end, report = _step(solid, law, motion, time, dt)
        except (UnsolvedSystem, SingularMatrix) as error:
            said = str(error) or "the constraint has not full rank"
            return StepResult(motion, memory, StepReport(converged=False, reason=said))
        return StepResult(end, memory, report)

    def _looked_at(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float
    ) -> Memory:
        """Memory with a limit that is not too old; the shape of the last one is where the next search begins."""
        known = memory.get(_LIMIT)
        if known is not None and known[1] < _REFRESH:
            return {**memory, _LIMIT: np.array([known[0], known[1] + 1.0])}
        found = largest_frequency(solid, law, motion, time, start=memory.get(_SHAPE))
        limit = 2.0 / found.omega if found.omega > 0.0 else math.inf
        return {**memory, _LIMIT: np.array([limit, 1.0]), _SHAPE: found.shape}


def _too_long(dt: float, limit: float) -> str:
    if dt <= limit:
        return ""
    return f"the step of {dt:.3g} s is beyond the stability limit 2 / omega_max = {limit:.3g} s of rattle"


def _step(
    solid: MacroSolid, law: ActiveLaw | None, motion: Motion, time: float, dt: float
) -> tuple[Motion, StepReport]:
    end_time, inertance = just_before(time + dt, dt), None if law is None else law.inertance
    at = point_force(solid, law, motion, time)
    near = ConstrainedMass(solid, at.gradient, inertance=inertance)
    half = motion.velocity - 0.5 * dt * near.inverse(at.force)
    moved, acting, iterations = motion.displacement + dt * half, at.multiplier, 0
    if at.gradient is not None:
        found = onto_constraint(solid, near, moved, end_time)
        if found.reason:
            return motion, StepReport(converged=False, reason=found.reason)
        moved, half, iterations = found.displacement, half + found.correction / dt, found.iterations
        acting = (2.0 / dt**2) * found.multiplier
    if not solid.admissible(moved, end_time):
        return motion, StepReport(converged=False, reason="the displacement is not admissible", iterations=iterations)
    there = point_force(solid, law, Motion(moved, half, motion.multiplier), end_time)
    velocity, multiplier = _last_half(solid, there, moved, half, inertance, end_time, dt)
    end = Motion(moved, velocity, multiplier)
    middle = Motion(0.5 * (motion.displacement + moved), half, 0.5 * (acting + multiplier))
    return end, step_report(solid, law, motion, end, middle, time + 0.5 * dt, (time, end_time), iterations)


def _last_half(
    solid: MacroSolid, there: PointForce, moved: Array, half: Array, inertance: Array | None, time: float, dt: float
) -> tuple[Array, Array]:
    """Velocity at the end, and the multiplier that made it."""
    mass = ConstrainedMass(solid, there.gradient, inertance=inertance)
    if there.gradient is None:
        return half - 0.5 * dt * mass.inverse(there.force), there.multiplier
    rate = -constraint_rate(solid, moved, time, dt) - there.gradient @ half
    change, impulse = mass.solve(-0.5 * dt * there.force, rate)
    return half + change, (2.0 / dt) * impulse


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"rattle": Rattle}
