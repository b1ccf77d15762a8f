"""Simulation: one solid, one cross-bridge model, one integrator, one coupling scheme, stepped through time."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from myobridge.bus import CouplingBus
from myobridge.coupling import Corrected, Splitting
from myobridge.errors import SceneError
from myobridge.interfaces import (
    ActivationKinetics,
    Array,
    CouplingScheme,
    CrossBridgeModel,
    MacroSolid,
    Memory,
    Motion,
    SarcomereDensity,
    Signal,
    StepReport,
    StepResult,
    TimeIntegrator,
)
from myobridge.ledger import Ledger
from myobridge.solvers import kinetic_energy, strictly_constrained
from myobridge.starts import Fibres, Start, begun
from myobridge.step_control import StepControl
from myobridge.step_error import StepError
from myobridge.stimulation import Stimulation, located

__all__ = ["Simulation"]


class Simulation:
    """Composition of plugins that steps.

    Parameters
    ----------
    solid : MacroSolid
    integrator : TimeIntegrator
    cross_bridges : CrossBridgeModel, optional
        Without it the solid is passive, and no bus exists.
    coupling : CouplingScheme, optional
        Default: `splitting` with inertia, `corrected` without.
    activation : Signal, optional
        Stimulation in [0, 1]; without it the muscle is fully active.
    calcium : ActivationKinetics, optional
        Stage between stimulation and activation.
    sarcomere_density : SarcomereDensity, optional
        Local density; 1 without.
    dt : float
        Nominal step [s].
    tolerance : float, optional
        Largest error of a displacement in one step [m], as `myobridge.step_error` estimates it; longer steps are
        halved, down from `dt`.
    start : {"as_given", "projected", "equilibrium"}, optional
        Where it begins, see `myobridge.starts`. None: with whatever the solid says, for a state to be restored.

    Attributes
    ----------
    begun : Start
        How it began.

    Raises
    ------
    SceneError
        If the parts do not go together; the message says which and why.
    """

    def __init__(
        self,
        *,
        solid: MacroSolid,
        integrator: TimeIntegrator,
        cross_bridges: CrossBridgeModel | None = None,
        coupling: CouplingScheme | None = None,
        activation: Signal | None = None,
        calcium: ActivationKinetics | None = None,
        sarcomere_density: SarcomereDensity | None = None,
        dt: float = 1e-3,
        tolerance: float | None = None,
        start: str | None = "as_given",
    ) -> None:
        if not dt > 0.0:
            raise SceneError(f"step: is {dt!r}; expected a number in (0, inf) [s]")
        if tolerance is not None and not tolerance > 0.0:
            raise SceneError(f"tolerance: is {tolerance!r}; expected a number in (0, inf) [m]")
        self.solid = solid
        self.integrator = integrator
        self.step_error = None if tolerance is None else StepError(tolerance, integrator.order)
        # A passive solid has nothing to couple: no scheme exists then.
        self.coupling = coupling
        if coupling is None and cross_bridges is not None:
            self.coupling = Splitting() if integrator.inertia else Corrected()
        self.time = 0.0
        self.steps = 0
        self.control = StepControl(dt)
        self.seconds = {"mechanics": 0.0, "cross_bridges": 0.0, "ledger": 0.0}
        self.iterations = 0
        self.bus: CouplingBus | None = None
        activation = located(activation, solid)
        self._check(cross_bridges, activation, calcium, sarcomere_density)
        density, fibres = None, None
        if cross_bridges is not None:
            if sarcomere_density is not None:
                density = np.array(np.broadcast_to(sarcomere_density.at(solid.site_positions()), (solid.n_sites,)))
            unit = cross_bridges.p_max * (np.ones(solid.n_sites) if density is None else density)
            fibres = Fibres(cross_bridges, Stimulation(solid.n_sites, activation, calcium), unit)
        self.begun = Start(solid.rest_motion()) if start is None else begun(start, solid, integrator, dt, fibres)
        self.motion: Motion = self.begun.motion
        self.memory: Memory = integrator.initial_memory(solid, self.motion)
        if cross_bridges is not None:
            self.bus = CouplingBus(
                cross_bridges,
                solid.site_volumes,
                solid.stretch(self.motion.displacement, 0.0),
                activation=activation,
                kinetics=calcium,
                density=density,
                population=self.begun.population,
            )
            if solid.n_unknowns == 0 or integrator.inertia:
                self.bus.stretch_rate = solid.stretch_rate(self.motion.displacement, self.motion.velocity, 0.0)
        self._check_statics()
        jumps = {*solid.jumps(), *(() if activation is None else activation.jumps())}
        self._jumps = sorted(jumps)
        kinetic, elastic, cross_bridge = self._stored(0.0)
        self.ledger = Ledger(kinetic, elastic, cross_bridge)

    # ------------------------------------------------------------------ stepping

    def step(self, end: float = float("inf")) -> StepReport:
        """One accepted step, not beyond `end`; halves the step as often as needed.

        Raises
        ------
        StepFailed
            After 12 halvings; the simulation stands where the last good step left it.
        """
        while True:
            target, dt = self.control.next(self.time, self._jumps, end)
            report = self._try(dt)
            if report.converged:
                self.time = target
                self.steps += 1
                self.iterations += report.iterations
                self.control.succeeded(target, room=self.step_error is None or self.step_error.room)
                return report
            self.control.failed(self.time, report.reason, dt)

    def run(self, end: float, after_step: Callable[[Simulation, StepReport], Any] | None = None) -> Simulation:
        """Step until `end` [s]; `after_step` is called with the simulation and the report of each accepted step."""
        while not self.finished(end):
            report = self.step(end)
            if after_step is not None:
                after_step(self, report)
        return self

    def finished(self, end: float) -> bool:
        """Whether `end` is reached, up to round-off of the step."""
        return self.time >= end - 1e-6 * self.control.dt

    def stop_at(self, times: Array | list[float] | tuple[float, ...]) -> None:
        """Make steps end at the given `times` [s] too."""
        self._jumps = sorted({*self._jumps, *(float(time) for time in times)})

    def _try(self, dt: float) -> StepReport:
        """One step of `dt`; a step that fails leaves everything as it was."""
        started = perf_counter()
        bus = self.bus
        if bus is None or self.coupling is None:
            result = self.integrator.step(self.solid, None, self.motion, self.memory, self.time, dt)
        else:
            spent = bus.seconds
            bus.begin(self.time, dt)
            step = self.coupling.step(bus, self.solid, self.integrator, self.motion, self.memory, self.time, dt)
            result = self._finite(step)
            self.seconds["cross_bridges"] += bus.seconds - spent
            self.seconds["mechanics"] -= bus.seconds - spent
        stepped = perf_counter()
        self.seconds["mechanics"] += stepped - started
        result = self._exact_enough(result, dt)
        if not result.report.converged:
            if bus is not None:
                bus.discard()
            return result.report
        start, self.motion, self.memory = self.motion, result.motion, result.memory
        if self.step_error is not None:
            self.step_error.accept(start, dt, self.step_error.of(start, result.motion, dt))
        if bus is not None:
            bus.commit()
        self._close(result.report, self.time + dt)
        self.seconds["ledger"] += perf_counter() - stepped
        return result.report

    def _exact_enough(self, result: StepResult, dt: float) -> StepResult:
        """Turn a step whose estimated error is too large into a failed one."""
        if self.step_error is None or not result.report.converged:
            return result
        error, tolerance = self.step_error.of(self.motion, result.motion, dt), self.step_error.tolerance
        if error <= tolerance:
            return result
        reason = f"its estimated error, {error:.2g} m, exceeds the tolerance of {tolerance:.2g} m"
        return result._replace(report=StepReport(converged=False, reason=reason))

    def _finite(self, result: StepResult) -> StepResult:
        """Turn a tension that is not finite into a failed step, so that it is retried and never recorded."""
        assert self.bus is not None
        if result.report.converged and not math.isfinite(self.bus.tension.sum()):
            return result._replace(report=StepReport(converged=False, reason="the tension is not finite"))
        return result

    # ------------------------------------------------------------------ energy

    def _stored(self, time: float) -> tuple[float, float, float]:
        solid, bus = self.solid, self.bus
        kinetic = 0.0
        inertance = None if bus is None else bus.inertance
        if solid.n_unknowns == 0:
            if bus is not None and inertance is not None:  # heads with mass, moved by the clamp
                kinetic = 0.5 * float(np.dot(solid.site_volumes * inertance, bus.stretch_rate**2))
        elif self.integrator.inertia:
            kinetic = kinetic_energy(solid, inertance, self.motion.velocity)
        return kinetic, solid.elastic_energy(self.motion.displacement, time), 0.0 if bus is None else bus.energy()

    def _close(self, report: StepReport, time: float) -> None:
        kinetic, elastic, cross_bridge = self._stored(time)
        external = report.external_work
        if self.solid.n_unknowns == 0:
            external += kinetic - self.ledger.kinetic
        flows = {"external": external, "viscous": report.viscous_work, "numerical": report.numerical_work}
        bus = self.bus
        if bus is not None:
            totals = bus.totals
            flows |= {"attached": totals.attached, "detached": totals.detached}
            flows["numerical"] += totals.numerical
            if not bus.model.has_energy:
                flows["active_work"] = report.active_work
        self.ledger.close(kinetic=kinetic, elastic=elastic, cross_bridge=cross_bridge, **flows)

    # ------------------------------------------------------------------ what does not go together

    def _check(
        self,
        cross_bridges: CrossBridgeModel | None,
        activation: Signal | None,
        calcium: ActivationKinetics | None,
        sarcomere_density: SarcomereDensity | None,
    ) -> None:
        parts = {"activation": activation, "calcium": calcium, "sarcomere_density": sarcomere_density}
        if cross_bridges is None:
            for name, given in parts.items():
                if given is not None:
                    raise SceneError(
                        f"{name}: acts on cross-bridges, and there are none; give cross_bridges or leave it out"
                    )
        if activation is not None:
            values = np.asarray(activation.value(0.0))
            if np.any(values < 0.0) or np.any(values > 1.0):
                raise SceneError(f"activation: starts at {values}; expected values in [0, 1]")
            if values.shape not in ((), (1,), (self.solid.n_sites,)):
                raise SceneError(
                    f"activation: has {values.shape[0]} values; expected 1 or {self.solid.n_sites}, one for each site"
                )
        if self.integrator.inertia and not self.solid.inertia:
            raise SceneError(
                f"integrator: {type(self.integrator).__name__} integrates inertia, and {type(self.solid).__name__} has "
                "no mass; use quasi_static"
            )
        if not self.integrator.constraints and strictly_constrained(self.solid):
            raise SceneError(
                f"integrator: {type(self.integrator).__name__} keeps no constraint, and {type(self.solid).__name__} "
                "has a strict one; use rattle, half_explicit or an implicit integrator, or a finite bulk modulus"
            )
        if self.coupling is not None and self.coupling.implicit_only and self.integrator.explicit:
            raise SceneError(
                f"coupling: {type(self.coupling).__name__} needs an implicit integrator, and "
                f"{type(self.integrator).__name__} is explicit"
            )

    def _check_statics(self) -> None:
        if self.integrator.inertia:
            return
        if self.bus is not None and self.bus.inertance is not None and self.solid.n_unknowns > 0:
            raise SceneError(
                "cross_bridges: heads with mass need inertia: use an integrator that has it, a clamp, or massless heads"
            )
        obstacle = self.solid.statics_obstacle(self.motion, None if self.bus is None else self.bus.active_law_at_rest())
        if obstacle:
            raise SceneError(f"solid: {obstacle}")
