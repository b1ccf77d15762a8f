"""Following a study on a console: one line while it runs, with the time that remains."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Protocol, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from myobridge.study.progress import Progress as Step
from myobridge.study.progress import Watch

__all__ = ["followed"]


class Counted(Protocol):
    """What is followed: how many runs were computed, and how many were kept from before."""

    @property
    def computed(self) -> int: ...

    @property
    def kept(self) -> int: ...


Found = TypeVar("Found", bound=Counted)


def followed(title: str, run: Callable[[Watch | None], Found], console: Console | None = None) -> Found:
    """Run what tells its progress to a function, showing that on a `console`; without one nothing is shown."""
    if console is None:
        return run(None)
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[state]}", markup=False),
        TimeElapsedColumn(),
    )
    started = perf_counter()
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(title, total=1.0, state="starting")

        def watch(step: Step) -> None:
            left = remaining(step, perf_counter() - started)
            state = f"{step.runs} of {step.planned} runs, about {left:.0f} s left; last: {step.label}"
            progress.update(task, completed=step.done, total=step.total, state=state)

        result = run(watch)
    spent = perf_counter() - started
    console.print(
        f"{result.computed} runs in {spent:.1f} s, {result.kept} kept from before", markup=False, highlight=False
    )
    return result


def remaining(step: Step, elapsed: float) -> float:
    """Seconds that are left if the rest goes on as what is done, by its expected cost."""
    return elapsed * (step.total - step.done) / step.done if step.done else float("inf")
