"""Recording: which quantities of a running simulation are kept, how often, at which sites."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge.field_recording import FieldRecorder, check_fields
from myobridge.fields import FieldSnapshot
from myobridge.interfaces import Array, MacroSolid
from myobridge.parameters import integer, number, numbers
from myobridge.quantities import QUANTITIES, sources
from myobridge.simulation import Simulation

__all__ = ["QUANTITIES", "DensitySnapshot", "Record", "Recorder"]

_AT_SITES = ("stretch", "stretch_rate", "tension", "activation", "moments")
# A row for each site is for springs and small bodies; of a large one it would fill the memory.
_MANY_SITES = 1000


def _quantities(value: Any) -> tuple[str, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list | tuple) or not all(isinstance(item, str) for item in value):
        raise ParameterError("quantities", f"is {value!r}; expected a list of names. {nearest('', QUANTITIES)}")
    for item in value:
        if item not in QUANTITIES:
            raise ParameterError("quantities", f"has no '{item}'. {nearest(item, QUANTITIES)}")
    return tuple(value)


def _fields(value: Any) -> tuple[str, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list | tuple) or not all(isinstance(item, str) for item in value):
        raise ParameterError("fields", f"is {value!r}; expected a list of names, such as ['tension', 'stretch']")
    return tuple(value)


def _indices(value: Any) -> tuple[int, ...] | None:
    if value is None:
        return None
    if isinstance(value, np.ndarray):
        value = value.tolist()
    whole = isinstance(value, list | tuple) and all(type(item) is int and item >= 0 for item in value)
    if not whole or not value:
        raise ParameterError("sites", f"is {value!r}; expected a list of site numbers, counted from 0")
    return tuple(value)


@attrs.frozen(kw_only=True)
class Record:
    """What to keep of a run.

    Parameters
    ----------
    every : int
        Steps from one row to the next; the first and the last state are always rows.
    quantities : sequence of str, optional
        Out of `QUANTITIES`. Without: energy and reactions, and stretch, its rate, tension, activation and moments of
        the kept sites where they are at most 1000; of a solid with more sites, the `summary` too.
    sites : sequence of int, optional
        Sites to keep; all without.
    points : sequence of float, optional
        Keep the sites nearest to these reference positions along the first axis [m] instead.
    density_at : sequence of float
        Times at which the attached fraction over displacement is kept; steps end there.
    fields : sequence of str, optional
        Fields that are kept of a solid with a shape, out of `myobridge.fields.FIELDS` and what the solid adds; all that
        exist without, none when empty. Displacement always is with them.
    fields_every : int
        Steps between two states whose fields are kept; the first and the last always are. 0: evenly spread, 40 states
        and the last at most, however long the run.
    fields_at : sequence of float
        Times at which fields are kept; steps end there. No others are then, but for the first, the last, and those of
        `fields_every` where that is given.
    checkpoint_every : float
        Seconds of computing from one complete file on disk to the next.
    """

    every: int = integer(1, within="[1, inf)", doc="steps from one row to the next")
    quantities: tuple[str, ...] | None = attrs.field(default=None, converter=_quantities)
    sites: tuple[int, ...] | None = attrs.field(default=None, converter=_indices)
    points: tuple[float, ...] | float | None = numbers(None, unit="m", doc="keep the sites nearest to these positions")
    density_at: tuple[float, ...] | float = numbers(
        (), unit="s", within="[0, inf)", doc="times at which the density is kept"
    )
    fields: tuple[str, ...] | None = attrs.field(default=None, converter=_fields)
    fields_every: int = integer(0, doc="steps between kept states of a body; 0: at most 40, evenly spread")
    fields_at: tuple[float, ...] | float = numbers(
        (), unit="s", within="[0, inf)", doc="times at which a body's fields are kept"
    )
    checkpoint_every: float = number(30.0, unit="s", within="(0, inf)", doc="computing time between files")

    def wanted(self, solid: MacroSolid) -> tuple[str, ...]:
        """Quantities that are kept of this solid."""
        if self.quantities is not None:
            return self.quantities
        n_sites = solid.n_sites
        kept = n_sites if self.sites is None and self.points is None else len(self.columns(solid))
        at_sites = _AT_SITES if kept <= _MANY_SITES else ()
        return (*at_sites, *(("summary",) if n_sites > _MANY_SITES else ()), "energy", "reactions")

    def check(self, simulation: Simulation, steps: int) -> None:
        """Whether what is asked for exists, and a run of `steps` steps can hold the fields.

        Raises
        ------
        ParameterError
            With the key, what is wrong and what is allowed.
        """
        self.columns(simulation.solid)
        check_fields(self.fields, self.fields_every, simulation, steps, self.field_times())

    def columns(self, solid: MacroSolid) -> np.ndarray:
        """Indices of the sites that are kept."""
        n_sites = solid.n_sites
        if self.points is not None:
            along = solid.site_positions()[:, 0]
            self._check_points(along)
            return np.array([int(np.argmin(np.abs(along - point))) for point in np.atleast_1d(self.points)])
        if self.sites is None:
            return np.arange(n_sites)
        if max(self.sites) >= n_sites:
            raise ParameterError("sites", f"names site {max(self.sites)}; the solid has sites 0 to {n_sites - 1}")
        return np.array(self.sites)

    def _check_points(self, along: Array) -> None:
        """Every point lies no farther outside the sites than these lie from each other."""
        if along.size == 1:  # one site stands for the whole solid
            return
        margin = float(np.max(np.diff(np.sort(along))))
        low, high = float(along.min()) - margin, float(along.max()) + margin
        for point in np.atleast_1d(np.asarray(self.points)):
            if not low <= point <= high:
                raise ParameterError(
                    "points",
                    f"names {point:g} m, outside the solid: its sites lie from {along.min():g} to {along.max():g} m",
                )

    def density_times(self) -> list[float]:
        """Times at which the density is kept [s], sorted."""
        return sorted({float(time) for time in np.atleast_1d(self.density_at)})

    def field_times(self) -> list[float]:
        """Times at which fields are kept [s], sorted."""
        return sorted({float(time) for time in np.atleast_1d(self.fields_at)})


@attrs.frozen(eq=False)
class DensitySnapshot:
    """Attached fraction over displacement [reach] at one time; both (n_sites, n_points)."""

    time: float
    position: Array
    fraction: Array


class _Rows:
    """Rows of one quantity in an array that grows by doubling."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._data = np.empty((16, *shape))
        self._count = 0

    @classmethod
    def of(cls, rows: Array) -> _Rows:
        """Rows that exist already."""
        made = cls(rows.shape[1:])
        made._data, made._count = np.array(rows), len(rows)
        return made

    def append(self, row: Array) -> None:
        if self._count == len(self._data):
            self._data = np.concatenate([self._data, np.empty_like(self._data)])
        self._data[self._count] = row
        self._count += 1

    @property
    def array(self) -> Array:
        return self._data[: self._count]


