"""Laws that a coupling scheme puts in the place of the frozen population's: a held tension, and that of a full step."""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.bus import CouplingBus
from myobridge.interfaces import ActiveLaw, Array, LawValue

__all__ = ["AdvancedLaw", "HeldTension"]


@final
class HeldTension(ActiveLaw):
    """Tension that stays what it was: no stiffness, and no energy, so that its work is booked as work."""

    __slots__ = ("_inertance", "_tension")

    def __init__(self, tension: Array, inertance: Array | None) -> None:
        self._tension = tension
        self._inertance = inertance

    @property
    def inertance(self) -> Array | None:
        return self._inertance

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        return LawValue(self._tension, np.zeros_like(self._tension))

    def scaled(self, factor: Array) -> ActiveLaw:
        raise NotImplementedError("the tension of a step is in Pa already")


@final
class AdvancedLaw(ActiveLaw):
    """Tension after the population has been advanced from the start of the step to the stretch asked for."""

    __slots__ = ("_bus", "_dt")

    # A hundred-millionth of the stretch moves the heads by 1e-6 reach: far above round-off, far below a bin.
    DIFFERENCE = 1e-8

    def __init__(self, bus: CouplingBus, dt: float) -> None:
        self._bus = bus
        self._dt = dt

    @property
    def inertance(self) -> Array | None:
        return self._bus.inertance

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        here = self._bus.law_after(stretch, self._dt).evaluate(stretch, stretch_rate)
        moved = stretch + self.DIFFERENCE
        there = self._bus.law_after(moved, self._dt).evaluate(moved, stretch_rate)
        slope = (there.tension - here.tension) / self.DIFFERENCE
        return LawValue(here.tension, slope, here.rate_sensitivity)

    def scaled(self, factor: Array) -> ActiveLaw:
        raise NotImplementedError("the law of a full step is in Pa already")
