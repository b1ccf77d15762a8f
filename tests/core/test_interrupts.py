"""Ctrl-C waits for the step under way; a second one does not."""

from __future__ import annotations

import signal
import threading

import pytest

import myobridge as mb
from myobridge.interrupts import Terminated, postponed
from myobridge.plan import Plan
from myobridge.run import start


@pytest.fixture(autouse=True)
def _usual_handler():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_the_first_waits_for_the_check_and_the_second_does_not() -> None:
    with postponed() as interrupts:
        interrupts.check()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            interrupts.check()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_termination_is_told_apart() -> None:
    with postponed() as interrupts:
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Terminated):
            interrupts.check()
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_the_handler_of_somebody_else_is_left_alone() -> None:
    heard: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    with postponed() as interrupts:
        signal.raise_signal(signal.SIGINT)
        interrupts.check()
    assert heard == [signal.SIGINT]


def test_a_thread_needs_no_handlers(scenes) -> None:
    results: list[mb.Result] = []
    scene = mb.Scene.from_toml(scenes["passive"])
    thread = threading.Thread(target=lambda: results.append(mb.run(scene)))
    thread.start()
    thread.join()
    assert results[0].checkpoint.scalars["steps"] == 20


def test_an_interrupt_within_a_step_leaves_a_whole_step(scenes, tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = mb.Scene.from_toml(scenes["spring"])
    run = start(Plan.of(scene), tmp_path / "result.h5")
    real = mb.CouplingBus.slide

    def slide(self: mb.CouplingBus, *arguments: object) -> None:
        if self is run.simulation.bus and run.simulation.steps == 8:
            signal.raise_signal(signal.SIGINT)
        real(self, *arguments)

    monkeypatch.setattr(mb.CouplingBus, "slide", slide)
    with pytest.raises(KeyboardInterrupt):
        run.to(scene.duration)
    left = mb.Result.load(tmp_path / "result.h5")
    assert left.checkpoint.scalars["steps"] == 9
    continued, _ = mb.resume(tmp_path / "result.h5")
    assert continued.to(scene.duration)["tension"].tolist() == mb.run(scene)["tension"].tolist()


def test_whatever_a_callback_raises_the_result_so_far_is_kept(scenes, tmp_path) -> None:
    scene = mb.Scene.from_toml(scenes["spring"])

    def after_step(simulation: mb.Simulation, report: object) -> None:
        if simulation.steps == 5:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        start(Plan.of(scene), tmp_path / "result.h5").to(scene.duration, after_step)
    assert mb.Result.load(tmp_path / "result.h5").checkpoint.scalars["steps"] == 5


def test_a_plugin_that_breaks_in_a_step_loses_nothing_before_it(
    scenes, tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = mb.Scene.from_toml(scenes["spring"])
    run = start(Plan.of(scene), tmp_path / "result.h5")
    real = mb.CouplingBus.react

    def react(self: mb.CouplingBus, dt: float) -> None:
        if self is run.simulation.bus and run.simulation.steps == 8:
            raise ZeroDivisionError
        real(self, dt)

    monkeypatch.setattr(mb.CouplingBus, "react", react)
    with pytest.raises(ZeroDivisionError):
        run.to(scene.duration)
    monkeypatch.undo()
    continued, _ = mb.resume(tmp_path / "result.h5")
    assert continued.simulation.steps == 8
    assert continued.to(scene.duration)["tension"].tolist() == mb.run(scene)["tension"].tolist()
