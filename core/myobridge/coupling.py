"""Coupling schemes: the verbs of the bus and the integrator's step in different orders.

`splitting` is the default with inertia, `corrected` without; `monolithic` is the reference, `staggered` the thesis'
scheme, kept to show where it fails.
"""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.bus import CouplingBus
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    ActiveLaw,
    AffineLaw,
    Array,
    CouplingScheme,
    LawValue,
    MacroSolid,
    Memory,
    Motion,
    StepReport,
    StepResult,
    TimeIntegrator,
)

__all__ = ["Corrected", "Monolithic", "Splitting", "Staggered"]


def _stretches(solid: MacroSolid, bus: CouplingBus, motion: Motion, time: float, dt: float) -> tuple[Array, Array]:
    """Stretch and its rate at the end of the step; a given stretch has the mean rate over the step."""
    stretch = solid.stretch(motion.displacement, time + dt)
    if solid.n_unknowns == 0:
        return stretch, (stretch - bus.stretch) / dt
    return stretch, solid.stretch_rate(motion.displacement, motion.velocity, time + dt)


def _record(bus: CouplingBus, law: ActiveLaw, stretch: Array, rate: Array, dt: float) -> None:
    bus.record(law, stretch, rate, (rate - bus.stretch_rate) / dt if law.inertance is not None else None)


def _clamp_report(bus: CouplingBus, solid: MacroSolid, tension: Array, stretch: Array) -> StepReport:
    """Works of a clamp: it supplies what sliding puts into the heads, or what a tension without energy asks for."""
    if bus.model.has_energy:
        return StepReport(external_work=bus.totals.work)
    work = float(np.dot(solid.site_volumes * 0.5 * (tension + bus.tension), stretch - bus.stretch))
    return StepReport(external_work=work, active_work=-work)


def _follow(bus: CouplingBus, solid: MacroSolid, motion: Motion, memory: Memory, time: float, dt: float) -> StepResult:
    """Step of a solid without unknowns: the population follows the given stretch, exactly where the model can."""
    tension = bus.tension
    stretch, rate = _stretches(solid, bus, motion, time, dt)
    bus.advance(stretch, dt)
    _record(bus, bus.active_law(), stretch, rate, dt)
    return StepResult(motion, memory, _clamp_report(bus, solid, tension, stretch))


@final
@attrs.frozen
class Splitting(CouplingScheme):
    r"""Strang splitting: react dt/2, move with the population frozen, slide, react dt/2.

    The frozen population is a quadratic fibre energy, so an integrator that conserves energy for the solid conserves
    it for solid and cross-bridges together. Order 2 with inertia; 1 without, where the last reaction leaves the
    tension out of balance (the recorded tension is that of the mechanics stage).
    """

    summary: ClassVar[str] = "react dt/2, mechanics with the population frozen, react dt/2; conserves energy"

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
        bus.react(0.5 * dt)
        law = bus.active_law()
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, rate = _stretches(solid, bus, result.motion, time, dt)
        before = bus.tension
        _record(bus, law, stretch, rate, dt)
        bus.slide(stretch, law)
        bus.react(0.5 * dt)
        if solid.n_unknowns == 0:
            return StepResult(motion, memory, _clamp_report(bus, solid, before, stretch))
        return result


