"""Unit costs: what a step of a kind of scene costs on this machine, measured once and kept for later.

A kind is the code that runs: the classes of all parts and the words they were given, not the numbers. Its costs are
measured on a coarse scene of the kind, or taken from a run that was made anyway.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import resource
import warnings
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import attrs
import numpy as np

from myobridge.errors import MyobridgeError
from myobridge.plan import Plan
from myobridge.recording import Recorder
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.study.measurement import kind_of
from myobridge.study.refinement import of_scene, refined

__all__ = ["UnitCosts", "cache_file", "keep", "kept", "measured_costs", "peak_memory", "shares", "size_of_plan"]

_SMALL = 3000
_COARSEST = -6
# Steps that are tried, within a patience [s]; more of them where they are cheap, up to some seconds.
_STEPS, _PATIENCE, _CHEAP = 60, 6.0, 1.0


@attrs.frozen(kw_only=True)
class UnitCosts:
    """Measured costs of one kind.

    Attributes
    ----------
    unknowns, values : int
        Sizes at which they were measured: unknowns with multipliers, and values of the micro state at all sites.
    mechanics, micro, rest : float
        Seconds a step: of the solid, of the cross-bridges, of everything else. Without time: of the whole path.
    setup : float
        Seconds until the first step is done: building, loading kernels.
    steps : int
        Steps from which they were taken.
    memory : float
        Bytes that the process grew by.
    """

    unknowns: int
    values: int
    mechanics: float
    micro: float
    rest: float
    setup: float
    steps: int
    memory: float = 0.0


def kept(plan: Plan) -> UnitCosts | None:
    """Costs of the plan's kind that were measured on this machine before; None where none were."""
    said = _read().get(_key(plan))
    try:
        return None if said is None else UnitCosts(**said)
    except TypeError:  # of another version
        return None


def keep(plan: Plan, costs: UnitCosts) -> None:
    """Keep the costs of a kind; a cache that cannot be written is none."""
    path, known = cache_file(), _read()
    known[_key(plan)] = attrs.asdict(costs)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f"{path.name}.{os.getpid()}")
        beside.write_text(json.dumps(known, indent=0), encoding="utf-8")
        os.replace(beside, path)
    except OSError:
        return


def measured_costs(plan: Plan) -> UnitCosts:
    """Costs of the plan's kind, from a few steps of a coarse scene of the kind; a path is followed to its end."""
    coarse = _coarse(plan)
    before, started, processor = peak_memory(), perf_counter(), process_time()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        composed = coarse.composed()
        if not isinstance(composed, Simulation):
            composed.trace()
            spent, setup, steps = min(perf_counter() - started, process_time() - processor), 0.0, 1
            costs = {"mechanics": spent, "micro": 0.0, "rest": 0.0}
        else:
            recorder = Recorder(coarse.scene.record, composed)
            costs, setup, steps = _stepped(composed, recorder, coarse.scene.duration, processor)
    unknowns, values = size_of_plan(coarse)
    grown = max(peak_memory() - before, 0.0)
    return UnitCosts(unknowns=unknowns, values=values, **costs, setup=setup, steps=steps, memory=grown)


def _stepped(
    simulation: Simulation, recorder: Recorder, end: float, processor: float
) -> tuple[dict[str, float], float, int]:
    recorder.observe(simulation)
    simulation.step(end)  # loads the kernels
    recorder.observe(simulation)
    setup = process_time() - processor
    began, marks = perf_counter(), [_mark(simulation)]
    while not simulation.finished(end) and perf_counter() - began < (_CHEAP if len(marks) > _STEPS else _PATIENCE):
        simulation.step(end)
        recorder.observe(simulation)
        marks.append(_mark(simulation))
    spent = np.diff(marks, axis=0)
    if not len(spent):
        return {"mechanics": setup, "micro": 0.0, "rest": 0.0}, setup, 1
    if len(spent) > 2:  # the costliest may have been the first to need some other kernel
        spent = np.delete(spent, np.argmax(spent[:, 0]), axis=0)
    wall, cpu, *phases = spent.sum(axis=0)
    a_step = dict(zip(simulation.seconds, np.array(phases) / len(spent), strict=True))
    return shares(a_step, wall, cpu, len(spent)), setup, len(spent)


def _mark(simulation: Simulation) -> list[float]:
    return [perf_counter(), process_time(), *simulation.seconds.values()]


def shares(a_step: Mapping[str, float], wall: float, cpu: float, steps: int) -> dict[str, float]:
    """Costs of a step by phase [s], from the clock's phases of a run that took `wall` and `cpu` seconds.

    What others did on the machine meanwhile is taken out: the lesser of the two is what an idle machine would show.
    """
    idle = min(wall, cpu) / wall if wall > 0.0 else 1.0
    micro, mechanics = idle * a_step["cross_bridges"], idle * a_step["mechanics"]
    return {"mechanics": mechanics, "micro": micro, "rest": max(idle * wall / steps - micro - mechanics, 0.0)}


def _coarse(plan: Plan) -> Plan:
    """The plan, or one of the same kind with a coarser mesh."""
    scene, found = plan.scene, plan
    mesh = {key: value for key, value in of_scene(scene).items() if key.startswith("solid.")}
    for level in range(-1, _COARSEST - 1, -1):
        if size_of_plan(found)[0] <= _SMALL or not mesh:
            break
        try:
            smaller = Plan.of(Scene.from_toml(scene.to_toml(), folder=scene.folder, settings=refined(mesh, level)))
            if size_of_plan(smaller)[0] == 0:
                break
            found = smaller
        except MyobridgeError:  # it cannot be any coarser
            break
    return found


def size_of_plan(plan: Plan) -> tuple[int, int]:
    """Unknowns with multipliers, and values of the micro state at all sites."""
    solid, sizes = plan.parts["solid"], plan.sizes()
    unknowns = solid.n_unknowns + solid.rest_motion().multiplier.size
    return int(unknowns), int(sizes["sites"] * sizes.get("values a site", 0))


def peak_memory() -> float:
    """Most memory that this process has had [bytes]."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def cache_file() -> Path:
    """File of this machine's unit costs."""
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(home) / "myobridge" / "unit-costs.json"


def _key(plan: Plan) -> str:
    import myobridge

    said = f"{myobridge.__version__} {platform.node()} {os.cpu_count()} {kind_of(plan.parts)}"
    return hashlib.sha256(said.encode()).hexdigest()[:16]


def _read() -> dict[str, Mapping[str, Any]]:
    try:
        found = json.loads(cache_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}
