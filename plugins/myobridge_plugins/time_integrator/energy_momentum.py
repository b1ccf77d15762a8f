"""Energy-momentum method."""

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
from myobridge.parameters import choice, part
from myobridge.solvers import Formula, failed, finished, solve_stage

__all__ = ["EnergyMomentum"]


@final
@attrs.frozen
class EnergyMomentum(TimeIntegrator):
    r"""Energy-momentum method: the midpoint rule with the discrete gradient of the energy (Gonzalez [1]_, [2]_).

    .. math:: M \frac{v_1 - v_0}{\Delta t} + \bar f(u_0, u_1, p) = 0, \qquad
              \frac{u_1 - u_0}{\Delta t} = \frac{v_0 + v_1}{2}, \qquad c(u_1, p_1) = 0

    The work of :math:`\bar f` is the change of the energies from which it derives (`MacroSolid.step_balance`), at every
    step and whatever the energies: kinetic, elastic and cross-bridge energy change by what loads, viscosity and
    reacting heads take and give, to round-off. Linear and angular momentum are kept as well.

    Parameters
    ----------
    multiplier : "endpoint", "averaged" or "automatic"
        Which multiplier acts in the force: that of the end of the step, or the mean of both ends. For strict
        constraints both conserve; for finite bulk moduli the mean conserves exactly but rings where the modulus is
        large, and the end-point one takes :math:`\|p_1 - p_0\|^2 / 2\kappa`, which the ledger books as numerical.
        Automatic: the end-point one where the solid says that its constraint is stiff.
    newton : NewtonMethod, optional

    References
    ----------
    .. [1] O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449-467.
    .. [2] O. Gonzalez, Comput. Methods Appl. Mech. Engrg. 190 (2000) 1763-1783.
    """

    summary: ClassVar[str] = "energy-momentum method; order 2, conserves energy and momenta to round-off; the default"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"energy", "momentum", "angular_momentum"})

    multiplier: str = choice(
        "automatic", ("automatic", "endpoint", "averaged"), doc="pressure that acts: of the end of the step or the mean"
    )
    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; chosen by size unless given")

    @property
    def stage(self) -> float:
        return 0.5

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        if motion.displacement.size == 0:
            return StepResult(motion, memory, StepReport())
        endpoint = self.multiplier == "endpoint" or (self.multiplier == "automatic" and solid.stiff_constraint)
        formula = Formula(
            time,
            dt,
            at=0.5,
            curvature=2.0 / (dt * dt),
            acceleration=(-2.0 / dt) * motion.velocity,
            multiplier_share=1.0 if endpoint else 0.5,
            discrete=True,
        )
        guess = motion.displacement + dt * motion.velocity
        solved = solve_stage(solid, law, motion, memory, formula, guess, self.newton)
        found = solved.end
        end = Motion(found.displacement, 2.0 * found.velocity - motion.velocity, found.multiplier)
        if not solved.newton.converged:
            return StepResult(end, memory, failed(solved))
        acting, span = formula.acting(motion, found.multiplier), (time, formula.end_time)
        works = solid.step_works(motion, end, law, span, multiplier=acting)
        return StepResult(end, solved.memory, finished(end, solved.newton.iterations, works))


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"energy_momentum": EnergyMomentum}
