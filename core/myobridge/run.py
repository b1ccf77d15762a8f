"""Run: a scene from start to end, with a file that is complete at every moment."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from myobridge.errors import SceneError
from myobridge.interfaces import StepReport
from myobridge.interrupts import postponed
from myobridge.kept_file import KeptFile
from myobridge.plan import Plan
from myobridge.recording import Record, Recorder
from myobridge.results import Checkpoint, Result
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.static_run import StaticRun

__all__ = ["Run", "resume", "run", "start"]

# Not what is recorded: the rows that exist could not be continued.
_RESUMABLE = ("scene.duration", "record.every", "record.density_at", "record.checkpoint_every")
# Without time the strategy may change, so that a path which failed is tried in another way; not what is raised.
_FIXED = ("of", "to")
_RESUMABLE_STATICS = ("continuation.plugin and its parameters", "continuation.report", "record.checkpoint_every")


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

    Raises
    ------
    MyobridgeError
        If the file cannot be written: now, not after hours of computing.
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
        self._file = KeptFile(output, scene, plugins, folder)
        self.recording_seconds = 0.0

    @property
    def output(self) -> Path | None:
        """File that is kept; None where the result lives in memory only."""
        return self._file.path

    def to(
        self,
        end: float,
        after_step: Callable[[Simulation, StepReport], Any] | None = None,
        *,
        until: float | None = None,
    ) -> Result:
        """Run to time `end` [s]; what interrupts it finds the result so far on disk.

        Parameters
        ----------
        end : float
            Where the last step ends.
        after_step : callable, optional
            Called with the simulation and the report of each accepted step.
        until : float, optional
            Stop after the first step that reaches this time; the steps are those of a run to `end`.

        Raises
        ------
        StepFailed
            When a step fails for good.
        KeyboardInterrupt
            On Ctrl-C and SIGTERM, after the step under way has been finished and the file written.
        """
        simulation, recorder = self.simulation, self.recorder
        recorder.observe(simulation)
        self._file.begin()
        stop = end if until is None else min(until, end)
        with postponed() as interrupts:
            while not simulation.finished(stop):
                try:
                    report = simulation.step(end)
                except Exception:  # StepFailed, or a plugin's own: the simulation stands after its last good step
                    self._keep()
                    raise
                started = time.perf_counter()
                recorder.observe(simulation, last=simulation.finished(stop))
                self._file.save_if_due(self.result, self.recorder.record.checkpoint_every)
                self.recording_seconds += time.perf_counter() - started
                try:
                    if after_step is not None:
                        after_step(simulation, report)
                    interrupts.check()
                except BaseException:
                    self._keep()
                    raise
            return self._keep()

    def result(self) -> Result:
        """Result so far."""
        return Result(
            self.recorder.series(),
            tuple(self.recorder.snapshots),
            self._file.scene,
            self._file.provenance,
            Checkpoint.take(self.simulation),
            self.recorder.columns,
            self.recorder.body.mesh,
            tuple(self.recorder.body.snapshots),
        )

    def _keep(self) -> Result:
        self.recorder.observe(self.simulation, last=True)
        return self._file.save(self.result())


def run(
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Result:
    """Run a scene, or the scene in a file, to its end; one without time is followed to its last scale.

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
    under_way = start(Plan.of(scene), output)
    return under_way.trace() if isinstance(under_way, StaticRun) else under_way.to(scene.duration)


def start(plan: Plan, output: str | os.PathLike[str] | None = None, *, begin: bool = True) -> Run | StaticRun:
    """Run of a plan, not yet stepped; see `Plan.composed` for `begin`."""
    scene, composed = plan.scene, plan.composed(begin=begin)
    said: dict[str, Any] = {"scene": scene.to_toml(), "plugins": plan.names, "folder": scene.folder, "output": output}
    if isinstance(composed, Simulation):
        return Run(composed, scene.record, **said)
    return StaticRun(composed, scene.record, **said)


def resume(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> tuple[Run | StaticRun, Scene]:
    """Run that continues a result file, bit by bit as if it had never stopped.

    A path of equilibria goes on from its last point, with the strategy at its first step.

    Parameters
    ----------
    settings : mapping, optional
        Only the duration, and when something is kept, may change; without time the continuation strategy. Anything else
        would be another simulation.

    Raises
    ------
    SceneError
        If a setting would change the simulation, or the file's scene cannot be built any more.
    """
    earlier = Result.load(path)
    if not earlier.scene:
        raise SceneError(f"{path}: holds no scene (it was composed in Python), so it cannot be resumed from the file")
    folder = Path(earlier.provenance.get("folder", "."))
    source = f"{path} (scene)"
    if settings:
        _check_settings(settings, Scene.from_toml(earlier.scene, folder=folder, source=source).static)
    scene = Scene.from_toml(earlier.scene, folder=folder, source=source, settings=settings)
    continued = start(Plan.of(scene), path if output is None else output, begin=False)
    if isinstance(continued, StaticRun):
        continued.resume(earlier)
        return continued, scene
    earlier.checkpoint.restore(continued.simulation)
    continued.recorder.resume(earlier.series, earlier.densities, earlier.fields, continued.simulation)
    return continued, scene


def _check_settings(settings: Mapping[str, Any], static: bool) -> None:
    for key in settings:
        section, _, name = key.partition(".")
        free = (section == "continuation" and name not in _FIXED) or key == "record.checkpoint_every"
        if not (free if static else key in _RESUMABLE):
            allowed = _RESUMABLE_STATICS if static else _RESUMABLE
            raise SceneError(
                f"--set {key}: cannot change when a run is resumed; allowed: {', '.join(allowed)}. "
                "For another simulation, start a new run"
            )
