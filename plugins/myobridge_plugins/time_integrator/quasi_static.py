"""Quasi-static equilibrium."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, NewtonMethod, StepResult, TimeIntegrator
from myobridge.parameters import part
from myobridge.solvers import implicit_stage


@final
@attrs.frozen
class QuasiStatic(TimeIntegrator):
    r"""Equilibrium at the end of every step; no inertia, no mass matrix. Rates are differences over the step.

    .. math:: f\Bigl(u_1, \frac{u_1-u_0}{\Delta t}, t_1\Bigr) = 0

    Order 1 where the tension depends on the rate; equilibria without rates are exact at every step.
    """

    summary: ClassVar[str] = "equilibrium at the end of each step, no inertia; default without inertia"
    order: ClassVar[int] = 1
    inertia: ClassVar[bool] = False
    conserves: ClassVar[frozenset[str]] = frozenset(())

    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; the ordinary one unless given")

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        return implicit_stage(solid, law, motion, memory, time, dt, stage=1.0, inertia=False, newton=self.newton)


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"quasi_static": QuasiStatic}
