"""Generalised-alpha method."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    ActiveLaw,
    MacroSolid,
    Memory,
    Motion,
    NewtonMethod,
    StepReport,
    StepResult,
    TimeIntegrator,
)
from myobridge.parameters import number, part
from myobridge.solvers import Formula, acceleration, failed, solve_stage, stage_report

__all__ = ["GeneralisedAlpha"]


@final
@attrs.frozen
class GeneralisedAlpha(TimeIntegrator):
    r"""Generalised-alpha method (Chung and Hulbert [1]_) in the form for constraints of Arnold and Bruels [2]_.

    .. math:: M \dot v_1 + f(u_1, v_1, p_1, t_1) = 0, \quad c(u_1, p_1) = 0, \quad
              (1 - \alpha_m) a_1 + \alpha_m a_0 = (1 - \alpha_f) \dot v_1 + \alpha_f \dot v_0

    .. math:: u_1 = u_0 + \Delta t\,v_0 + \Delta t^2 \bigl((\tfrac12 - \beta) a_0 + \beta a_1\bigr), \qquad
              v_1 = v_0 + \Delta t \bigl((1 - \gamma) a_0 + \gamma a_1\bigr)

    with :math:`\alpha_m = (2\rho - 1)/(\rho + 1)`, :math:`\alpha_f = \rho/(\rho + 1)`,
    :math:`\gamma = \tfrac12 + \alpha_f - \alpha_m`, :math:`\beta = (\gamma + \tfrac12)^2 / 4`; :math:`\rho` is the
    share of the fastest oscillations that one step leaves. The accelerations `a` and :math:`\dot v` are its memory.

    Coupled to cross-bridges by `splitting` it is of order 1: the accelerations belong to earlier populations.
    `corrected` keeps the order.
    Where heads start to pull out of balance it may add energy, 93 % at the worst that was seen.

    Parameters
    ----------
    rho_inf : float
        :math:`\rho` [-]. Above .7 it fails on releases of incompressible bodies.
    newton : NewtonMethod, optional

    References
    ----------
    .. [1] J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375.
    .. [2] M. Arnold, O. Bruels, Multibody Syst. Dyn. 18 (2007) 185-202.
    """

    summary: ClassVar[str] = "generalised-alpha method; order 2, damps fast oscillations as wanted"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"momentum"})

    rho_inf: float = number(0.5, within="[0, 1]", doc="share of the fastest oscillations that one step leaves")
    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; chosen by size unless given")

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        u, v, rho = motion.displacement, motion.velocity, self.rho_inf
        if u.size == 0:
            return StepResult(motion, memory, StepReport())
        mass_share, force_share = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + force_share - mass_share
        beta = 0.25 * (gamma + 0.5) ** 2
        if "acceleration" in memory:
            rate, real = memory["acceleration"], memory["real_acceleration"]
        else:
            rate = real = acceleration(solid, law, motion, time)
        # a_1 = known + slope (u_1 - u_0), from the position; then the real acceleration from a_1.
        slope = 1.0 / (beta * dt * dt)
        known = -v / (beta * dt) - (0.5 / beta - 1.0) * rate
        ratio = (1.0 - mass_share) / (1.0 - force_share)
        lag = (mass_share * rate - force_share * real) / (1.0 - force_share)
        formula = Formula(
            time,
            dt,
            rate=gamma * dt * slope,
            velocity=v + dt * ((1.0 - gamma) * rate + gamma * known),
            curvature=ratio * slope,
            acceleration=ratio * known + lag,
        )
        solved = solve_stage(solid, law, motion, memory, formula, u + dt * v, self.newton)
        found = solved.end
        end = Motion(found.displacement, formula.stage(motion, found).velocity, found.multiplier)
        if not solved.newton.converged:
            return StepResult(end, memory, failed(solved))
        after = known + slope * (end.displacement - u)
        history = {"acceleration": after, "real_acceleration": ratio * after + lag}
        report = stage_report(solid, law, formula, motion, end, solved.newton.iterations)
        return StepResult(end, {**solved.memory, **history}, report)


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"generalised_alpha": GeneralisedAlpha}
