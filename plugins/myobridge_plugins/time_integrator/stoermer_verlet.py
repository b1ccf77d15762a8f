"""Störmer-Verlet."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.instant import just_before
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, StepResult, TimeIntegrator
from myobridge.solvers import acceleration, step_report


@final
@attrs.frozen
class StoermerVerlet(TimeIntegrator):
    r"""Störmer-Verlet, velocity form: explicit, symplectic, order 2, energy error bounded for ever.

    .. math:: v_{1/2} = v_0 + \tfrac{\Delta t}{2} a(u_0, v_0, t_0), \quad u_1 = u_0 + \Delta t\,v_{1/2}, \quad
              v_1 = v_{1/2} + \tfrac{\Delta t}{2} a(u_1, v_{1/2}, t_1)

    Stable for :math:`\Delta t < 2/\omega_{max}`. A tension that depends on the rate sees the rate of half a step ago,
    so that the order is 1 for such laws.

    References
    ----------
    .. [1] E. Hairer, C. Lubich, G. Wanner, Acta Numerica 12 (2003) 399-450.
    """

    summary: ClassVar[str] = "Störmer-Verlet; explicit, symplectic, order 2"
    order: ClassVar[int] = 2
    explicit: ClassVar[bool] = True
    constraints: ClassVar[bool] = False
    conserves: ClassVar[frozenset[str]] = frozenset({"bounded_energy", "momentum", "angular_momentum"})

    @property
    def stage(self) -> float:
        return 0.5

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        half = motion.velocity + 0.5 * dt * acceleration(solid, law, motion, time)
        moved = Motion(motion.displacement + dt * half, half, motion.multiplier)
        velocity = half + 0.5 * dt * acceleration(solid, law, moved, just_before(time + dt, dt))
        end = Motion(moved.displacement, velocity, motion.multiplier)
        middle = Motion(0.5 * (motion.displacement + end.displacement), half, motion.multiplier)
        return StepResult(end, memory, step_report(solid, law, motion, end, middle, time + 0.5 * dt, (time, time + dt)))


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"stoermer_verlet": StoermerVerlet}
