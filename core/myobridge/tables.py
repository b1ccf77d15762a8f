"""Tables that the command line prints: plan, effective settings, plugins, the end of a run."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Group
from rich.markup import escape
from rich.table import Table

from myobridge.field_recording import stride
from myobridge.ledger import FLOWS, STORED
from myobridge.parameters import declared
from myobridge.plan import Plan
from myobridge.registry import Registry
from myobridge.results import Result
from myobridge.run import Run
from myobridge.scaling import Scaling
from myobridge.static_recording import STATIC_QUANTITIES
from myobridge.study.prediction import Prediction
from myobridge.study.stopwatch import Stopwatch

__all__ = [
    "effects_table",
    "ledger_table",
    "newton_choice",
    "plugins_json",
    "plugins_table",
    "settings_table",
    "shares_table",
    "sizes_table",
    "solver_choice",
    "written",
]


def settings_table(plan: Plan) -> Table:
    """Effective settings: every parameter of every chosen plugin, given or not."""
    table = Table(title=escape(f"settings of '{plan.scene.name}'"), title_justify="left")
    for column in ("section", "parameter", "value", "unit"):
        table.add_column(column)
    if plan.scaling is None:
        table.add_row("scene", "duration", f"{plan.scene.duration:g}", "s")
        table.add_row("", "step", f"{plan.scene.step:g}", "s")
        table.add_row("", "start", plan.scene.start or "as_given", "-")
    for section, part in plan.parts.items():
        table.add_row(section, "plugin", plan.names[section], "-", end_section=not declared(type(part)))
        for name, item in declared(type(part)).items():
            value = getattr(part, name)
            if item.effect and item.effect not in plan.scene.effects:
                continue
            table.add_row("", name, escape(_short(value)), item.unit)
        if section == "continuation" and plan.scaling is not None:
            for name, item in declared(type(plan.scaling)).items():
                table.add_row("", name, escape(_short(getattr(plan.scaling, name))), item.unit)
    return table


def _short(value: Any) -> str:
    if value is None:
        return "not given"
    if isinstance(value, tuple) and len(value) > 4:
        if not all(isinstance(item, int | float) for item in value):
            return f"{len(value)} entries"
        return f"{len(value)} values, {min(value):g} to {max(value):g}"
    if isinstance(value, tuple):
        return "(" + ", ".join(_short(item) for item in value) + ")"
    said = declared(type(value))
    if said:
        inner = ", ".join(f"{name}={_short(getattr(value, name))}" for name in said)
        return f"{type(value).__name__}({inner})"
    return f"{value:g}" if isinstance(value, float) else str(value)


def effects_table(plan: Plan) -> Table:
    """Effects on, inherent and off."""
    table = Table(title="effects", title_justify="left")
    for column in ("effect", "state", "by / why not"):
        table.add_column(column)
    colours = {"on": "green", "inherent": "cyan", "off": "dim"}
    for effect, state, reason in plan.effects():
        table.add_row(
            effect, f"[{colours[state]}]{state}[/]", f"[dim]{escape(reason)}[/]" if state == "off" else escape(reason)
        )
    return table


def solver_choice(plan: Plan) -> str:
    """The linear solver of a plan and the reason for it; empty where nothing is solved."""
    from myobridge.solvers import choice_of

    solid = plan.parts["solid"]
    method = plan.parts.get("continuation") or plan.parts.get("integrator")
    if solid.n_unknowns == 0 or getattr(method, "explicit", False):
        return ""
    given = getattr(getattr(method, "newton", None), "linear", None)
    if given is not None:
        return f"{type(given).__name__}, as the scene says"
    chosen = choice_of(solid)
    return f"{chosen.name} ({chosen.reason})"


def newton_choice(plan: Plan) -> str:
    """Newton's method of a plan and the reason for it; empty where nothing is solved."""
    from myobridge.solvers import method_for

    solid, path = plan.parts["solid"], plan.parts.get("continuation")
    method = path or plan.parts.get("integrator")
    if solid.n_unknowns == 0 or getattr(method, "explicit", False) or not hasattr(method, "newton"):
        return ""
    given = getattr(method, "newton", None)
    if given is not None:
        return f"{type(given).__name__}, as the scene says"
    chosen = method_for(solid, path=path is not None)
    return f"{chosen.name} ({chosen.reason})"


def sizes_table(plan: Plan, prediction: Prediction | None = None) -> Table:
    """How large a simulation is: unknowns, sites, memory, steps; and what it is expected to take."""
    table = Table(title="sizes", title_justify="left")
    for column in ("what", "how much"):
        table.add_column(column)
    solid, model = plan.parts["solid"], plan.parts.get("cross_bridges")
    table.add_row("solid", f"{solid.n_unknowns:,} unknowns, {solid.n_sites:,} sites")
    if solid.memory():
        table.add_row("tables of the solid", f"{_bytes(solid.memory())}, the data of its tangent included")
    table.add_row("linear solver", solver_choice(plan) or "none: nothing to solve")
    if prediction is not None:
        table.add_row("expected", prediction.words())
    table.add_row("Newton's method", newton_choice(plan) or "none: nothing to solve")
    if model is None:
        table.add_row("population", "none: no cross-bridges called for")
    elif plan.scaling is not None:
        table.add_row("population", "none: without time its isometric steady tension acts")
    else:
        sizes = plan.sizes()
        values, size = sizes["values a site"], sizes["population bytes"]
        table.add_row("population", f"{values:,} values a site, {_bytes(size)} (state and trial)")
    if plan.scaling is not None:
        _add_path(table, plan, plan.scaling)
        return table
    steps = round(plan.scene.duration / plan.scene.step)
    table.add_row("time", f"{steps:,} steps of {plan.scene.step:g} s")
    record = plan.scene.record
    quantities = record.wanted(solid)
    table.add_row("record", f"every {record.every:,} steps: {', '.join(quantities) or 'time only'}")
    mesh = solid.visible_mesh()
    if mesh is not None and record.fields != ():
        times = [f"at {', '.join(f'{time:g}' for time in record.field_times())} s"] if record.field_times() else []
        if record.fields_every > 0 or not times:
            times.append(f"every {stride(steps, record.fields_every):,} steps")
        names = "all that exist" if record.fields is None else ", ".join(record.fields)
        table.add_row("fields", f"{' and '.join(times)}, on {len(mesh.cells):,} cells: {names}")
    return table


