"""Run without time: a path of equilibria from start to end, with a file that is complete at every moment."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from myobridge.errors import ContinuationFailed, MyobridgeError
from myobridge.interfaces import ContinuationPath, PathPoint
from myobridge.interrupts import postponed
from myobridge.kept_file import KeptFile
from myobridge.recording import Record
from myobridge.results import Result
from myobridge.static_recording import PathRecorder
from myobridge.statics import Statics

__all__ = ["StaticRun", "UnstableEquilibrium"]


class UnstableEquilibrium(UserWarning):
    """A path holds states that would not stay: their tangent has negative eigenvalues."""


class StaticRun:
    """A path of equilibria under way, its recorder and its file.

    Parameters
    ----------
    statics : Statics
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
        statics: Statics,
        record: Record | None = None,
        *,
        scene: str = "",
        plugins: Mapping[str, str] | None = None,
        folder: Path | None = None,
        output: str | os.PathLike[str] | None = None,
    ) -> None:
        self.statics = statics
        self.recorder = PathRecorder(record or Record(), statics)
        self._file = KeptFile(output, scene, plugins, folder)

    @property
    def output(self) -> Path | None:
        """File that is kept; None where the result lives in memory only."""
        return self._file.path

    @property
    def finished(self) -> bool:
        """Whether the path has reached its end."""
        return bool(self.recorder.points) and self.recorder.points[-1].level == 1.0

    def trace(self, after_point: Callable[[Statics, PathPoint], Any] | None = None) -> Result:
        """Follow the path to its end; what interrupts it finds the path so far on disk.

        Parameters
        ----------
        after_point : callable, optional
            Called with the statics and each accepted point.

        Raises
        ------
        ContinuationFailed
            When the path ends early; its `result` holds the path so far.
        KeyboardInterrupt
            On Ctrl-C and SIGTERM, after the point under way has been found and the file written.

        Warns
        -----
        UnstableEquilibrium
            If accepted states have negative eigenvalues.
        """
        if self.finished:
            return self._keep()
        self._file.begin()
        with postponed() as interrupts:

            def watch(point: PathPoint) -> None:
                self.recorder.observe(point)
                self._file.save_if_due(self.result, self.recorder.record.checkpoint_every)
                if after_point is not None:
                    after_point(self.statics, point)
                interrupts.check()

            try:
                path = self.statics.trace(watch, tuple(self.recorder.points[-2:]))
            except ArithmeticError as error:  # a matrix that is singular where nobody expected it
                path = ContinuationPath((), False, f"the continuation stopped ({type(error).__name__}: {error}).")
            except BaseException:
                if self.recorder.points:
                    self._keep()
                raise
        if not path.completed:
            raise self._failure(path.reason)
        result = self._keep()
        said = self.unstable()
        if said:
            warnings.warn(said, UnstableEquilibrium, stacklevel=2)
        return result

    def unstable(self) -> str:
        """Which accepted states are unstable, or may be, in a sentence; empty where all are stable."""
        series = self.recorder.series()
        if not series:
            return ""
        negative, said = series["negative_eigenvalues"], []
        if np.any(negative > 0):
            scales = series["scale"][negative > 0]
            said.append(
                f"{scales.size} of {negative.size} states are unstable, at scales from {scales.min():.6g} to "
                f"{scales.max():.6g}, with up to {int(negative.max())} negative eigenvalues: they are equilibria, but "
                "the body would not stay in them"
            )
        if np.any(negative < 0):
            said.append(
                f"whether {int(np.sum(negative < 0))} of {negative.size} states are stable is not known: the body is "
                "too large for the proof; a direct solver that tells the inertia would tell (myobridge plugins)"
            )
        return "; ".join(said)

    def result(self) -> Result:
        """Result so far."""
        recorder = self.recorder
        return Result(
            recorder.series(),
            (),
            self._file.scene,
            self._file.provenance,
            recorder.checkpoint(),
            recorder.columns,
            recorder.mesh,
            recorder.fields(),
        )

    def resume(self, earlier: Result) -> None:
        """Continue the path of an earlier result.

        Raises
        ------
        MyobridgeError
            If it is the path of another problem.
        """
        try:
            self.recorder.resume(earlier.series, earlier.fields, earlier.checkpoint)
        except (KeyError, IndexError, ValueError) as error:
            raise MyobridgeError(
                f"the path does not fit the scene ({error}); was it written by another version?"
            ) from None

    def _failure(self, reason: str) -> ContinuationFailed:
        points = self.recorder.points
        if not points:
            hint = ""
            if self.statics.of == "tension":
                hint = " All loads act in full from the start; of = 'tension_and_load' raises them with the tension."
            if self.statics.of == "load" and self.statics.tension is not None:
                hint = " The tension acts in full from the start; of = 'tension_and_load' raises it with the load."
            return ContinuationFailed(f"{reason}{hint} Nothing was found, so no file was written")
        scale, level = self.statics.scale(points[-1].level), points[-1].level
        said = f"{reason} Level {level:.6g} is the scale {scale:.6g}"
        result = self._keep()
        if self.output is not None:
            said += (
                f"; the path so far, {self.recorder.n_rows} points, is in {self.output}: --resume {self.output} with "
                "--set continuation.KEY=VALUE goes on from there"
            )
        failure = ContinuationFailed(said)
        failure.result = result
        return failure

    def _keep(self) -> Result:
        return self._file.save(self.result())