@final
@attrs.frozen
class Corrected(CouplingScheme):
    r"""One corrector on the exact path: predict with the affine law, redo the population along the path, correct.

    The population is advanced to the integrator's stage (end point or midpoint), and the solid is solved once more
    with the affine law through two tensions that are known by then: after the step with the filaments held, and after
    the step along the predicted path,

    .. math:: T(\lambda) = T_1 + \max\Bigl(\frac{T_1 - T_0}{\lambda_1 - \lambda_0}, 0\Bigr) (\lambda - \lambda_1) .

    This secant knows how the population yields along the path; the frozen population's slope does not, and costs two
    to three times the error at a step of 10 ms. Order 2 without inertia.
    """

    summary: ClassVar[str] = "predict with the frozen law, redo the population along the path, correct once"

    # Below this displacement of the heads [reach] the secant is mostly round-off.
    SMALLEST = 1e-6

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
        if solid.n_unknowns == 0:
            return _follow(bus, solid, motion, memory, time, dt)
        stage = integrator.stage
        if stage == 0.0:
            law = bus.active_law()
        else:
            bus.react(stage * dt)
            held = bus.active_law()
            predicted = integrator.step(solid, held, motion, memory, time, dt)
            if not predicted.report.converged:
                return predicted
            law = self._along_path(bus, solid, held, predicted.motion, time, dt, stage)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, rate = _stretches(solid, bus, result.motion, time, dt)
        bus.restart()
        bus.advance(stretch, dt)
        _record(bus, law if stage == 1.0 else bus.active_law(), stretch, rate, dt)
        return result

    def _along_path(
        self,
        bus: CouplingBus,
        solid: MacroSolid,
        held: ActiveLaw,
        predicted: Motion,
        time: float,
        dt: float,
        stage: float,
    ) -> ActiveLaw:
        """Law through the tension with filaments held and the tension along the predicted path."""
        start = bus.stretch
        target = start + stage * (solid.stretch(predicted.displacement, time + dt) - start)
        bus.restart()
        bus.advance(target, stage * dt)
        law = bus.active_law()
        if not law.has_potential:
            return law  # a law of the rate holds along the whole path as it is
        rate = np.zeros_like(target)
        before, after = held.evaluate(start, rate), law.evaluate(target, rate)
        moved = target - start
        far = np.abs(bus.model.gear * moved) > self.SMALLEST
        secant = (after.tension - before.tension) / np.where(far, moved, 1.0)
        slope = np.where(far, np.maximum(secant, 0.0), after.stiffness)
        return AffineLaw(target, after.tension, slope, law.inertance)


@final
@attrs.frozen
class Staggered(CouplingScheme):
    r"""The thesis' scheme: the tension of the last step acts as a constant force, then the population follows.

    As the step goes to 0 its amplification without inertia is :math:`-K_{active}/K_{passive}`: it fails at every step
    where the cross-bridges are stiffer than the tissue, and a smaller step does not help.
    """

    summary: ClassVar[str] = "the thesis' scheme: last step's tension as a constant force; kept to show why it fails"

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
        if solid.n_unknowns == 0:
            return _follow(bus, solid, motion, memory, time, dt)
        now = bus.active_law()
        tension = now.evaluate(bus.stretch, bus.stretch_rate).tension
        law = AffineLaw(bus.stretch, tension, np.zeros_like(tension), now.inertance)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, rate = _stretches(solid, bus, result.motion, time, dt)
        bus.advance(stretch, dt)
        _record(bus, law, stretch, rate, dt)
        return result


@final
@attrs.frozen
class Monolithic(CouplingScheme):
    r"""Newton on the full step: the tension is that of the population advanced to the stretch that is sought.

    The law's slope is a one-sided difference of two advances, so every evaluation costs two.
    """

    summary: ClassVar[str] = "Newton on the full step, the population advanced inside; the reference"
    implicit_only: ClassVar[bool] = True

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
        if solid.n_unknowns == 0:
            return _follow(bus, solid, motion, memory, time, dt)
        law = AdvancedLaw(bus, integrator.stage * dt)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, rate = _stretches(solid, bus, result.motion, time, dt)
        bus.advance(stretch, dt)
        _record(bus, bus.active_law(), stretch, rate, dt)
        return result


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
        return self._bus.active_law().inertance

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        here = self._bus.law_after(stretch, self._dt).evaluate(stretch, stretch_rate)
        moved = stretch + self.DIFFERENCE
        there = self._bus.law_after(moved, self._dt).evaluate(moved, stretch_rate)
        slope = (there.tension - here.tension) / self.DIFFERENCE
        return LawValue(here.tension, slope, here.rate_sensitivity)

    def scaled(self, factor: Array) -> ActiveLaw:
        raise NotImplementedError("the law of a full step is in Pa already")


@hookimpl
def myobridge_couplings() -> dict[str, type[CouplingScheme]]:
    return {"splitting": Splitting, "corrected": Corrected, "staggered": Staggered, "monolithic": Monolithic}
