"""Coupling scheme: the order in which one step asks the population and the solid."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

from myobridge.interfaces.macro_solid import MacroSolid
from myobridge.interfaces.motion import Motion
from myobridge.interfaces.time_integrator import Memory, StepResult, TimeIntegrator

if TYPE_CHECKING:
    from myobridge.bus import CouplingBus

__all__ = ["CouplingScheme"]


class CouplingScheme(ABC):
    """Abstract scheme: the bus's verbs (react, active_law, slide, advance) around the integrator's step.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    implicit_only : bool
        Whether it needs an implicit integrator.
    """

    summary: ClassVar[str] = ""
    implicit_only: ClassVar[bool] = False

    @abstractmethod
    def step(
        self,
        bus: CouplingBus,
        solid: MacroSolid,
        integrator: TimeIntegrator,
        motion: Motion,
        memory: Memory,
        time: float,
        dt: float,
    ) -> StepResult:
        """One step; the bus has begun and holds a trial copy, which the caller commits or discards."""
