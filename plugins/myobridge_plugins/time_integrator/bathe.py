"""Bathe's composite method."""

from __future__ import annotations

import math
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
    Works,
)
from myobridge.parameters import part
from myobridge.solvers import Formula, failed, finished, solve_stage, stage_report, step_report
from myobridge_plugins.time_integrator.backward_differences import backward_differences

__all__ = ["Bathe"]

# With this share of the step for the trapezoid both stages have the same tangent.
_SHARE = 2.0 - math.sqrt(2.0)


@final
@attrs.frozen
class Bathe(TimeIntegrator):
    r"""Bathe's composite method, TR-BDF2: a trapezoid, then backward differences (Bank et al. [1]_, Bathe [2]_).

    .. math:: 2 M \frac{v_\gamma - v_0}{\gamma \Delta t} + f_\gamma + f_0 = 0, \qquad
              u_\gamma - u_0 = \gamma \Delta t \frac{v_0 + v_\gamma}{2}, \qquad c(u_\gamma, p_\gamma) = 0

    and then BDF2 from :math:`u_0, u_\gamma` to the end of the step. Order 2; the second stage damps what the trapezoid
    would let ring, so that it is stable with constraints. Where heads
    start to pull out of balance it may add energy, a fifth at the worst that was seen.

    Departures
    ----------
    Bathe takes :math:`\gamma = 1/2`; here it is :math:`2 - \sqrt 2` as in [1]_, so that both stages have one tangent.
    No acceleration is remembered: the force at the beginning is evaluated with the population of this step.

    References
    ----------
    .. [1] R. E. Bank et al., IEEE Trans. Electron Devices 32 (1985) 1992-2007.
    .. [2] K. J. Bathe, M. M. I. Baig, Comput. Struct. 83 (2005) 2513-2524.
    """

    summary: ClassVar[str] = "Bathe's composite method, TR-BDF2; order 2, always stable, loses little energy"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"momentum"})

    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; chosen by size unless given")

    @property
    def stage(self) -> float:
        return 0.5

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        u, v, first = motion.displacement, motion.velocity, _SHARE * dt
        if u.size == 0:
            return StepResult(motion, memory, StepReport())
        trapezoid = Formula(
            time,
            first,
            rate=2.0 / first,
            velocity=-v,
            curvature=4.0 / (first * first),
            acceleration=(-4.0 / first) * v,
            force=solid.balance(motion, law, time).force,
        )
        solved = solve_stage(solid, law, motion, memory, trapezoid, u + first * v, self.newton)
        found = solved.end
        middle = Motion(found.displacement, trapezoid.stage(motion, found).velocity, found.multiplier)
        iterations = solved.newton.iterations
        if not solved.newton.converged:
            return StepResult(middle, memory, failed(solved))
        moved, gained = middle.displacement - u, middle.velocity - v
        ratio = (1.0 - _SHARE) / _SHARE
        differences = backward_differences(middle.velocity, moved, gained, ratio, time + first, dt - first)
        guess = middle.displacement + (dt - first) * middle.velocity
        last = solve_stage(solid, law, middle, solved.memory, differences, guess, self.newton)
        end = Motion(last.end.displacement, differences.stage(middle, last.end).velocity, last.end.multiplier)
        if not last.newton.converged:
            return StepResult(end, memory, failed(last, iterations))
        # The trapezoid saw the mean of the loads at both its ends.
        span = (time, trapezoid.end_time)
        reports = [
            step_report(solid, law, motion, middle, motion, time, span),
            step_report(solid, law, motion, middle, middle, trapezoid.end_time, span),
            stage_report(solid, law, differences, middle, end, 0),
        ]
        works = Works(
            *(
                sum(weight * getattr(report, name) for weight, report in zip((0.5, 0.5, 1.0), reports, strict=True))
                for name in ("external_work", "active_work", "viscous_work", "numerical_work")
            )
        )
        return StepResult(end, last.memory, finished(end, iterations + last.newton.iterations, works))


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"bathe": Bathe}
