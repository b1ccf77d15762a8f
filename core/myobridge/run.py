"""Run: a scene from start to end, with a file that is complete at every moment."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from myobridge.errors import SceneError, StepFailed
from myobridge.interfaces import StepReport
from myobridge.plan import Plan
from myobridge.recording import Record, Recorder
from myobridge.results import Checkpoint, Result, provenance
from myobridge.scene import Scene
from myobridge.simulation import Simulation

__all__ = ["Run", "resume", "run", "start"]


class Run:
    """A simulation under way, its recorder and its file.

    Parameters
    ----------
    simulation : Simulation
    record : Record, optional
        What to keep.
    scene : str
        TOML of the scene, kept in the file.
    plugins : mapping, optional
        Names of the plugins, for the provenance.
    folder : Path, optional
        Folder of the scene's files, for a later resume.
    output : path, optional
        File to keep; without, the result lives in memory only.
    """

    def __init__(
        self,
        simulation: Simulation,
        record: Record | None = None,
        *,
        scene: str = "",
        plugins: Mapping[str, str] | None = None,
        folder: Path | None = None,
        output: str | os.PathLike[str] | None = None,
    ) -> None:
        self.simulation = simulation
        self.recorder = Recorder(record or Record(), simulation)
        self.output = None if output is None else Path(output)
        self.recording_seconds = 0.0
        self._scene = scene
        self._provenance = provenance(plugins or {}) | {"folder": str((folder or Path()).resolve())}

    def to(self, end: float, after_step: Callable[[Simulation, StepReport], Any] | None = None) -> Result:
        """Run to time `end` [s]; what interrupts it finds the result so far on disk.

        Raises
        ------
        StepFailed
            When a step fails for good.
        KeyboardInterrupt
            On Ctrl-C, after the file has been written.
        """
        record = self.recorder.record
        simulation, recorder = self.simulation, self.recorder
        recorder.observe(simulation)
        written = time.perf_counter()
        cost = 0.0
        try:
            while not simulation.finished(end):
                report = simulation.step(end)
                started = time.perf_counter()
                recorder.observe(simulation, last=simulation.finished(end))
                now = time.perf_counter()
                # A file costs at most a twentieth of the run, however large it has grown.
                if self.output is not None and now - written > max(record.checkpoint_every, 20.0 * cost):
                    self.result().save(self.output)
                    written = time.perf_counter()
                    cost = written - now
                self.recording_seconds += time.perf_counter() - started
                if after_step is not None:
                    after_step(simulation, report)
        except (StepFailed, KeyboardInterrupt):
            self._keep()
            raise
        return self._keep()

    def result(self) -> Result:
        """Result so far."""
        return Result(
            self.recorder.series(),
            tuple(self.recorder.snapshots),
            self._scene,
            self._provenance,
            Checkpoint.take(self.simulation),
            self.recorder.columns,
        )

    def _keep(self) -> Result:
        self.recorder.observe(self.simulation, last=True)
        result = self.result()
        if self.output is not None:
            result.save(self.output)
        return result


def run(
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Result:
    """Run a scene, or the scene in a file, to its end.

    Parameters
    ----------
    scene : Scene or path
    output : path, optional
        Result file.
    settings : mapping, optional
        Keys to override, dotted (``{"solid.stiffness": 100.0}``).

    Examples
    --------
    >>> import myobridge as mb
    >>> result = mb.run("examples/quick_release.toml")  # doctest: +SKIP
    >>> result["tension"][-1]  # doctest: +SKIP
    """
    if not isinstance(scene, Scene):
        scene = Scene.load(scene, settings)
    elif settings:
        scene = scene.with_settings(settings)
    plan = Plan.of(scene)
    return start(plan, output).to(scene.duration)


def start(plan: Plan, output: str | os.PathLike[str] | None = None) -> Run:
    """Run of a plan, not yet stepped."""
    scene = plan.scene
    return Run(
        plan.simulation(),
        scene.record,
        scene=scene.to_toml(),
        plugins=plan.names,
        folder=scene.folder,
        output=output,
    )


def resume(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> tuple[Run, Scene]:
    """Run that continues a result file, bit by bit as if it had never stopped.

    Parameters
    ----------
    settings : mapping, optional
        Only ``scene.duration`` and ``record.*`` may change; anything else would be another simulation.

    Raises
    ------
    SceneError
        If a setting would change the simulation, or the file's scene cannot be built any more.
    """
    earlier = Result.load(path)
    for key in settings or {}:
        if key != "scene.duration" and not key.startswith("record."):
            raise SceneError(
                f"{key}: cannot change when a run is resumed; allowed: scene.duration, record.*. "
                "For another simulation, start a new run"
            )
    if not earlier.scene:
        raise SceneError(f"{path}: holds no scene (it was composed in Python), so it cannot be resumed from the file")
    folder = Path(earlier.provenance.get("folder", "."))
    scene = Scene.from_toml(earlier.scene, folder=folder, settings=settings)
    continued = start(Plan.of(scene), path if output is None else output)
    simulation = continued.simulation
    earlier.checkpoint.restore(simulation)
    # The last row of an interrupted run may lie between two regular ones; a run that never stopped has no such row.
    rows = slice(None) if simulation.steps % scene.record.every == 0 else slice(None, -1)
    continued.recorder.resume({name: data[rows] for name, data in earlier.series.items()}, list(earlier.densities))
    return continued, scene
