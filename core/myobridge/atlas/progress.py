"""Progress of an atlas: one line while it runs."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from myobridge.atlas.atlas import Atlas
from myobridge.atlas.cell import Finding
from myobridge.atlas.chart import Chart

__all__ = ["followed"]


def followed(atlas: Atlas, folder: Path, *, resume: bool, workers: int | None, console: Console | None = None) -> Chart:
    """Run an atlas, showing how it goes on a `console`; without one nothing is shown."""
    if console is None:
        return atlas.run(folder, resume=resume, workers=workers)
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[state]}", markup=False),
    )
    total, surprises = len(atlas.cells), 0
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("atlas", total=total, state="")

        def watch(finding: Finding, left: int) -> None:
            nonlocal surprises
            surprises += bool(finding.surprise)
            if finding.surprise:
                said = f"{finding.row}, {finding.method}: {finding.surprise}. {finding.why}"
                progress.console.print(said, style="red", markup=False, highlight=False)
            state = f"{surprises} surprises; last {finding.row}, {finding.method}: {finding.outcome}"
            progress.update(task, completed=total - left, state=state)

        chart = atlas.run(folder, resume=resume, workers=workers, watch=watch)
        progress.update(task, completed=total, state=f"{surprises} surprises")
    return chart
