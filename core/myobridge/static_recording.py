"""Recording of a path of equilibria: a row for every accepted point, the states at the reported scales."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge.fields import FieldSnapshot, snapshot
from myobridge.interfaces import Array, PathPoint
from myobridge.recording import Record
from myobridge.results import Checkpoint
from myobridge.statics import Statics

__all__ = ["STATIC_QUANTITIES", "PathRecorder", "check_static_record"]

STATIC_QUANTITIES = ("stretch", "tension", "activation", "energy", "reactions", "displacement", "summary")
"""Quantities of `myobridge.recording.QUANTITIES` that exist without time."""


def check_static_record(record: Record, statics: Statics) -> None:
    """Whether what is asked for exists without time.

    Raises
    ------
    ParameterError
        With the key, what is wrong and what is allowed.
    """
    record.columns(statics.solid)
    for key, usual in (("every", 1), ("density_at", ()), ("fields_every", 0)):
        if getattr(record, key) != usual:
            raise ParameterError(
                key,
                "counts steps or time, and a scene with [continuation] has none: every point is a row, and states are "
                "kept at the scales of continuation.report",
            )
    for item in record.quantities or ():
        if item not in STATIC_QUANTITIES:
            raise ParameterError("quantities", f"has '{item}', which needs time. {nearest(item, STATIC_QUANTITIES)}")
    if record.fields:
        mesh = statics.solid.visible_mesh()
        if mesh is None:
            raise ParameterError("fields", f"are given, and {type(statics.solid).__name__} has no shape to see")
        start = PathPoint(statics.problem.start, 0.0, 0, 0)
        found = snapshot(statics.solid, mesh, statics.motion(start), 0.0, statics.fields(start))
        for index, name in enumerate(record.fields):
            if name not in found.names:
                raise ParameterError(
                    f"fields[{index}]", f"names '{name}', which this scene has not. {nearest(name, found.names)}"
                )


class PathRecorder:
    """Keeps rows and states of a path as a `Record` and the scene's ``continuation.report`` say.

    Series: ``scale``, ``level``, ``iterations``, ``negative_eigenvalues`` and ``kept`` (1 at a reported scale), each
    (n_points,), and what the record asks for.
    """

    def __init__(self, record: Record, statics: Statics) -> None:
        self.record = record
        self.statics = statics
        self.columns = record.columns(statics.solid)
        self.mesh = None if record.fields == () else statics.solid.visible_mesh()
        self.snapshots: list[FieldSnapshot] = []
        # Of the way here only the last two points are needed to go on.
        self.points: list[PathPoint] = []
        self._wanted = record.wanted(statics.solid)
        self._rows: dict[str, list[Any]] = {}

    @property
    def n_rows(self) -> int:
        """Points so far, those of an earlier run included."""
        return len(self._rows.get("scale", ()))

    def observe(self, point: PathPoint) -> None:
        """Keep the row of a point, and its fields where they are asked for."""
        self.points = [*self.points[-1:], point]
        for name, value in self._row(point).items():
            self._rows.setdefault(name, []).append(value)
        if point.level in self.statics.kept:
            self._keep_fields(point)

    def series(self) -> dict[str, Array]:
        """All rows so far by name, ``(n_rows,)`` or ``(n_rows, n_sites)``."""
        return {name: np.array(rows, dtype=float) for name, rows in self._rows.items()}

    def fields(self) -> tuple[FieldSnapshot, ...]:
        """Kept states of the body, and the last one."""
        kept = list(self.snapshots)
        if self.mesh is not None and self.points and (not kept or kept[-1].step != self.n_rows - 1):
            kept.append(self._snapshot(self.points[-1]))
        return tuple(kept)

    def checkpoint(self) -> Checkpoint:
        """The last two points, from which the path can be continued."""
        points = self.points[-2:]
        arrays = {
            "path/unknowns": np.array([point.unknowns for point in points]),
            "path/level": np.array([point.level for point in points]),
            "path/iterations": np.array([point.iterations for point in points]),
            "path/negative_eigenvalues": np.array([point.negative_eigenvalues for point in points]),
        }
        return Checkpoint({"points": self.n_rows}, arrays)

    def resume(self, series: Mapping[str, Array], fields: Sequence[FieldSnapshot], checkpoint: Checkpoint) -> None:
        """Take over the rows, states and last points of an earlier run.

        Raises
        ------
        ValueError, KeyError
            If they are those of another problem.
        """
        arrays = checkpoint.arrays
        unknowns = np.asarray(arrays["path/unknowns"], dtype=float)
        expected = self.statics.problem.start.size
        if unknowns.shape[1:] != (expected,):
            raise ValueError(f"the last points have {unknowns.shape[1:]} unknowns, expected {expected}")
        self.points = [
            PathPoint(np.array(row), float(level), int(iterations), int(negative))
            for row, level, iterations, negative in zip(
                unknowns,
                arrays["path/level"],
                arrays["path/iterations"],
                arrays["path/negative_eigenvalues"],
                strict=True,
            )
        ]
        self._rows = {name: list(rows) for name, rows in series.items()}
        # The state at which the path ended was kept for the picture only.
        self.snapshots = [state for state in fields if self._rows["kept"][state.step] == 1.0]

    def _row(self, point: PathPoint) -> dict[str, Any]:
        statics, wanted = self.statics, self._wanted
        stretch, tension = statics.stretch_and_tension(point)
        row: dict[str, Any] = {
            "scale": statics.scale(point.level),
            "level": point.level,
            "iterations": point.iterations,
            "negative_eigenvalues": point.negative_eigenvalues,
            "kept": point.level in statics.kept,
        }
        at_sites = {"stretch": stretch}
        if statics.tension is not None:
            at_sites |= {"tension": tension, "activation": statics.tension.activation}
        for name, values in at_sites.items():
            if name in wanted:
                row[name] = values[self.columns]
            if "summary" in wanted and values.size:
                volumes = statics.solid.site_volumes
                row[f"mean/{name}"] = np.dot(volumes, values) / volumes.sum()
                row[f"least/{name}"], row[f"largest/{name}"] = values.min(), values.max()
        if "energy" in wanted:
            row["energy/elastic"] = statics.solid.elastic_energy(statics.motion(point).displacement)
        if "reactions" in wanted:
            row |= {f"reaction/{name}": force for name, force in statics.reactions(point).items()}
        if "displacement" in wanted:
            row["displacement"] = statics.motion(point).displacement
        return row

    def _keep_fields(self, point: PathPoint) -> None:
        if self.mesh is not None:
            found = self._snapshot(point)
            self.snapshots.append(found.sharing(self.snapshots[-1]) if self.snapshots else found)

    def _snapshot(self, point: PathPoint) -> FieldSnapshot:
        assert self.mesh is not None
        statics = self.statics
        return snapshot(
            statics.solid,
            self.mesh,
            statics.motion(point),
            statics.scale(point.level),
            statics.fields(point),
            names=self.record.fields,
            step=self.n_rows - 1,
            label="scale",
        )
