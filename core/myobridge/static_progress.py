"""Progress of a path of equilibria: settings before, a line for each accepted point, iterations and stability after."""

from __future__ import annotations

import sys
import warnings
from time import perf_counter

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from myobridge.interfaces import PathPoint
from myobridge.plan import Plan
from myobridge.results import Result
from myobridge.static_run import StaticRun, UnstableEquilibrium
from myobridge.statics import Statics
from myobridge.study.prediction import predicted
from myobridge.tables import effects_table, newton_choice, settings_table, solver_choice, written

__all__ = ["follow_path", "path_table"]


def follow_path(run: StaticRun, plan: Plan, *, quiet: bool = False) -> Result:
    """Follow a path to its end, showing how it goes; on Ctrl-C and failure the table is there all the same."""
    console = Console(quiet=quiet)
    console.print(settings_table(plan))
    console.print(effects_table(plan))
    if chosen := solver_choice(plan):
        console.print(f"linear solver: {chosen}", markup=False, highlight=False)
    if chosen := newton_choice(plan):
        console.print(f"Newton's method: {chosen}", markup=False, highlight=False)
    if run.finished:
        console.print("the path is complete already", markup=False)
    expected = predicted(plan, measure=False)
    started = perf_counter()

    def after_point(statics: Statics, point: PathPoint) -> None:
        scale, kept = statics.scale(point.level), ", kept" if point.level in statics.kept else ""
        console.print(
            f"scale {scale:.6g} of {statics.scaling.to:g}: {point.iterations} iterations, {_verdict(point)}{kept}",
            highlight=False,
        )

    try:
        with warnings.catch_warnings():  # said below, where it is seen
            warnings.simplefilter("ignore", UnstableEquilibrium)
            result = run.trace(after_point)
    finally:
        if run.recorder.n_rows:
            console.print(path_table(run))
        beforehand = f" (expected: {expected.seconds:.2g} s)" if expected is not None else ""
        took = perf_counter() - started
        console.print(f"{run.recorder.n_rows} points in {took:.2f} s{beforehand}", highlight=False)
        said = run.unstable()
        if said:  # also when nothing else is printed
            print(f"myobridge: WARNING: {said}", file=sys.stderr)
    if run.output is not None:
        console.print(written(run.output, result), markup=False, highlight=False, soft_wrap=True)
    return result


def _verdict(point: PathPoint) -> str:
    return _said(point.negative_eigenvalues)


def _said(negative: int) -> str:
    if negative < 0:
        return "[bold yellow]stability NOT KNOWN[/]"
    return f"[bold red]UNSTABLE: {negative} negative eigenvalues[/]" if negative else "stable"


def path_table(run: StaticRun) -> Table:
    """Kept states of a path and its last point: what was spent to get there, and whether they are stable."""
    series, statics = run.recorder.series(), run.statics
    table = Table(title=escape(f"path: {statics.of.replace('_', ' ')} from 0 to {statics.scaling.to:g}"))
    table.title_justify = "left"
    for column in ("scale", "points", "iterations", "stability"):
        table.add_column(column, justify="left" if column == "stability" else "right")
    last = run.recorder.n_rows - 1
    before = 0
    for row in range(last + 1):
        if series["kept"][row] or row == last:
            part = slice(before, row + 1)
            before = row + 1
            bad = int((series["negative_eigenvalues"][part] > 0).sum())
            here = int(series["negative_eigenvalues"][row])
            verdict = _said(here)
            if bad > (here > 0):
                verdict += f", [bold red]{bad - (here > 0)} unstable on the way[/]"
            spent = int(series["iterations"][part].sum())
            table.add_row(f"{series['scale'][row]:.6g}", f"{part.stop - part.start}", f"{spent}", verdict)
    table.add_row("in all", f"{last + 1}", f"{int(series['iterations'].sum())}", "")
    return table
