"""Symplectic Euler."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, StepResult, TimeIntegrator
from myobridge.solvers import acceleration, step_report


@final
@attrs.frozen
class SymplecticEuler(TimeIntegrator):
    r"""Symplectic Euler (thesis, Method 4.14): explicit, order 1, energy error bounded for ever.

    .. math:: v_1 = v_0 - \Delta t\,M^{-1} f(u_0, v_0, t_0), \qquad u_1 = u_0 + \Delta t\,v_1

    Stable for :math:`\Delta t < 2/\omega_{max}`. A tension that depends on the rate sees the rate of the last step.
    Departures: the thesis' formula lacks the division by the mass.
    """

    summary: ClassVar[str] = "symplectic Euler (thesis, Method 4.14); explicit, order 1, bounded energy error"
    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = True
    constraints: ClassVar[bool] = False
    conserves: ClassVar[frozenset[str]] = frozenset({"bounded_energy", "momentum", "angular_momentum"})

    @property
    def stage(self) -> float:
        return 0.0

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        velocity = motion.velocity + dt * acceleration(solid, law, motion, time)
        end = Motion(motion.displacement + dt * velocity, velocity, motion.multiplier)
        return StepResult(end, memory, step_report(solid, law, motion, end, motion, time, (time, time + dt)))


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"symplectic_euler": SymplecticEuler}