def _add_path(table: Table, plan: Plan, scaling: Scaling) -> None:
    """Rows of a scene without time: what is raised how far, and what is kept where."""
    raised = (scaling.of or ("tension" if "cross_bridges" in plan.parts else "load")).replace("_", " ")
    table.add_row("time", "none: a path of equilibria")
    table.add_row("scale", f"{raised}, from 0 to {scaling.to:g}, by the strategy '{plan.names['continuation']}'")
    quantities = [name for name in plan.scene.record.wanted(plan.parts["solid"]) if name in STATIC_QUANTITIES]
    table.add_row("record", f"every accepted point: {', '.join(quantities) or 'scale only'}")
    table.add_row("states", f"kept at the scales {', '.join(f'{scale:g}' for scale in scaling.kept().values())}")


def _bytes(size: float) -> str:
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size = size / 1000
    return f"{size:.3g} GB"


def ledger_table(run: Run) -> Table:
    """Energies stored and flowed, and what does not add up."""
    entries = run.simulation.ledger.entries()
    table = Table(title="ledger", title_justify="left")
    table.add_column("entry")
    table.add_column("value", justify="right")
    table.add_column("")
    for name in STORED:
        table.add_row(name.replace("_", " "), f"{entries[name]: .6e} J", "stored now")
    for name in FLOWS:
        table.add_row(name.replace("_", " "), f"{entries[name]: .6e} J", "since the start")
    table.add_row("residual", f"{entries['residual']: .2e}", "last step, relative to the largest energy")
    table.add_row("drift", f"{entries['drift']: .2e}", "since the start, same measure")
    return table


def shares_table(run: Run, watch: Stopwatch, prediction: Prediction | None = None) -> Table:
    """Share of each phase in the computing time, and of a step what it took and what was expected beforehand."""
    simulation, wall = run.simulation, watch.wall
    seconds: dict[str, float] = dict(simulation.seconds) | {"recording": run.recording_seconds}
    rest = max(wall - sum(seconds.values()), 0.0)
    table = Table(title="time", title_justify="left")
    table.add_column("phase")
    table.add_column("seconds", justify="right")
    table.add_column("share", justify="right")
    for name, value in {**seconds, "rest": rest}.items():
        share = value / wall if wall > 0.0 else 0.0
        table.add_row(name.replace("_", " "), f"{value:.3f}", f"{100.0 * share:.1f} %")
    iterations = simulation.iterations / max(simulation.steps, 1)
    if watch.steps:
        table.add_row("first step", f"{watch.first:.2e}", "loads the kernels")
    table.add_row("a step", f"{watch.a_step:.2e}", f"{iterations:.2f} iterations")
    if prediction is not None:
        table.add_row("expected a step", f"{prediction.a_step:.2e}", f"{prediction.seconds:.2g} s in all")
    return table


def written(path: Path, result: Result) -> str:
    """Which file was written, and of a body what to do with it."""
    if result.mesh is None:
        return f"wrote {path}"
    size = _bytes(path.stat().st_size)
    return (
        f"wrote {path} ({len(result.fields)} states of {len(result.mesh.cells):,} cells, {size}); "
        f"myobridge show {path} draws it, ParaView's VTKHDF reader opens it"
    )


def plugins_table(registry: Registry) -> Group:
    """What is installed, one table a family; names and versions are for copying, so they are never cut."""
    tables: list[Table] = []
    for family, rows in itertools.groupby(registry, key=lambda item: item.family):
        table = Table(title=family, title_justify="left", box=None, show_header=not tables, padding=(0, 1))
        table.add_column("name", no_wrap=True, min_width=22, style="bold")
        table.add_column("package", no_wrap=True, min_width=16)
        table.add_column("description, effects")
        for item in rows:
            effects = ", ".join(sorted(item.inherent_effects | item.optional_effects))
            said = escape(item.summary) + (f"\n[dim]effects: {effects}[/]" if effects else "")
            table.add_row(item.name, f"{item.package} {item.version}", said)
        tables.append(table)
    return Group(*tables)


def plugins_json(registry: Registry) -> str:
    """What is installed, for programs."""
    rows: list[Mapping[str, Any]] = [
        {
            "name": item.name,
            "family": item.family,
            "package": item.package,
            "version": item.version,
            "effects": sorted(item.inherent_effects | item.optional_effects),
            "description": item.summary,
        }
        for item in registry
    ]
    return json.dumps(rows, indent=2)
