"""Backward Euler."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, NewtonMethod, StepResult, TimeIntegrator
from myobridge.parameters import part
from myobridge.solvers import implicit_stage


@final
@attrs.frozen
class BackwardEuler(TimeIntegrator):
    r"""Backward Euler: order 1, stable at every step, and paid for with lost energy.

    .. math:: M \frac{v_1 - v_0}{\Delta t} + f(u_1, v_1, t_1) = 0, \qquad v_1 = \frac{u_1-u_0}{\Delta t}
    """

    summary: ClassVar[str] = "backward Euler; order 1, always stable, loses energy"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"momentum"})

    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; the ordinary one unless given")

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        return implicit_stage(solid, law, motion, memory, time, dt, stage=1.0, inertia=True, newton=self.newton)


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"backward_euler": BackwardEuler}
