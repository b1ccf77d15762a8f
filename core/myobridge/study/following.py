"""Following a study on a console: one line while it runs, with the time that remains."""

from __future__ import annotations

import os
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from myobridge.study.progress import Progress as Step
from myobridge.study.result import StudyResult
from myobridge.study.study import Study

__all__ = ["followed"]


def followed(
    study: Study, folder: str | os.PathLike[str], *, console: Console | None = None, **how: Any
) -> StudyResult:
    """Run a study, showing how it goes on a `console`; without one nothing is shown."""
    if console is None:
        return study.run(folder, **how)
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[state]}", markup=False),
        TimeElapsedColumn(),
    )
    started = perf_counter()
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(study.title, total=1.0, state="starting")

        def watch(step: Step) -> None:
            left = remaining(step, perf_counter() - started)
            state = f"{step.runs} of {step.planned} runs, about {left:.0f} s left; last: {step.label}"
            progress.update(task, completed=step.done, total=step.total, state=state)

        result = study.run(folder, watch=watch, **how)
    spent = perf_counter() - started
    console.print(
        f"{result.computed} runs in {spent:.1f} s, {result.kept} kept from before", markup=False, highlight=False
    )
    return result


def remaining(step: Step, elapsed: float) -> float:
    """Seconds that are left if the rest goes on as what is done, by its expected cost."""
    return elapsed * (step.total - step.done) / step.done if step.done else float("inf")
