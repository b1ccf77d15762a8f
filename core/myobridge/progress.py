"""Progress: what a person sees of a run; settings before, one line during, ledger and times after."""

from __future__ import annotations

from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from myobridge.interfaces import StepReport
from myobridge.plan import Plan
from myobridge.results import Result
from myobridge.run import Run
from myobridge.simulation import Simulation
from myobridge.study.prediction import learn, predicted
from myobridge.study.stopwatch import Stopwatch
from myobridge.tables import (
    effects_table,
    ledger_table,
    newton_choice,
    settings_table,
    shares_table,
    solver_choice,
    written,
)

__all__ = ["follow"]

# A line more often than ten times a second shows nothing more and costs time.
_INTERVAL = 0.1


def follow(run: Run, plan: Plan, *, until: float | None = None, quiet: bool = False) -> Result:
    """Run a plan to its end, showing how it goes; on Ctrl-C and failure the tables are there all the same."""
    end = plan.scene.duration
    if quiet:
        return run.to(end, until=until)
    console = Console()
    console.print(settings_table(plan))
    console.print(effects_table(plan))
    if chosen := solver_choice(plan):
        console.print(f"linear solver: {chosen}", markup=False, highlight=False)
    if chosen := newton_choice(plan):
        console.print(f"Newton's method: {chosen}", markup=False, highlight=False)
    if said := run.simulation.begun.said:
        console.print(f"start: {said}", markup=False, highlight=False)
    if run.simulation.finished(end):
        console.print(f"t = {run.simulation.time:.6g} s is the end already; --set scene.duration=... goes on")
    expected = predicted(plan, measure=False)
    begun, watch = run.simulation.steps, Stopwatch()
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[state]}", markup=False),
        TimeRemainingColumn(),
    )
    try:
        with Progress(*columns, console=console, transient=False) as progress:
            task = progress.add_task(plan.scene.name, total=end, state="")
            shown = 0.0

            def after_step(simulation: Simulation, report: StepReport) -> None:
                nonlocal shown
                watch.stepped(simulation)
                now = perf_counter()
                if now - shown > _INTERVAL or simulation.finished(end):
                    shown = now
                    progress.update(task, completed=min(simulation.time, end), state=_state(simulation, report))

            result = run.to(end, after_step, until=until)
    finally:
        watch.stop(run.simulation)
        simulation = run.simulation
        console.print(ledger_table(run))
        console.print(shares_table(run, watch, expected))
        if not begun:
            learn(plan, watch)
        console.print(f"{simulation.steps} steps to t = {simulation.time:.6g} s in {watch.wall:.2f} s")
    if run.output is not None:
        console.print(written(run.output, result), markup=False, highlight=False, soft_wrap=True)
    return result


def _state(simulation: Simulation, report: StepReport) -> str:
    dt = simulation.control.dt / 2**simulation.control.halvings
    return (
        f"t = {1e3 * simulation.time:.2f} ms, dt = {1e3 * dt:.3g} ms, {report.iterations} iterations, "
        f"energy drift {simulation.ledger.drift:+.1e}"
    )
