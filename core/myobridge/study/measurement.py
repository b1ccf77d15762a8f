"""Measurement: one run of one variant, under a clock, with its quantities of interest after every step."""

from __future__ import annotations

import platform
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import attrs
import numpy as np

from myobridge.errors import MyobridgeError
from myobridge.interfaces import Array
from myobridge.parameters import declared
from myobridge.plan import Plan
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.study.quantities import Quantity, available, reader
from myobridge.work import counted

__all__ = ["Course", "Measurement", "Task", "kind_of", "measured"]

_WARM_STEPS = 2
# What has been run in this process already: its kernels are loaded.
_WARM: set[str] = set()


@attrs.frozen(eq=False)
class Course:
    """Quantities over time: `times` (n,) [s], `values` by name, each (n, k)."""

    times: Array
    values: Mapping[str, Array]


@attrs.frozen(eq=False)
class Task:
    """What is to be run.

    Attributes
    ----------
    scene : str
        TOML of the scene of the variant.
    folder : str
        Where files named in it are looked for.
    quantities : sequence of Quantity
    stops : sequence of float
        Times at which steps end too [s].
    limit : float
        CPU seconds after which the run is given up: it cannot win any more.
    optional : bool
        Whether quantities that the scene has not are left out, instead of an error.
    """

    scene: str
    folder: str
    quantities: Sequence[Quantity]
    stops: Sequence[float] = ()
    limit: float = float("inf")
    optional: bool = False


@attrs.frozen(eq=False, kw_only=True)
class Measurement:
    """What a run gave.

    Attributes
    ----------
    failure : str
        Why there is no result; empty where there is one.
    stopped : bool
        Whether it was given up at its limit.
    course : Course or None
    cpu, wall, setup : float
        Seconds of the steps, on all cores and by the clock, and of building what is stepped.
    steps : int
    work : mapping
        Counts of `myobridge.work.WORK`.
    host : str
        Where it ran.
    """

    failure: str = ""
    stopped: bool = False
    course: Course | None = None
    cpu: float = 0.0
    wall: float = 0.0
    setup: float = 0.0
    steps: int = 0
    work: Mapping[str, int] = attrs.field(factory=dict)
    host: str = attrs.field(factory=platform.node)


def measured(task: Task) -> Measurement:
    """Run a task; whatever goes wrong is in the answer."""
    try:
        return _run(task)
    except MyobridgeError as error:
        return Measurement(failure=str(error))
    except MemoryError as error:
        return Measurement(failure=f"not enough memory: {error}")
    except Exception as error:  # a plugin's code may raise anything; here it is a row of the table
        return Measurement(failure=f"{type(error).__name__}: {error}")


def _run(task: Task) -> Measurement:
    scene = Scene.from_toml(task.scene, folder=Path(task.folder))
    started = perf_counter()
    plan = Plan.of(scene)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        _warm(plan, scene.duration)
        simulation = plan.simulation()
        setup = perf_counter() - started
        return _stepped(simulation, scene.duration, task, setup)


def _stepped(simulation: Simulation, end: float, task: Task, setup: float) -> Measurement:
    known = available(simulation) if task.optional else {}
    wanted = [
        quantity for quantity in task.quantities if not task.optional or quantity.function or quantity.name in known
    ]
    readers = {quantity.name: reader(quantity, simulation) for quantity in wanted}
    simulation.stop_at(list(task.stops))
    times, rows = [simulation.time], {name: [read(simulation)] for name, read in readers.items()}
    kept = [(rows[name], read) for name, read in readers.items()]
    cpu = wall = 0.0
    with counted() as work:
        while not simulation.finished(end) and cpu <= task.limit:
            clock, processor = perf_counter(), process_time()
            simulation.step(end)
            cpu += process_time() - processor
            wall += perf_counter() - clock
            times.append(simulation.time)
            for row, read in kept:
                row.append(read(simulation))
    values = {name: _table(name, found) for name, found in rows.items()}
    said: dict[str, Any] = {"cpu": cpu, "wall": wall, "setup": setup, "steps": simulation.steps, "work": dict(work)}
    for name, found in values.items():
        if not np.all(np.isfinite(found)):
            return Measurement(failure=f"'{name}' is not finite", **said)
    return Measurement(stopped=not simulation.finished(end), course=Course(np.array(times), values), **said)


def _table(name: str, rows: list[Any]) -> Array:
    try:
        table = np.array(rows, dtype=float)
    except ValueError:
        raise MyobridgeError(f"quantities: '{name}' changes its shape during the run") from None
    return table.reshape(len(rows), -1)


def _warm(plan: Plan, end: float) -> None:
    """Take a few steps of the same kind first, so that compiling and loading kernels is not on the clock."""
    kind = kind_of(plan.parts)
    if kind in _WARM:
        return
    _WARM.add(kind)
    try:
        simulation = plan.simulation()
        for _ in range(_WARM_STEPS):
            if not simulation.finished(end):
                simulation.step(end)
    except Exception:  # it will be said when it is measured
        return


def kind_of(part: Any) -> str:
    """Which code runs: classes of all parts and the words that they were given, not the numbers."""
    if isinstance(part, Mapping):
        return ";".join(f"{key}={kind_of(value)}" for key, value in part.items())
    if isinstance(part, list | tuple):
        return ",".join(map(kind_of, part[:8]))
    said = declared(type(part))
    if said:
        return f"{type(part).__qualname__}({';'.join(kind_of(getattr(part, name)) for name in said)})"
    return part if isinstance(part, str) else type(part).__name__
