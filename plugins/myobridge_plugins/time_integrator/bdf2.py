"""Backward differentiation formula of order 2."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

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
from myobridge.parameters import part
from myobridge.solvers import failed, solve_stage, stage_report
from myobridge_plugins.time_integrator.backward_differences import backward_differences

__all__ = ["BDF2"]


@final
@attrs.frozen
class BDF2(TimeIntegrator):
    r"""Backward differentiation formula of order 2, for steps of any length.

    .. math:: M a_1 + f(u_1, v_1, p_1, t_1) = 0, \qquad c(u_1, p_1) = 0, \qquad
              v_1 = \frac{\alpha (u_1 - u_0) - \beta (u_0 - u_{-1})}{\Delta t}, \qquad
              a_1 = \frac{\alpha (v_1 - v_0) - \beta (v_0 - v_{-1})}{\Delta t}

    with :math:`\alpha = (1 + 2 \omega) / (1 + \omega)`, :math:`\beta = \omega^2 / (1 + \omega)` and :math:`\omega` the
    ratio of this step to the last one. The first step is one of backward Euler. Stable at every step for a step that
    does not grow by more than :math:`1 + \sqrt 2`; it loses energy, less than backward Euler.

    Coupled to cross-bridges by `splitting` it is of order 1: the last steps belong to other populations. `corrected`
    keeps the order.

    References
    ----------
    .. [1] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), III.5.
    """

    summary: ClassVar[str] = "backward differentiation, order 2; always stable, loses energy"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"momentum"})

    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; chosen by size unless given")

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        u, v = motion.displacement, motion.velocity
        if u.size == 0:
            return StepResult(motion, memory, StepReport())
        ratio, moved, gained = 0.0, np.zeros_like(u), np.zeros_like(u)
        if "step" in memory:
            ratio, moved, gained = dt / float(memory["step"][0]), memory["displacement"], memory["velocity"]
        formula = backward_differences(v, moved, gained, ratio, time, dt)
        solved = solve_stage(solid, law, motion, memory, formula, u + dt * v, self.newton)
        found = solved.end
        end = Motion(found.displacement, formula.stage(motion, found).velocity, found.multiplier)
        if not solved.newton.converged:
            return StepResult(end, memory, failed(solved))
        history = {"displacement": end.displacement - u, "velocity": end.velocity - v, "step": np.array([dt])}
        report = stage_report(solid, law, formula, motion, end, solved.newton.iterations)
        return StepResult(end, {**solved.memory, **history}, report)


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"bdf2": BDF2}
