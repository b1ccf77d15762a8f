"""Step control: the same times wherever a run was interrupted; half the step after failures, and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge.plan import Plan
from myobridge.run import start
from myobridge.step_control import StepControl


def times(control: StepControl, time: float, end: float, stops: list[float], fail_at: dict[int, int] | None = None):
    """Times of all accepted steps; `fail_at` maps the number of a try to how often it fails."""
    found, tries = [time], 0
    failing = dict(fail_at or {})
    while time < end - 1e-6 * control.dt:
        target, dt = control.next(time, stops, end)
        assert dt > 0.0
        assert target - time == pytest.approx(dt, rel=1e-9)
        if failing.get(len(found), 0) > 0:
            failing[len(found)] -= 1
            control.failed(time, "asked to", dt)
            assert control.next(time, stops, end)[1] < dt, "the same step again would fail again"
            continue
        control.succeeded(target)
        time = target
        found.append(time)
        tries += 1
        assert tries < 10_000
    return found


@given(
    dt=st.floats(1e-6, 1.0),
    # Tenths lie at a fifth of a step or more from every halved grid, so that a step cut short that fails costs at most
    # three halvings, of the twelve allowed.
    steps=st.integers(3, 600).map(lambda tenths: tenths / 10),
    stops=st.lists(st.integers(0, 600).map(lambda tenths: tenths / 10), max_size=5),
    failures=st.dictionaries(st.integers(1, 40), st.integers(1, 2), max_size=2),
    cut=st.integers(1, 60),
)
def test_an_interrupted_run_takes_the_same_steps(dt, steps, stops, failures, cut) -> None:
    end, stops = steps * dt, sorted(stop * dt for stop in stops)
    whole = times(StepControl(dt), 0.0, end, stops, failures)
    assert whole[-1] == pytest.approx(end, abs=2e-6 * dt)
    assert whole == sorted(set(whole))
    for stop in stops:
        if stop < end:
            assert min(abs(time - stop) for time in whole) <= 2e-6 * dt, "no step crosses a stop"
    # The state of the control at the cut, as a checkpoint holds it.
    control, done = StepControl(dt), [0.0]
    failing = dict(failures)
    while len(done) <= cut and done[-1] < end - 1e-6 * dt:
        target, tried = control.next(done[-1], stops, end)
        if failing.get(len(done), 0) > 0:
            failing[len(done)] -= 1
            control.failed(done[-1], "asked to", tried)
            continue
        control.succeeded(target)
        done.append(target)
    again = StepControl(control.dt, control.halvings, control.successes)
    rest = times(
        again, done[-1], end, stops, {key - len(done) + 1: n for key, n in failing.items() if key >= len(done)}
    )
    assert done[:-1] + rest == whole


def test_full_steps_are_equal_to_the_last_bit() -> None:
    control, time, steps = StepControl(1e-3), 0.0, set()
    for _ in range(1000):
        time, dt = control.next(time, (), np.inf)
        control.succeeded(time)
        steps.add(dt)
    assert steps == {1e-3}
    assert time == pytest.approx(1.0, abs=1e-15)


def test_halving_and_regrowth() -> None:
    found = np.diff(times(StepControl(1.0), 0.0, 12.0, [], {3: 2}))
    np.testing.assert_allclose(found[:2], 1.0)
    np.testing.assert_allclose(found[2:6], 0.25)
    assert 0.5 in found[6:12]
    np.testing.assert_allclose(found[-4:], 1.0)
    assert np.all(np.isin(found, [0.25, 0.5, 1.0])), "back on the grid at every size"


def test_after_twelve_halvings_it_is_over() -> None:
    control = StepControl(1.0)
    for halvings in range(12):
        control.failed(0.5, "no reason", 2.0**-halvings)
    assert control.next(0.5, (), 10.0)[1] == 2.0**-12
    with pytest.raises(
        mb.StepFailed, match=r"t = 0\.5 s failed even after 12 halvings \(dt = 0\.000244 s\): no reason"
    ):
        control.failed(0.5, "no reason", 2.0**-12)


def test_a_step_cut_short_that_fails_is_not_tried_again_as_it_is() -> None:
    control = StepControl(1.0)
    target, dt = control.next(0.9, (), 10.0)
    assert target == 1.0
    control.failed(0.9, "no reason", dt)
    assert control.next(0.9, (), 10.0)[1] == pytest.approx(0.0375)


class Fussy(mb.TimeIntegrator):
    """Refuses steps above a limit that depends on time."""

    inertia = False

    def __init__(self, limit) -> None:
        self.limit = limit
        self.inner = mb.registry().find("time_integrator", "quasi_static").cls()
        self.tried: list[tuple[float, float]] = []

    def step(self, solid, law, motion, memory, time, dt):
        self.tried.append((time, dt))
        if dt > self.limit(time):
            report = mb.StepReport(converged=False, reason="too large for me")
            return mb.StepResult(mb.Motion(motion.displacement + 1e9, motion.velocity), memory, report)
        return self.inner.step(solid, law, motion, memory, time, dt)


def fussy(scenes, limit) -> tuple[mb.Simulation, Fussy]:
    parts = dict(Plan.of(mb.Scene.from_toml(scenes["chain"])).parts)
    integrator = Fussy(limit)
    return mb.Simulation(**(parts | {"integrator": integrator}), dt=1e-3), integrator


def test_a_step_that_fails_is_retried_from_the_untouched_state(scenes) -> None:
    simulation, integrator = fussy(scenes, lambda time: 3e-4 if time < 4e-3 else 1.0)
    reference, _ = fussy(scenes, lambda time: 1.0)
    sizes: list[float] = []
    simulation.run(0.02, lambda now, report: sizes.append(now.time))
    assert integrator.tried[0] == (0.0, 1e-3)
    steps = np.diff([0.0, *sizes])
    assert steps[0] == pytest.approx(2.5e-4)
    assert steps[-1] == pytest.approx(1e-3), "the step has grown back"
    reference.run(0.02)
    one, other = simulation.solid.stretch(simulation.motion.displacement, 0), reference.motion.displacement
    np.testing.assert_allclose(one, reference.solid.stretch(other, 0), rtol=1e-3)


def test_the_result_so_far_is_kept_when_no_step_is_small_enough(scenes, tmp_path) -> None:
    simulation, _ = fussy(scenes, lambda time: 1.0 if time < 9.5e-3 else 0.0)
    with pytest.raises(mb.StepFailed, match="too large for me"):
        mb.Run(simulation, output=tmp_path / "kept.h5").to(0.02)
    kept = mb.Result.load(tmp_path / "kept.h5")
    assert kept["time"][-1] == pytest.approx(0.01, abs=1e-15)
    assert len(kept["time"]) == 11
    good, _ = fussy(scenes, lambda time: 1.0)
    np.testing.assert_array_equal(kept["tension"], mb.Run(good).to(0.01)["tension"])


def test_jumps_of_signals_are_ends_of_steps(scenes) -> None:
    text = scenes["clamp"].replace("start = 0.005, end = 0.015", "start = 0.00512, end = 0.01499")
    found = mb.run(mb.Scene.from_toml(text))["time"]
    for jump in (0.00512, 0.01499):
        assert np.abs(found - jump).min() < 1e-15
    assert len(found) == 23


def test_an_output_time_changes_no_step(scenes) -> None:
    scene = mb.Scene.from_toml(scenes["spring"])
    run = start(Plan.of(scene))
    for until in (0.00345, 0.0101, 0.0199):
        run.to(scene.duration, until=until)
    np.testing.assert_array_equal(run.to(scene.duration)["tension"], mb.run(scene)["tension"])