class Recorder:
    """Keeps rows of a simulation as a `Record` says."""

    def __init__(self, record: Record, simulation: Simulation) -> None:
        self.record = record
        self.columns = record.columns(simulation.solid)
        self.snapshots: list[DensitySnapshot] = []
        self.body = FieldRecorder(record.fields, record.fields_every, simulation, record.field_times())
        self._rows: dict[str, _Rows] = {}
        self._pending = record.density_times()
        self._last_time = -np.inf
        self._sources = sources(record.wanted(simulation.solid), simulation, self.columns)
        simulation.stop_at([time for time in (*self._pending, *record.field_times()) if time > 0.0])

    def resume(
        self,
        series: Mapping[str, Array],
        snapshots: Sequence[DensitySnapshot],
        fields: Sequence[FieldSnapshot],
        simulation: Simulation,
    ) -> None:
        """Take over the rows and states of an earlier run, as far as a run that never stopped would have them."""
        self.body.resume(fields)
        # The last row of an interrupted run may lie between two regular ones.
        extra = series["time"][-1] == simulation.time and simulation.steps % self.record.every != 0
        self._rows = {name: _Rows.of(rows[:-1] if extra else rows) for name, rows in series.items()}
        self._last_time = float(self._rows["time"].array[-1])
        self.snapshots = list(snapshots)
        self._pending = [pending for pending in self._pending if not _reached(simulation.time, pending)]

    def observe(self, simulation: Simulation, *, last: bool = False) -> None:
        """Keep a row and the fields if they are due, and a density snapshot if its time has come."""
        time = simulation.time
        while self._pending and _reached(time, self._pending[0]):
            self._pending.pop(0)
            self._snapshot(simulation)
        self.body.observe(simulation, last=last)
        due = simulation.steps % self.record.every == 0 or last
        if not due or time == self._last_time:
            return
        self._last_time = time
        for source in self._sources:
            for name, value in source().items():
                if name not in self._rows:
                    self._rows[name] = _Rows(value.shape)
                self._rows[name].append(value)

    def series(self) -> dict[str, Array]:
        """All rows so far by name, ``(n_rows,)`` or ``(n_rows, n_sites)``."""
        return {name: rows.array for name, rows in self._rows.items()}

    def _snapshot(self, simulation: Simulation) -> None:
        if simulation.bus is None:
            return
        density = simulation.bus.model.density(np.array(simulation.bus.population[self.columns]))
        if density is not None:
            self.snapshots.append(DensitySnapshot(simulation.time, *density))


def _reached(time: float, sought: float) -> bool:
    return time >= sought - 1e-9 * max(1.0, time)
