"""Studies on dask: local processes, a cluster by its address, workers and clients that die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import myobridge as mb
from myobridge.study import Quantity
from myobridge.study.crew import _OnCluster
from myobridge.study.measurement import Measurement

SCENE = """
[scene]
name = "clamp"
effects = ["cross_bridges"]
duration = 0.02
step = 1e-3
[solid]
plugin = "clamp"
path = { plugin = "ramp", initial = 1.0, final = 0.98, start = 0.005, end = 0.015 }
[cross_bridges]
plugin = "distributed_moment"
"""
SLOW = SCENE.replace("duration = 0.02", "duration = 3.0")


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Address of a cluster of two workers that is there already."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        silence_logs=50,
    ) as there:
        yield there.scheduler_address


def study(**said) -> mb.Study:
    """Small study."""
    given = {"vary": {"scene.step": [2e-3, 1e-3]}, "repeats": 1, "quantities": ["tension"], **said}
    return mb.Study(scene=mb.Scene.from_toml(SCENE), **given)


def killing(marker: str) -> Quantity:
    """Quantity that kills the worker of the run with a step of 2 ms: always, or once where `marker` names a file."""

    def tension(now) -> float:
        if now.control.dt == 2e-3 and now.steps == 3 and not (marker and os.path.exists(marker)):
            if marker:
                Path(marker).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return float(now.bus.tension.mean())

    return Quantity("tension by hand", tension)


def test_local_processes_find_what_this_process_finds(tmp_path) -> None:
    seen = []
    theirs = study().run(tmp_path, workers=2, watch=seen.append)
    ours = study().run(workers=0)
    assert [row.error for row in theirs.rows] == [row.error for row in ours.rows]
    assert [row.work for row in theirs.rows] == [row.work for row in ours.rows]
    assert len(seen) == theirs.computed == 5
    assert seen[-1].done == pytest.approx(seen[-1].total)
    assert study().run(tmp_path, workers=0).kept == 5, "who ran it makes no difference"


def test_a_cluster_by_its_address(cluster) -> None:
    result = study().run(scheduler=cluster)
    assert all(row.measured for row in result.rows)
    assert result.computed == 5


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_variant_that_kills_its_worker_is_a_row(workers: int, tmp_path) -> None:
    """It alone: with one worker all others wait where it dies, each time."""
    said = {"quantities": [killing("")], "reference": {"settings": {"scene.step": 2.5e-4}}}
    result = study(**said).run(tmp_path, workers=workers)
    dead, alive = result.rows
    assert dead.reason == "the worker that ran it died, each time"
    assert alive.measured
    assert len(list((tmp_path / "runs").glob("*.npz"))) == 4, "it may go well next time, so it is not kept"


def test_what_waited_where_a_worker_died_is_tried_alone(monkeypatch) -> None:
    """The scheduler blames all tasks of a worker that dies; which of them did it, it cannot know."""
    tried: list[tuple[str, ...]] = []

    def together(self, tasks, mark):
        tried.append(tuple(tasks))
        guilty = "guilty" in tasks
        for key in tasks:
            yield key, (None if guilty and key != "far away" else Measurement(steps=1))

    monkeypatch.setattr(_OnCluster, "_together", together)
    found = dict(_OnCluster(None).run((key, None) for key in ("guilty", "beside it", "far away")))
    assert tried == [("guilty", "beside it", "far away"), ("guilty",), ("beside it",)]
    assert found["guilty"].failure == "the worker that ran it died, each time"
    assert not found["beside it"].failure
    assert not found["far away"].failure


def test_a_worker_that_is_killed_once_costs_no_run(tmp_path, cluster) -> None:
    said = {"quantities": [killing(str(tmp_path / "dead"))], "reference": {"settings": {"scene.step": 2.5e-4}}}
    result = study(**said).run(scheduler=cluster)
    assert (tmp_path / "dead").exists(), "a worker has died"
    assert all(row.measured for row in result.rows)


@pytest.mark.slow
def test_a_killed_client_goes_on(tmp_path) -> None:
    (tmp_path / "slow.toml").write_text(SLOW, encoding="utf-8")
    steps = "[8e-3, 6e-3, 5e-3, 4e-3, 3e-3]"
    head = '[study]\nscene = "slow.toml"\nquantities = ["tension"]\nrepeats = 2\n'
    (tmp_path / "study.toml").write_text(f'{head}[vary]\n"scene.step" = {steps}\n', encoding="utf-8")
    command = [sys.executable, "-m", "myobridge.cli", "cost", "study.toml", "-o", "out", "--workers", "2"]
    client = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, start_new_session=True)
    kept = tmp_path / "out" / "runs"
    until = time.monotonic() + 600.0  # starting the workers alone takes minutes where others keep the machine busy
    try:
        while not list(kept.glob("*.npz")):
            assert client.poll() is None, "it ended before it could be killed"
            assert time.monotonic() < until
            time.sleep(0.02)
    finally:
        client.kill()
        client.wait()
    finished = len(list(kept.glob("*.npz")))
    result = mb.Study.load(tmp_path / "study.toml").run(tmp_path / "out", workers=0)
    assert result.kept >= finished >= 1
    assert result.computed >= 1, "it was killed on the way"
    assert result.kept + result.computed == 13
    assert all(row.measured for row in result.rows)


def test_a_scheduler_that_is_not_there_is_told(cli, write, monkeypatch) -> None:
    monkeypatch.setattr("myobridge.study.crew.PATIENCE", "1s")
    write(SCENE)
    path = write('[study]\nscene = "scene.toml"\n[vary]\n"scene.step" = [2e-3]\n', "study.toml")
    outcome = cli("cost", path, "--scheduler", "tcp://127.0.0.1:9")
    assert outcome.code == 2
    assert "--scheduler tcp://127.0.0.1:9: is not reached within 1s" in outcome.err
    assert len(outcome.err.splitlines()) == 1
    outcome = cli("cost", path, "--scheduler", "nonsense", "--workers", "2")
    assert "--workers: is for a local cluster" in outcome.err
