r"""One-step methods whose stage lies at a fraction of the step, and what their reports say.

.. math:: u_\theta = u_0 + \theta\,d, \quad v_\theta = d/\Delta t, \quad
          \frac{M (v_\theta - v_0)}{\theta\,\Delta t} + f(u_\theta, v_\theta, p, t_0 + \theta\,\Delta t) = 0, \quad
          v_1 = v_0 + (v_\theta - v_0) / \theta

`theta` 1 is backward Euler, 1/2 the midpoint rule.
"""

from __future__ import annotations

from myobridge.interfaces import (
    ActiveLaw,
    MacroSolid,
    Memory,
    Motion,
    NewtonMethod,
    StepReport,
    StepResult,
)
from myobridge.solvers.stage import Formula, Solved, solve_stage
from myobridge.solvers.step import step_report

__all__ = ["failed", "implicit_stage", "stage_report"]


def failed(solved: Solved, iterations: int = 0) -> StepReport:
    """Report of a stage whose equations were not solved; `iterations` were spent before."""
    found = solved.newton
    return StepReport(converged=False, reason=found.reason, iterations=iterations + found.iterations)


def stage_report(
    solid: MacroSolid,
    law: ActiveLaw | None,
    formula: Formula,
    start: Motion,
    end: Motion,
    iterations: int,
) -> StepReport:
    """Report of a step that saw loads and tension at the stage of a formula."""
    stage, span = formula.stage(start, end), (formula.time, formula.end_time)
    return step_report(solid, law, start, end, stage, formula.stage_time, span, iterations)


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
    newton: NewtonMethod | None = None,
) -> StepResult:
    """One step of a one-step method whose stage is at `stage`.

    Parameters
    ----------
    stage : float
        Fraction theta of the step, in (0, 1].
    inertia : bool
        Without, no mass is asked for.
    newton : NewtonMethod, optional
        The ordinary one unless given.

    Returns
    -------
    StepResult
        The motion at the end of the step, with the multiplier of the step.
    """
    start, velocity = motion.displacement, motion.velocity
    if start.size == 0:
        return StepResult(motion, memory, StepReport())
    formula = Formula(
        time,
        dt,
        at=stage,
        share=stage,
        rate=1.0 / dt,
        curvature=1.0 / (stage * dt * dt) if inertia else 0.0,
        acceleration=-velocity / (stage * dt) if inertia else None,
    )
    solved = solve_stage(solid, law, motion, memory, formula, start + dt * velocity if inertia else start, newton)
    mean = solved.end.velocity
    end_velocity = velocity + (mean - velocity) / stage if inertia else mean
    end = Motion(solved.end.displacement, end_velocity, solved.end.multiplier)
    if not solved.newton.converged:
        return StepResult(end, memory, failed(solved))
    report = stage_report(solid, law, formula, motion, end, solved.newton.iterations)
    return StepResult(end, solved.memory, report)
