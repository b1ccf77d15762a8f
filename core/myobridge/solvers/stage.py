r"""The implicit stage that all implicit integrators share, with or without a constraint.

A method is a `Formula`: what it makes of the change `d` of the displacement over the step,

.. math:: u_s = u_0 + \theta\,d, \qquad v_s = \beta\,d + \bar v, \qquad a_s = \gamma\,d + \bar a, \qquad
          M a_s + f(u_s, v_s, p_s, t_s) + \bar f = 0, \qquad c(u_0 + d, p) = 0

The multiplier `p` is one for the whole step; the constraint holds at its end. A formula that is `discrete` has the
force of the whole step in place of that of a stage (`MacroSolid.step_balance`). Unknowns are :math:`(u_1, p/s)`,
equations force and :math:`s\,c`, both in N, with the solid's own scale `s` [Pa/m]; where a share of the new multiplier
acts, the constraint has that share, too. Where its gradient acts elsewhere than at the end, the tangent is unsymmetric.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import attrs
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
    NewtonResult,
)
from myobridge.solvers.kept import recalled, remembered
from myobridge.solvers.linear import add_scaled, times
from myobridge.solvers.method_choice import method_for
from myobridge.solvers.step import effective_mass

__all__ = ["Formula", "Solved", "solve_stage"]

# Below this size the tangent costs next to nothing beside the residual: both come from one call.
_SMALL = 100


@attrs.frozen(eq=False)
class Formula:
    """Stage of a step from `time` to `time + dt` [s].

    Attributes
    ----------
    time, dt : float
        Beginning and length of the step.
    at : float
        Where the stage is, as a fraction of the step.
    share : float
        theta, of the change that the stage has seen.
    rate, velocity : float, ndarray
        beta [1/s] and what is added to it [m/s].
    curvature, acceleration : float, ndarray
        gamma [1/s^2] and what is added to it [m/s^2]; no mass is asked for where the acceleration is None.
    force : ndarray or None
        Added to the force [N].
    multiplier_share : float
        Share of the new multiplier in the one that acts; the rest is the old one's.
    discrete : bool
        The force is that of the whole step.
    """

    time: float
    dt: float
    at: float = 1.0
    share: float = 1.0
    rate: float = 0.0
    velocity: Array | float = 0.0
    curvature: float = 0.0
    acceleration: Array | None = None
    force: Array | None = None
    multiplier_share: float = 1.0
    discrete: bool = False

    @property
    def end_time(self) -> float:
        """End of the step, before any jump that happens there."""
        return just_before(self.time + self.dt, self.dt)

    @property
    def stage_time(self) -> float:
        """Time of the stage."""
        return self.time + self.at * self.dt if self.at < 1.0 else self.end_time

    def acting(self, start: Motion, multiplier: Array) -> Array:
        """Multiplier in the force."""
        share = self.multiplier_share
        return multiplier if share == 1.0 else share * multiplier + (1.0 - share) * start.multiplier

    def stage(self, start: Motion, end: Motion) -> Motion:
        """Motion at the stage."""
        change = end.displacement - start.displacement
        moving = self.rate * change + self.velocity
        return Motion(start.displacement + self.share * change, moving, self.acting(start, end.multiplier))


class Solved(NamedTuple):
    """Displacement and multiplier at the end of a step, with the mean velocity; memory; how Newton's method went."""

    end: Motion
    memory: Memory
    newton: NewtonResult


