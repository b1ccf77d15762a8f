"""Crew: who runs the tasks of a study: this process, local processes, or the workers of a cluster that is there."""

from __future__ import annotations

import contextlib
import logging
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, final

from myobridge.errors import MyobridgeError
from myobridge.study.measurement import Measurement, Task, measured

__all__ = ["PATIENCE", "Crew", "crew"]

PATIENCE = "10s"
"""How long a scheduler is waited for."""
# A task that kills its worker is tried once more, in case it was not the task's fault.
_DEATHS = 1


class Crew(ABC):
    """Abstract crew."""

    @property
    @abstractmethod
    def size(self) -> int:
        """How many tasks run side by side."""

    @abstractmethod
    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[tuple[str, Measurement]]:
        """Run tasks in about the given order; answers come as they are finished, by the key of each."""


@contextlib.contextmanager
def crew(workers: int | None = None, scheduler: str | None = None) -> Iterator[Crew]:
    """The crew that is asked for; what it started is stopped at the end.

    Raises
    ------
    MyobridgeError
        If the scheduler is not reached.
    """
    if scheduler is not None and workers is not None:
        raise MyobridgeError("--workers: is for a local cluster, and --scheduler names another; give one of the two")
    if scheduler is None and workers == 0:
        yield _Alone()
        return
    if scheduler is None and workers is not None and workers < 0:
        raise MyobridgeError(f"--workers: is {workers}; expected a whole number in [0, inf)")
    if scheduler is not None:  # whether it is there is said at once
        with _remote(scheduler) as client:
            yield _OnCluster(client)
        return
    with contextlib.ExitStack() as started:
        yield _WhenNeeded(workers or _cores(), started)


@final
class _Alone(Crew):
    """One after the other, in this process."""

    @property
    def size(self) -> int:
        return 1

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[tuple[str, Measurement]]:
        for key, task in tasks:
            yield key, measured(task)


@final
class _WhenNeeded(Crew):
    """Local processes, started with the first task: what is kept on disk needs none."""

    def __init__(self, workers: int, started: contextlib.ExitStack) -> None:
        self._workers, self._started = workers, started
        self._inner: Crew | None = None

    @property
    def size(self) -> int:
        return self._workers

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[tuple[str, Measurement]]:
        given = list(tasks)
        if given and self._inner is None:
            self._inner = _OnCluster(self._started.enter_context(_local(self._workers)))
        if self._inner is not None:
            yield from self._inner.run(given)


@final
class _OnCluster(Crew):
    """Workers of a dask scheduler."""

    def __init__(self, client: Any) -> None:
        self._client = client

    @property
    def size(self) -> int:
        return max(sum(self._client.nthreads().values()), 1)

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[tuple[str, Measurement]]:
        given, suspects = dict(tasks), list[str]()
        for key, found in self._together(given, ""):
            if found is None:
                suspects.append(key)
            else:
                yield key, found
        # A worker that dies takes along what waits there. Who is to blame shows when it is alone.
        for key in suspects:
            found = None
            if len(given) > 1:
                ((_, found),) = self._together({key: given[key]}, "-alone")
            yield key, found or Measurement(failure="the worker that ran it died, each time")

    def _together(self, tasks: Mapping[str, Task], mark: str) -> Iterator[tuple[str, Measurement | None]]:
        """Answers as they are finished; none of a task whose workers died."""
        from distributed import as_completed

        keys: dict[str, str] = {}
        futures: list[Any] = []
        for key, task in tasks.items():
            futures.append(self._client.submit(measured, task, key=f"myobridge-{key}{mark}", pure=False))
            keys[futures[-1].key] = key
        for future in as_completed(futures, loop=self._client.loop):
            yield keys[future.key], _answer(future)
            future.release()


def _answer(future: Any) -> Measurement | None:
    """What a worker found; none where the workers died."""
    from concurrent.futures import CancelledError

    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return None
    except CancelledError:
        raise MyobridgeError(
            "the scheduler was lost; finished runs are kept where a folder is given, and the same command goes on"
        ) from None
    except Exception as error:  # what a worker without our package, or with another version, says
        return Measurement(failure=f"{type(error).__name__}: {error}")


@contextlib.contextmanager
def _remote(scheduler: str) -> Iterator[Any]:
    from distributed import Client

    with _quiet():  # it tells what it tries in the log; we say it once
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise MyobridgeError(
                f"--scheduler {scheduler}: is not reached within {PATIENCE} ({reason}); nothing was run. Is a "
                "dask scheduler there, such as 'dask scheduler --port 8786' starts?"
            ) from None
    with client:
        yield client


@contextlib.contextmanager
def _local(workers: int) -> Iterator[Any]:
    from dask import config
    from distributed import Client, LocalCluster

    settings = {"distributed.scheduler.allowed-failures": _DEATHS}
    with config.set(settings), _quiet():
        cluster = LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port; nobody is to look at it
            memory_limit=0,  # how much a run may take is for the machine to say
            silence_logs=logging.CRITICAL,
            env={"NUMBA_NUM_THREADS": "1"},
        )
        with cluster, Client(cluster, set_as_default=False) as client:
            yield client


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without the log of dask: what matters comes as an answer or an error."""
    log = logging.getLogger("distributed")
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)
