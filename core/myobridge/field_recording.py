"""Recording of bodies: which states keep their fields, and how much memory that takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from myobridge.errors import ParameterError, nearest
from myobridge.fields import FieldSnapshot, snapshot
from myobridge.interfaces import Array
from myobridge.look_ahead import memory_of_this_machine
from myobridge.reported_motion import reported_motion
from myobridge.simulation import Simulation

__all__ = ["MOST_STATES", "FieldRecorder", "check_fields", "stride"]

MOST_STATES = 40
"""States that a run keeps at most when nothing is said, besides the last."""


def stride(steps: int, every: int) -> int:
    """Steps between two kept states after `steps` steps.

    `every` where it is given. With 0 the smallest power of two that keeps at most `MOST_STATES`: whenever there are
    more, each second one is dropped, so a run of any length ends with 20 to 40 evenly spread states.
    """
    if every > 0:
        return every
    found = 1
    while steps // found >= MOST_STATES:
        found *= 2
    return found


class FieldRecorder:
    """Keeps the fields of a body: of the first state, each `stride`-th and the last.

    Parameters
    ----------
    names : sequence of str, optional
        Fields to keep; all that exist without, none when empty.
    every : int
        Steps between two kept states; 0 spreads 20 to 40 states over the run, or leaves it to `times`.
    simulation : Simulation
    times : sequence of float
        Times [s] whose states are kept as well; steps have to end there.
    """

    def __init__(
        self, names: Sequence[str] | None, every: int, simulation: Simulation, times: Sequence[float] = ()
    ) -> None:
        self.names = names
        self.every = every
        self.times = times
        self.mesh = None if names == () else simulation.solid.visible_mesh()
        self.snapshots: list[FieldSnapshot] = []

    def resume(self, snapshots: Sequence[FieldSnapshot]) -> None:
        """Take over the states of an earlier run; one that only its end has kept goes with the next that is due."""
        self.snapshots = list(snapshots)

    def observe(self, simulation: Simulation, *, last: bool = False) -> None:
        """Keep the state if it is due."""
        if self.mesh is None:
            return
        steps = simulation.steps
        if self.snapshots and self.snapshots[-1].step == steps:
            return
        if not self._due(steps, simulation.time, steps) and not last:
            return
        self.snapshots = [state for state in self.snapshots if self._due(state.step, state.time, steps)]
        found = self._read(simulation)
        self.snapshots.append(found.sharing(self.snapshots[-1]) if self.snapshots else found)

    def _due(self, step: int, time: float, steps: int) -> bool:
        """Whether the state of this step and time is one to keep after `steps` steps."""
        if step == 0 or any(abs(time - wanted) <= 1e-9 * max(1.0, time) for wanted in self.times):
            return True
        return (self.every > 0 or not self.times) and step % stride(steps, self.every) == 0

    def _read(self, simulation: Simulation) -> FieldSnapshot:
        assert self.mesh is not None
        wanted = self.names is None or "pressure" in self.names
        return snapshot(
            simulation.solid,
            self.mesh,
            reported_motion(simulation) if wanted else simulation.motion,
            simulation.time,
            sites_of(simulation),
            names=self.names,
            step=simulation.steps,
        )


def sites_of(simulation: Simulation) -> Mapping[str, Array]:
    """Fields that live at the sites of a running simulation."""
    return {} if simulation.bus is None else {"stretch": simulation.bus.stretch, **simulation.bus.fields()}


def check_fields(
    names: Sequence[str] | None, every: int, simulation: Simulation, steps: int, times: Sequence[float] = ()
) -> None:
    """Whether the fields exist and a run of `steps` steps can hold them, those of `times` among them.

    Raises
    ------
    ParameterError
        ``fields`` names what the scene has not, or ``fields_every`` keeps more than half of the machine's memory.
    """
    mesh = simulation.solid.visible_mesh()
    if mesh is None:
        if names:
            raise ParameterError("fields", f"are given, and {type(simulation.solid).__name__} has no shape to see")
        return
    if names == ():
        return
    found = snapshot(simulation.solid, mesh, simulation.motion, simulation.time, sites_of(simulation))
    for index, name in enumerate(names or ()):
        if name not in found.names:
            raise ParameterError(
                f"fields[{index}]", f"names '{name}', which this scene has not. {_nearest(name, found)}"
            )
    kept = {"displacement", *names} if names is not None else set(found.names)
    size = sum(array.nbytes for name, array in [*found.at_nodes.items(), *found.on_cells.items()] if name in kept)
    regular = steps // stride(steps, every) if every > 0 or not times else 0
    states = regular + len(times) + 2
    if size * states > 0.5 * memory_of_this_machine():
        raise ParameterError(
            "fields_every",
            f"is {every}: {states:,} states of {size / 2**20:,.3g} MiB need more than half "
            f"of this machine's memory; keep fewer, or 0 for at most {MOST_STATES}",
        )


def _nearest(name: str, found: FieldSnapshot) -> str:
    return nearest(name, found.names)
