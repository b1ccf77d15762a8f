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
from myobridge.instant import just_before
from myobridge.interfaces import (
    ActiveLaw,
    AffineLaw,
    Array,
    CouplingScheme,
    MacroSolid,
    Memory,
    Motion,
    StepReport,
    StepResult,
    TimeIntegrator,
)
from myobridge.step_laws import AdvancedLaw, HeldTension

__all__ = ["Corrected", "Monolithic", "Splitting", "Staggered"]


def _stretches(solid: MacroSolid, motion: Motion, time: float, dt: float) -> tuple[Array, Array]:
    """Stretch and its rate at the end of the step, before a jump that happens there."""
    end = just_before(time + dt, dt)
    return solid.stretch(motion.displacement, end), solid.stretch_rate(motion.displacement, motion.velocity, end)


def _record(bus: CouplingBus, solid: MacroSolid, law: ActiveLaw, motion: Motion, time: float, dt: float) -> None:
    """Keep the tension at the end of the step; heads with mass add the acceleration of their stretch."""
    stretch, rate = _stretches(solid, motion, time, dt)
    acceleration = None
    if law.inertance is not None:
        if solid.n_unknowns == 0:  # the path tells its own acceleration
            near = 1e-3 * dt
            earlier = solid.stretch_rate(motion.displacement, motion.velocity, just_before(time + dt, dt) - near)
            acceleration = (rate - earlier) / near
        else:
            acceleration = (rate - bus.stretch_rate) / dt
    bus.record(law, stretch, rate, acceleration)


def _jump(bus: CouplingBus, solid: MacroSolid, motion: Motion, time: float) -> None:
    """A given stretch that jumps at the beginning of the step carries the heads at once; none reacts meanwhile."""
    if solid.n_unknowns == 0:
        stretch = solid.stretch(motion.displacement, time)
        if np.any(np.abs(stretch - bus.stretch) > _JUMP):
            bus.slide(stretch)


# Larger than the round-off of a continuous path, smaller than anything that moves a head.
_JUMP = 1e-9


def _clamp_report(bus: CouplingBus, solid: MacroSolid, tension: Array, stretch: Array) -> StepReport:
    """Works of a clamp: it supplies what sliding puts into the heads, or what a tension without energy asks for."""
    if bus.model.has_energy:
        return StepReport(external_work=bus.totals.work)
    work = float(np.dot(solid.site_volumes * 0.5 * (tension + bus.tension), stretch - bus.stretch))
    return StepReport(external_work=work, active_work=-work)


def _follow(bus: CouplingBus, solid: MacroSolid, motion: Motion, memory: Memory, time: float, dt: float) -> StepResult:
    """Step of a solid without unknowns: the population follows the given stretch, exactly where the model can."""
    tension = bus.tension
    _jump(bus, solid, motion, time)
    stretch, _ = _stretches(solid, motion, time, dt)
    bus.advance(stretch, dt)
    _record(bus, solid, bus.active_law(dt), motion, time, dt)
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
        before = bus.tension
        _jump(bus, solid, motion, time)
        bus.react(0.5 * dt)
        law = bus.active_law(integrator.stage * dt)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, _ = _stretches(solid, result.motion, time, dt)
        # A model without state has the tension of the end; the tension of a population is that of the mechanics stage.
        _record(bus, solid, law if bus.model.has_energy else bus.active_law(dt), result.motion, time, dt)
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
            law = bus.active_law(0.0)
        else:
            bus.react(stage * dt)
            held = bus.active_law(stage * dt)
            predicted = integrator.step(solid, held, motion, memory, time, dt)
            if not predicted.report.converged:
                return predicted
            law = self._along_path(bus, solid, held, predicted.motion, time, dt, stage)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        stretch, _ = _stretches(solid, result.motion, time, dt)
        bus.restart()
        bus.advance(stretch, dt)
        _record(bus, solid, law if stage == 1.0 else bus.active_law(dt), result.motion, time, dt)
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
        target = start + stage * (_stretches(solid, predicted, time, dt)[0] - start)
        bus.restart()
        bus.advance(target, stage * dt)
        law = bus.active_law(stage * dt)
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
        now = bus.active_law(0.0)
        law = HeldTension(now.evaluate(bus.stretch, bus.stretch_rate).tension, now.inertance)
        result = integrator.step(solid, law, motion, memory, time, dt)
        if not result.report.converged:
            return result
        bus.advance(_stretches(solid, result.motion, time, dt)[0], dt)
        _record(bus, solid, law, result.motion, time, dt)
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
        bus.advance(_stretches(solid, result.motion, time, dt)[0], dt)
        _record(bus, solid, bus.active_law(dt), result.motion, time, dt)
        return result


@hookimpl
def myobridge_couplings() -> dict[str, type[CouplingScheme]]:
    return {"splitting": Splitting, "corrected": Corrected, "staggered": Staggered, "monolithic": Monolithic}
