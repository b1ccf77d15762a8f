"""Implicit midpoint rule."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, MacroSolid, Memory, Motion, NewtonMethod, StepResult, TimeIntegrator
from myobridge.parameters import part
from myobridge.solvers import implicit_stage


@final
@attrs.frozen
class Midpoint(TimeIntegrator):
    r"""Implicit midpoint rule: symplectic, order 2; conserves quadratic energies and momenta to round-off.

    .. math:: M \frac{v_1 - v_0}{\Delta t}
              + f\Bigl(\tfrac{u_0+u_1}{2}, \tfrac{u_1-u_0}{\Delta t}, t_0 + \tfrac{\Delta t}{2}\Bigr)
              = 0, \qquad v_1 = 2\,\frac{u_1-u_0}{\Delta t} - v_0

    References
    ----------
    .. [1] E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration (2006), sections II.1, IV.2 and VI.4.
    """

    summary: ClassVar[str] = "implicit midpoint rule; order 2, conserves quadratic energies to round-off"
    order: ClassVar[int] = 2
    inertia: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset({"energy", "momentum", "angular_momentum"})

    newton: NewtonMethod | None = part("newton", None, doc="Newton's method; the ordinary one unless given")

    @property
    def stage(self) -> float:
        return 0.5

    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        return implicit_stage(solid, law, motion, memory, time, dt, stage=0.5, inertia=True, newton=self.newton)


@hookimpl
def myobridge_time_integrators() -> dict[str, type[TimeIntegrator]]:
    return {"midpoint": Midpoint}
