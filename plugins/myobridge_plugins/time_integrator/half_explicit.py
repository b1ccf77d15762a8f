"""Half-explicit Euler."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.instant import just_before
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, StepReport, StepResult, TimeIntegrator
from myobridge.parameters import choice
from myobridge.solvers import (
    ConstrainedMass,
    SingularMatrix,
    UnsolvedSystem,
    constraint_rate,
    gradient_at,
    point_force,
    step_report,
)

__all__ = ["HalfExplicit"]


@final
@attrs.frozen
class HalfExplicit(TimeIntegrator):
    r"""Half-explicit Euler for the index-2 form (thesis [1]_, section 4.4; Hairer, Lubich and Roche [2]_).

    In the order of the textbook,

    .. math:: u_1 = u_0 + \Delta t\,v_0, \qquad
              M v_1 = M v_0 - \Delta t\,\bigl(f(u_0, v_0, t_0) + B(u_0)^T p\bigr), \qquad B(u_1)\,v_1 = 0,

    and in the symplectic order

    .. math:: M v_1 = M v_0 - \Delta t\,\bigl(f(u_0, v_0, t_0) + B(u_0)^T p\bigr), \quad B(u_0)\,v_1 = 0, \qquad
              u_1 = u_0 + \Delta t\,v_1,

    each with the rate that moving supports give the constraint. Kept to show why they fail: in the order of the
    textbook every oscillation grows at the rate :math:`\omega^2 \Delta t / 2`, whatever is projected afterwards; in the
    symplectic order it does not below :math:`\Delta t = 2 / \omega_{max}`, but the constraint itself is never looked at
    and drifts.

    Without constraint they are explicit and symplectic Euler; a constraint with compliance acts like a spring.

    References
    ----------
    .. [1] Thesis, section 4.4.
    .. [2] E. Hairer, C. Lubich, M. Roche, The Numerical Solution of Differential-Algebraic Systems (1989), section 2.
    """

    summary: ClassVar[str] = "half-explicit Euler (thesis); order 1, grows or drifts: kept to show why it fails"
    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"momentum"})

    sequence: str = choice("textbook", ("textbook", "symplectic"), doc="positions before velocities, or after them")

    @property
    def stage(self) -> float:
        return 0.0

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        if motion.displacement.size == 0:
            return StepResult(motion, memory, StepReport())
        end_time, textbook = just_before(time + dt, dt), self.sequence == "textbook"
        at = point_force(solid, law, motion, time)
        place, when = (
            (motion.displacement + dt * motion.velocity, end_time) if textbook else (motion.displacement, time)
        )
        inertance = None if law is None else law.inertance
        multiplier, rate = at.multiplier, 0.0
        try:
            if at.gradient is None:
                velocity = motion.velocity - dt * ConstrainedMass(solid, None, inertance=inertance).inverse(at.force)
            else:
                there = gradient_at(solid, place, when, multiplier) if textbook else at.gradient
                rate = -constraint_rate(solid, place, when, dt) - there @ motion.velocity
                mass = ConstrainedMass(solid, there, at.gradient, inertance)
                change, impulse = mass.solve(-dt * at.force, rate)
                velocity, multiplier = motion.velocity + change, impulse / dt
        except (UnsolvedSystem, SingularMatrix) as error:
            said = str(error) or "the constraint has not full rank"
            return StepResult(motion, memory, StepReport(converged=False, reason=said))
        end = Motion(place if textbook else place + dt * velocity, velocity, multiplier)
        if not solid.admissible(end.displacement, end_time):
            return StepResult(motion, memory, StepReport(converged=False, reason="the displacement is not admissible"))
        stage = Motion(motion.displacement, motion.velocity, multiplier)
        return StepResult(end, memory, step_report(solid, law, motion, end, stage, time, (time, end_time)))


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"half_explicit": HalfExplicit}
