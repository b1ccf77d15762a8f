"""Trial: one scene, run once under gauges, and stopped as soon as it is lost."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Collection, Mapping
from time import process_time
from typing import Any

import attrs
import numpy as np

from myobridge.atlas.catalogue import ALWAYS, PATH_GAUGES, RUN_GAUGES
from myobridge.errors import MyobridgeError, StepFailed
from myobridge.plan import Plan
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.statics import Statics
from myobridge.step_control import StepControl

__all__ = ["Trial", "tried"]

# Energy made of nothing [of that at the start] beyond which a run will not come back.
_BLOWN_UP = 1e6


@attrs.frozen(eq=False)
class Trial:
    """What came of a scene.

    Attributes
    ----------
    refused : str
        Message with which the scene was refused; empty where it was run.
    stopped : str
        Why it ended early, in a sentence; empty where it reached its end.
    measured : mapping
        Quantities by name.
    composed : Simulation, Statics or None
        What was run, as it was before the first step where it is a path.
    traces : mapping
        The gauges, for the comparison with a fine run.
    """

    refused: str = ""
    stopped: str = ""
    measured: Mapping[str, float] = attrs.field(factory=dict)
    composed: Simulation | Statics | None = None
    traces: Mapping[str, Any] = attrs.field(factory=dict)


class _Lost(StepFailed):
    """More halvings than allowed."""


@attrs.define
class _CountedControl(StepControl):
    """Step control that counts its halvings, and gives up when they are more than allowed."""

    allowed: float = math.inf
    count: int = 0

    def failed(self, time: float, reason: str, tried: float) -> None:
        self.count += 1
        if self.count > self.allowed:
            raise _Lost(f"halving {self.count} at t = {time:.4g} s, where {self.allowed:g} are allowed: {reason}")
        super().failed(time, reason, tried)


def tried(
    scene: Scene,
    wanted: Collection[str],
    *,
    halvings: float = math.inf,
    seconds: float = math.inf,
    fine: Trial | None = None,
    inspect: Callable[[Simulation | Statics], None] | None = None,
) -> Trial:
    """Run a scene and measure.

    Parameters
    ----------
    wanted : collection of str
        Quantities beyond those that are always measured.
    halvings : float
        How many halvings of the step are allowed; one more ends the trial.
    seconds : float
        Computing time that it may take [s].
    fine : Trial, optional
        Of the reference.
    inspect : callable, optional
        Told what will be run, before the first step.
    """
    try:
        composed = Plan.of(scene).composed()
        if inspect is not None:
            inspect(composed)
    except MyobridgeError as error:
        return Trial(refused=str(error))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        if isinstance(composed, Simulation):
            return _run(composed, scene, wanted, halvings, seconds, fine)
        return _path(composed, wanted, fine)


def _run(
    simulation: Simulation,
    scene: Scene,
    wanted: Collection[str],
    halvings: float,
    seconds: float,
    fine: Trial | None,
) -> Trial:
    names = [name for name in RUN_GAUGES if name in ALWAYS or name in wanted]
    gauges = {name: RUN_GAUGES[name](simulation) for name in names if RUN_GAUGES[name].applies(simulation)}
    control = simulation.control
    simulation.control = counted = _CountedControl(control.dt, control.halvings, control.successes, halvings)
    iterations, stopped, started = 0, "", process_time()
    while not stopped and not simulation.finished(scene.duration):
        try:
            report = simulation.step(scene.duration)
        except StepFailed as error:
            stopped = str(error)
            break
        except Exception as error:  # whatever a plugin's code raises is a finding about the plugin
            stopped = f"{type(error).__name__} at t = {simulation.time:.4g} s: {error}"
            break
        iterations = max(iterations, report.iterations)
        for gauge in gauges.values():
            gauge.observe(simulation, report)
        stopped = _lost(simulation, gauges, process_time() - started, seconds)
    measured = {"steps": float(simulation.steps), "iterations": float(iterations), "halvings": float(counted.count)}
    for name, gauge in gauges.items():
        measured[name] = gauge.value(None if fine is None else fine.traces.get(name))
    return Trial("", stopped, measured, simulation, gauges)


def _lost(simulation: Simulation, gauges: Mapping[str, Any], spent: float, seconds: float) -> str:
    """Why it makes no sense to go on; empty where it does."""
    where = f"at t = {simulation.time:.4g} s, after {simulation.steps} steps"
    if not np.all(np.isfinite(simulation.motion.displacement)) or not math.isfinite(simulation.ledger.total):
        return f"the motion is not finite {where}"
    growth = gauges["energy_growth"].value()
    if growth > _BLOWN_UP:
        return f"the energy has grown {growth:.1e} times {where}"
    if spent > seconds:
        return f"the computing time of {seconds:g} s was used up {where}"
    return ""


def _path(statics: Statics, wanted: Collection[str], fine: Trial | None) -> Trial:
    try:
        path = statics.trace()
    except Exception as error:  # as above
        return Trial(stopped=f"{type(error).__name__}: {error}", composed=statics)
    exact = None if fine is None else fine.traces
    names = [name for name in PATH_GAUGES if name in wanted or name in ("points", "path_iterations")]
    measured = {name: PATH_GAUGES[name]().value(statics, path, exact or None) for name in names}
    return Trial("", "" if path.completed else path.reason, measured, statics, {"statics": statics, "path": path})
