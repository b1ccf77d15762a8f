r"""The implicit stage that all one-step integrators share, with or without a constraint.

The stage of a one-step method with end :math:`u_1` and fraction :math:`\theta` (1: backward Euler; 1/2: midpoint):

.. math:: u_\theta = u_0 + \theta (u_1 - u_0), \quad v_\theta = (u_1 - u_0)/\Delta t, \quad
          \frac{M (v_\theta - v_0)}{\theta\,\Delta t} + f(u_\theta, v_\theta, p, t_0 + \theta\,\Delta t) = 0, \quad
          c(u_1, p) = 0

The multiplier `p` is one for the whole step; the constraint holds at its end. Unknowns are :math:`(u_1, p/s)`,
equations force and :math:`s\,c`, both in N, with the solid's own scale `s` [Pa/m]. With :math:`\theta < 1` the
constraint's gradient acts at the stage and is asked for at the end: the tangent is unsymmetric.
"""

from __future__ import annotations

import math

import numpy as np

from myobridge.instant import just_before
from myobridge.interfaces import (
    ActiveLaw,
    Array,
    Balance,
    LinearSystem,
    MacroSolid,
    Matrix,
    Memory,
    Motion,
    NewtonMethod,
    NewtonProblem,
    StepReport,
    StepResult,
)
from myobridge.solvers.linear import add_scaled, times
from myobridge.solvers.newton import Ordinary
from myobridge.solvers.step import effective_mass, step_report

__all__ = ["implicit_stage"]

# Below this size the tangent costs next to nothing beside the residual: both come from one call.
_SMALL = 100
_ORDINARY = Ordinary()


class _Stage(NewtonProblem):
    """Equations of one step."""

    def __init__(
        self,
        solid: MacroSolid,
        law: ActiveLaw | None,
        motion: Motion,
        time: float,
        dt: float,
        stage: float,
        inertia: bool,
    ) -> None:
        self.solid, self.law, self.start, self.dt, self.stage = solid, law, motion, dt, stage
        self.end_time = just_before(time + dt, dt)
        self.time = time + stage * dt if stage < 1.0 else self.end_time
        self.span = (time, self.end_time)
        self.mass = effective_mass(solid, law and law.inertance) if inertia else None
        self.held = 0.0 if self.mass is None else times(self.mass, motion.velocity) / (stage * dt)
        self.n = motion.displacement.size
        self.constrained = motion.multiplier.size > 0
        self.scale = solid.multiplier_scale if self.constrained else 1.0
        self.small = self.n + motion.multiplier.size <= _SMALL
        self.known: tuple[Array, Balance] | None = None

    def multiplier(self, unknowns: Array) -> Array:
        return self.scale * unknowns[self.n :] if self.constrained else self.start.multiplier

    def at(self, unknowns: Array) -> Motion:
        """Motion at the stage."""
        start = self.start.displacement
        change = (unknowns[: self.n] if self.constrained else unknowns) - start
        return Motion(start + self.stage * change, change / self.dt, self.multiplier(unknowns))

    def admissible(self, unknowns: Array) -> bool:
        return self.solid.admissible(unknowns[: self.n] if self.constrained else unknowns, self.end_time)

    def _balance(self, unknowns: Array, *, tangent: bool) -> Balance:
        balance = self.solid.balance(self.at(unknowns), self.law, self.time, tangent=tangent)
        if tangent:
            self.known = (unknowns, balance)
        return balance

    def _at_end(self, unknowns: Array, balance: Balance, *, tangent: bool) -> Balance:
        """Balance whose constraint is that of the end; no law is asked for it."""
        if self.stage == 1.0:
            return balance
        end = Motion(unknowns[: self.n], self.start.velocity, self.multiplier(unknowns))
        return self.solid.balance(end, None, self.end_time, rate=False, tangent=tangent)

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        balance = self._balance(unknowns, tangent=self.small)
        force, magnitude = balance.force, balance.magnitude
        if self.mass is not None:
            mean = (unknowns[: self.n] - self.start.displacement) / self.dt
            momentum = times(self.mass, mean) / (self.stage * self.dt)
            force = force + (momentum - self.held)
            magnitude += math.sqrt(float(momentum @ momentum))
        if not self.constrained:
            return force, magnitude
        end = self._at_end(unknowns, balance, tangent=False)
        assert end.constraint is not None, "a solid with multipliers must have a constraint"
        return np.concatenate([force, self.scale * end.constraint]), magnitude + self.scale * end.constraint_magnitude

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        if self.known is None or self.known[0] is not unknowns:
            self._balance(unknowns, tangent=True)
        assert self.known is not None
        balance = self.known[1]
        assert balance.stiffness is not None
        matrix: Matrix = self.stage * balance.stiffness
        if balance.damping is not None:
            matrix = add_scaled(matrix, 1.0 / self.dt, balance.damping)
        if self.mass is not None:
            matrix = add_scaled(matrix, 1.0 / (self.stage * self.dt * self.dt), self.mass)
        if not self.constrained:
            if isinstance(matrix, np.ndarray):
                return matrix
            return LinearSystem(matrix, rigid_motions=self.solid.rigid_motions(), symmetric=balance.symmetric)
        end = self._at_end(unknowns, balance, tangent=True)
        assert balance.constraint_gradient is not None
        assert end.constraint_gradient is not None
        here = self.scale * balance.constraint_gradient
        softness = end.constraint_compliance
        return LinearSystem(
            matrix,
            here,
            here if end is balance else self.scale * end.constraint_gradient,
            None if softness is None else self.scale**2 * softness,
            self.solid.rigid_motions(),
            symmetric=balance.symmetric and end is balance,
        )


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
    problem = _Stage(solid, law, motion, time, dt, stage, inertia)
    guess = start + dt * velocity if inertia else start
    if not solid.admissible(guess, problem.end_time):
        guess = start
    if problem.constrained:
        guess = np.concatenate([guess, motion.multiplier / problem.scale])
    found = (newton or _ORDINARY).solve(problem, guess)
    displacement = found.unknowns[: start.size] if problem.constrained else found.unknowns
    mean = (displacement - start) / dt
    end_velocity = velocity + (mean - velocity) / stage if inertia else mean
    end = Motion(displacement, end_velocity, problem.multiplier(found.unknowns))
    if not found.converged:
        return StepResult(end, memory, StepReport(converged=False, reason=found.reason, iterations=found.iterations))
    report = step_report(
        solid, law, motion, end, problem.at(found.unknowns), problem.time, problem.span, found.iterations
    )
    return StepResult(end, memory, report)
