"""Bench: runs of a study, taken from the store or from the crew, each once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from myobridge.errors import MyobridgeError
from myobridge.plan import Plan
from myobridge.scene import Scene
from myobridge.study.crew import Crew
from myobridge.study.measurement import Measurement, Task
from myobridge.study.progress import Progress, Watch, weight
from myobridge.study.quantities import Quantity
from myobridge.study.store import Store, key_of

__all__ = ["Bench", "Job"]

Job = tuple[Scene, int]
"""A scene, and which of its timed runs."""


@final
class Bench:
    """Runs scenes.

    Parameters
    ----------
    store : Store
    crew : Crew
    quantities : sequence of Quantity
        Read after every step.
    stops : sequence of float
        Times at which steps end [s].
    watch : callable, optional
        Told after every run.
    optional : bool
        Whether quantities that a scene has not are left out.

    Attributes
    ----------
    computed, found : int
        Runs computed now, and runs that were kept from before.
    cpu : float
        CPU seconds of the runs computed now.
    """

    def __init__(
        self,
        store: Store,
        crew: Crew,
        quantities: Sequence[Quantity],
        stops: Sequence[float],
        watch: Watch | None,
        *,
        optional: bool = False,
    ) -> None:
        self._optional = optional
        self.store, self.crew, self._quantities, self._stops, self._watch = store, crew, quantities, stops, watch
        self.computed = self.found = 0
        self.cpu = 0.0
        self._done = self._total = 0.0
        self._runs = self._planned = 0

    def run(self, jobs: Sequence[Job], limit: float = float("inf")) -> list[Measurement]:
        """Measurements of the jobs, in their order.

        Parameters
        ----------
        limit : float
            CPU seconds after which a run is given up; it is run again where more is allowed.
        """
        tasks = [self._task(scene, limit) for scene, _ in jobs]
        keys = [key_of(task, number) for task, (_, number) in zip(tasks, jobs, strict=True)]
        answers: dict[str, Measurement] = {}
        missing: dict[str, tuple[Task, float, str]] = {}
        for key, task, (scene, _) in zip(keys, tasks, jobs, strict=True):
            kept = self.store.find(key)
            if kept is not None and not (kept.stopped and kept.cpu <= limit):
                self.found += key not in answers
                answers[key] = kept
            elif key not in missing:
                missing[key] = (task, _weight(scene), scene.name)
        self._total += sum(cost for _, cost, _ in missing.values())
        self._planned += len(missing)
        for key, measurement in self.crew.run((key, task) for key, (task, _, _) in missing.items()):
            answers[key] = measurement
            if not _is_fault_of_the_machine(measurement):
                self.store.keep(key, measurement)
            self._tell(measurement, missing[key][1], missing[key][2])
        return [answers[key] for key in keys]

    def _task(self, scene: Scene, limit: float) -> Task:
        folder = "" if scene.folder is None else str(scene.folder.resolve())
        return Task(scene.to_toml(), folder, tuple(self._quantities), tuple(self._stops), limit, self._optional)

    def _tell(self, measurement: Measurement, cost: float, label: str) -> None:
        self.computed += 1
        self.cpu += measurement.cpu
        self._runs += 1
        self._done += cost
        if self._watch is not None:
            self._watch(Progress(self._done, self._total, self._runs, self._planned, label))


def _is_fault_of_the_machine(measurement: Measurement) -> bool:
    """Whether it may go well next time."""
    return measurement.failure.startswith(("the worker", "not enough memory"))


def _weight(scene: Scene) -> float:
    try:
        sizes = Plan.of(scene).sizes()
    except MyobridgeError:
        return 0.0
    return weight(scene.duration / scene.step, sizes["unknowns"], sizes["sites"] * sizes.get("values a site", 0))