class _Stage(NewtonProblem):
    """Equations of one step."""

    def __init__(self, solid: MacroSolid, law: ActiveLaw | None, start: Motion, formula: Formula) -> None:
        self.solid, self.law, self.start, self.formula = solid, law, start, formula
        self.inertia = formula.acceleration is not None
        self.mass = effective_mass(solid, law and law.inertance) if self.inertia else None
        self.held = times(self.mass, formula.acceleration) if formula.acceleration is not None else np.zeros(1)
        if formula.force is not None:
            self.held = self.held + formula.force
        self.end_time, self.stage_time = formula.end_time, formula.stage_time
        self.n = start.displacement.size
        self.constrained = start.multiplier.size > 0
        self.scale = solid.multiplier_scale if self.constrained else 1.0
        # Weight of the constraint: a share of the multiplier in the force has the same share here, for symmetry.
        self.weight = self.scale * formula.multiplier_share
        self.small = self.n + start.multiplier.size <= _SMALL
        self.known: tuple[Array, Balance] | None = None

    def motion(self, unknowns: Array) -> Motion:
        """End of the step, with its mean velocity."""
        displacement = unknowns[: self.n] if self.constrained else unknowns
        multiplier = self.scale * unknowns[self.n :] if self.constrained else self.start.multiplier
        return Motion(displacement, (displacement - self.start.displacement) / self.formula.dt, multiplier)

    def admissible(self, unknowns: Array) -> bool:
        return self.solid.admissible(unknowns[: self.n] if self.constrained else unknowns, self.end_time)

    def _balance(self, unknowns: Array, *, tangent: bool) -> Balance:
        end, formula, solid = self.motion(unknowns), self.formula, self.solid
        if formula.discrete:
            span = (formula.time, self.end_time)
            acting = formula.acting(self.start, end.multiplier)
            found = solid.step_balance(self.start, end, self.law, span, multiplier=acting, tangent=tangent)
        else:
            found = self._at_stage(end, tangent=tangent)
        if tangent:
            self.known = (unknowns, found)
        return found

    def _at_stage(self, end: Motion, *, tangent: bool) -> Balance:
        """Balance at the stage, constraint at the end; the stiffness is the derivative by the change."""
        formula, solid = self.formula, self.solid
        found = solid.balance(formula.stage(self.start, end), self.law, self.stage_time, tangent=tangent)
        if tangent:
            assert found.stiffness is not None
            stiffness = found.stiffness if formula.share == 1.0 else formula.share * found.stiffness
            if found.damping is not None:
                stiffness = add_scaled(stiffness, formula.rate, found.damping)
            found = found._replace(stiffness=stiffness)
        if formula.share == 1.0 or not self.constrained:
            return found
        last = solid.balance(end, None, self.end_time, rate=False, tangent=tangent)
        return found._replace(
            constraint=last.constraint,
            constraint_gradient=last.constraint_gradient,
            constraint_compliance=last.constraint_compliance,
            constraint_magnitude=last.constraint_magnitude,
            acting_gradient=found.constraint_gradient,
        )

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        balance = self._balance(unknowns, tangent=self.small)
        force, magnitude = balance.force + self.held, balance.magnitude
        if self.mass is not None:
            change = (unknowns[: self.n] if self.constrained else unknowns) - self.start.displacement
            momentum = self.formula.curvature * times(self.mass, change)
            force = force + momentum
            magnitude += math.sqrt(float(momentum @ momentum))
        if not self.constrained:
            return force, magnitude
        assert balance.constraint is not None, "a solid with multipliers must have a constraint"
        both = np.concatenate([force, self.weight * balance.constraint])
        return both, magnitude + self.weight * balance.constraint_magnitude

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        if self.known is None or self.known[0] is not unknowns:
            self._balance(unknowns, tangent=True)
        assert self.known is not None
        balance = self.known[1]
        matrix = balance.stiffness
        assert matrix is not None
        if self.mass is not None:
            matrix = add_scaled(matrix, self.formula.curvature, self.mass)
        if not self.constrained:
            if isinstance(matrix, np.ndarray):
                return matrix
            return LinearSystem(matrix, rigid_motions=self.solid.rigid_motions(), symmetric=balance.symmetric)
        assert balance.constraint_gradient is not None
        gradient, softness = self.weight * balance.constraint_gradient, balance.constraint_compliance
        acting = gradient if balance.acting_gradient is None else self.weight * balance.acting_gradient
        return LinearSystem(
            matrix,
            acting,
            gradient,
            None if softness is None else self.scale * self.weight * softness,
            self.solid.rigid_motions(),
            symmetric=balance.symmetric and acting is gradient,
        )


def solve_stage(
    solid: MacroSolid,
    law: ActiveLaw | None,
    start: Motion,
    memory: Memory,
    formula: Formula,
    guess: Array,
    newton: NewtonMethod | None = None,
) -> Solved:
    """Solve the equations of one stage.

    Parameters
    ----------
    start : Motion
        From which the change is measured.
    memory : mapping
        May hold a tangent that earlier steps kept; what is handed on holds that of this one.
    guess : ndarray, shape (n_unknowns,)
        Displacement at the end; where it is not admissible the start is the guess.
    newton : NewtonMethod, optional
        Chosen by size unless given (`method_for`).
    """
    problem = _Stage(solid, law, start, formula)
    if not solid.admissible(guess, problem.end_time):
        guess = start.displacement
    if problem.constrained:
        guess = np.concatenate([guess, start.multiplier / problem.scale])
    found = (newton or method_for(solid).method).solve(problem, guess, recalled(memory, solid))
    return Solved(problem.motion(found.unknowns), remembered(memory, found.kept), found)
