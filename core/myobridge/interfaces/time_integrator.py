r"""Time integrator: one step of the solid with the cross-bridge population frozen.

.. math:: M \dot v + f(u, v, t; T) = 0, \qquad \dot u = v

The integrator sees the active law only, never the population. Its memory (histories of multi-step methods) is passed
in and out, so that a step that failed leaves nothing behind and a checkpoint holds everything.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import attrs

from myobridge.interfaces.active_law import ActiveLaw, Array
from myobridge.interfaces.macro_solid import MacroSolid
from myobridge.interfaces.motion import Motion

__all__ = ["Memory", "StepReport", "StepResult", "TimeIntegrator"]

Memory = Mapping[str, Array]
"""What an integrator remembers from step to step, by name; written to checkpoints."""


@attrs.frozen
class StepReport:
    """How a step went.

    Attributes
    ----------
    converged : bool
        False when the step must be repeated with half the step.
    reason : str
        Why not, in a sentence.
    iterations : int
        Newton iterations; 0 for an explicit method.
    external_work : float
        Work of the loads over the step [J], at the loads the method itself saw.
    active_work : float
        Work [J] that a law without potential did on the solid.
    viscous_work : float
        Energy [J] that viscosity took away.
    numerical_work : float
        Energy [J] that the method itself added.
    """

    converged: bool = True
    reason: str = ""
    iterations: int = 0
    external_work: float = 0.0
    active_work: float = 0.0
    viscous_work: float = 0.0
    numerical_work: float = 0.0


class StepResult(NamedTuple):
    """Motion and memory at the end of a step, and how it went."""

    motion: Motion
    memory: Memory
    report: StepReport


class TimeIntegrator(ABC):
    """Abstract time integrator.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    order : int
        Order in the step; one test holds every registered integrator to it.
    explicit : bool
        Whether a step needs no solve.
    inertia : bool
        Whether it integrates the inertia; one that does not is for scenes without.
    constraints : bool
        Whether it keeps constraints without compliance; those with one act like springs for any method.
    conserves : frozenset of str
        Of "energy" (linear problems to round-off), "bounded_energy", "momentum", "angular_momentum".
    """

    summary: ClassVar[str] = ""
    order: ClassVar[int] = 1
    explicit: ClassVar[bool] = False
    inertia: ClassVar[bool] = True
    constraints: ClassVar[bool] = True
    conserves: ClassVar[frozenset[str]] = frozenset()

    @property
    def stage(self) -> float:
        """Fraction of the step at which the law is asked for the tension: 1 end point, 1/2 midpoint.

        Coupling schemes that move the population within the step need it.
        """
        return 1.0

    def initial_memory(self, solid: MacroSolid, motion: Motion) -> Memory:
        """Memory at the start; empty for one-step methods."""
        return {}

    @abstractmethod
    def step(
        self, solid: MacroSolid, law: ActiveLaw | None, motion: Motion, memory: Memory, time: float, dt: float
    ) -> StepResult:
        """Advance `motion` from `time` by `dt`; a step that fails says so in its report and raises nothing."""
