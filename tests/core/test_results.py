"""A run that was interrupted and resumed is, to the last bit, the run that never stopped; files are always whole."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import myobridge as mb
from myobridge.plan import Plan
from myobridge.run import start

MODELS = mb.registry().names("cross_bridge")


def assert_identical(one: mb.Result, other: mb.Result) -> None:
    """Same series, snapshots and checkpoint, bit by bit."""
    assert set(one.series) == set(other.series)
    for name, rows in one.series.items():
        np.testing.assert_array_equal(rows, other.series[name], err_msg=name, strict=True)
    assert [item.time for item in one.densities] == [item.time for item in other.densities]
    for left, right in zip(one.densities, other.densities, strict=True):
        np.testing.assert_array_equal(left.fraction, right.fraction)
        np.testing.assert_array_equal(left.position, right.position)
    assert dict(one.checkpoint.scalars) == dict(other.checkpoint.scalars)
    assert set(one.checkpoint.arrays) == set(other.checkpoint.arrays)
    for name, array in one.checkpoint.arrays.items():
        np.testing.assert_array_equal(array, other.checkpoint.arrays[name], err_msg=name, strict=True)


def in_two_parts(scene: mb.Scene, cut: float, path: Path) -> mb.Result:
    """Run to `cut`, let the file be all that is left, and continue from it."""
    start(Plan.of(scene), path).to(scene.duration, until=cut)
    continued, again = mb.resume(path)
    assert again == scene
    return continued.to(again.duration)


def sample(text: str, steps: int = 200, **settings: object) -> mb.Scene:
    """Scene of `steps` steps, with keys set (``section__key``)."""
    scene = mb.Scene.from_toml(text)
    return scene.with_settings(
        {"scene.step": scene.duration / steps, **{key.replace("__", "."): value for key, value in settings.items()}}
    )


@pytest.mark.parametrize("every", [1, 7])
@pytest.mark.parametrize("name", ["clamp", "spring", "chain", "rope", "passive"])
def test_run_200_is_run_100_and_resume_100(name: str, every: int, scenes, tmp_path: Path) -> None:
    scene = sample(scenes[name], record__every=every)
    whole = mb.run(scene)
    assert whole.checkpoint.scalars["steps"] == 200
    assert np.ptp(whole["stretch"]) > 1e-3, "something must have moved"
    assert_identical(in_two_parts(scene, 0.5 * scene.duration, tmp_path / "half.h5"), whole)


@pytest.mark.parametrize("cut", [0.0031, 0.0101, 0.0155])
def test_an_odd_step_between_two_rows_is_a_place_to_stop(cut: float, scenes, tmp_path: Path) -> None:
    scene = sample(scenes["clamp"], record__every=7)
    part = start(Plan.of(scene), tmp_path / "part.h5").to(scene.duration, until=cut)
    assert part.checkpoint.scalars["steps"] % 7 != 0
    assert part["time"][-1] == part.checkpoint.scalars["time"] >= cut
    continued, _ = mb.resume(tmp_path / "part.h5")
    assert_identical(continued.to(scene.duration), mb.run(scene))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", ["clamp", "spring"])
def test_every_model_resumes(model: str, name: str, scenes, tmp_path: Path) -> None:
    scene = sample(scenes[name], 40, cross_bridges__plugin=model, record__every=3)
    assert_identical(in_two_parts(scene, 0.4 * scene.duration, tmp_path / "part.h5"), mb.run(scene))


def test_heads_with_mass_and_the_gate_of_calcium_resume(scenes, tmp_path: Path) -> None:
    text = scenes["chain"].replace('"activation"]', '"activation", "calcium"]') + '[calcium]\nplugin = "first_order"\n'
    scene = sample(text, 60)
    assert_identical(in_two_parts(scene, 0.3 * scene.duration, tmp_path / "calcium.h5"), mb.run(scene))
    heavy = sample(
        scenes["spring"].replace('"liouville"', '"discrete"').replace('"inertia"]', '"inertia", "cross_bridge_mass"]')
    )
    assert_identical(in_two_parts(heavy, 0.3 * heavy.duration, tmp_path / "mass.h5"), mb.run(heavy))


@pytest.mark.parametrize("cut", [0.0049, 0.0052, 0.0075, 0.0121])
def test_density_snapshots_are_neither_lost_nor_taken_twice(cut: float, scenes, tmp_path: Path) -> None:
    times = [0.0, 0.00505, 0.0074, 0.012, 0.02]
    scene = sample(scenes["clamp"], 100, cross_bridges__plugin="huxley", record__density_at=times, record__every=7)
    whole = mb.run(scene)
    assert [item.time for item in whole.densities] == pytest.approx(times, abs=1e-15)
    assert_identical(in_two_parts(scene, cut, tmp_path / "part.h5"), whole)


def test_a_file_written_between_two_rows_loses_no_row(scenes, tmp_path: Path) -> None:
    """What kill -9 leaves: the last regular write, without the extra row of an orderly stop."""
    scene = sample(scenes["clamp"], record__every=7)
    running = start(Plan.of(scene))
    for _ in range(17):
        running.recorder.observe(running.simulation)
        running.simulation.step(scene.duration)
    running.recorder.observe(running.simulation)
    left = running.result()
    assert left.checkpoint.scalars["steps"] == 17
    assert len(left["time"]) == 3
    left.save(tmp_path / "left.h5")
    continued, _ = mb.resume(tmp_path / "left.h5")
    assert_identical(continued.to(scene.duration), mb.run(scene))


def test_a_longer_duration_goes_on_where_the_run_ended(scenes, tmp_path: Path) -> None:
    scene = sample(scenes["spring"], 100)
    mb.run(scene, tmp_path / "first.h5")
    continued, longer = mb.resume(tmp_path / "first.h5", tmp_path / "second.h5", {"scene.duration": 0.04})
    assert_identical(continued.to(longer.duration), mb.run(scene.with_settings({"scene.duration": 0.04})))
    assert mb.Result.load(tmp_path / "first.h5")["time"][-1] == pytest.approx(0.02, abs=1e-15)


@pytest.mark.parametrize(
    "key", ["scene.step", "solid.stiffness", "scene.effects", "record.sites", "record.quantities", "record.points"]
)
def test_a_resumed_run_is_the_same_simulation(key: str, scenes, tmp_path: Path) -> None:
    mb.run(sample(scenes["spring"], 10), tmp_path / "first.h5")
    with pytest.raises(mb.SceneError, match=rf"--set {key}: cannot change .*scene\.duration, record\.every"):
        mb.resume(tmp_path / "first.h5", settings={key: 1})


def test_what_is_loaded_is_what_was_saved(scenes, tmp_path: Path) -> None:
    scene = sample(scenes["chain"], 20, record__quantities=["stretch", "energy", "displacement", "reactions"])
    result = mb.run(scene, tmp_path / "result.h5")
    again = mb.Result.load(tmp_path / "result.h5")
    assert_identical(again, result)
    assert mb.Scene.from_toml(again.scene) == scene
    np.testing.assert_array_equal(again.sites, np.arange(4))
    assert again.provenance["plugin solid"] == "chain"
    assert again.provenance["version myobridge"] == mb.__version__
    with h5py.File(tmp_path / "result.h5") as file:
        assert {"series", "scene", "provenance", "checkpoint"} <= set(file)
        assert file["series/stretch"].shape == (21, 4)  # pyright: ignore
        assert file["series/energy/elastic"].shape == (21,)  # pyright: ignore


def test_an_unknown_series_gets_the_nearest_match(scenes) -> None:
    with pytest.raises(mb.MyobridgeError, match=r"no series 'tensoin'.*Did you mean 'tension'\?"):
        mb.run(sample(scenes["clamp"], 2))["tensoin"]


def test_a_failing_write_leaves_the_old_file_and_nothing_beside(
    scenes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "result.h5"
    old = mb.run(sample(scenes["clamp"], 10), path)
    new = mb.run(sample(scenes["clamp"], 20))
    before = path.read_bytes()

    def full(self: object, *_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(h5py.Group, "create_group", full)
    with pytest.raises(mb.MyobridgeError, match=r"result\.h5: cannot be written .*No space left"):
        new.save(path)
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == ["result.h5"]
    assert_identical(mb.Result.load(path), old)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
def test_a_truncated_file_gives_a_clear_error(share: float, scenes, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    mb.run(sample(scenes["clamp"], 50), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(mb.MyobridgeError, match=r"result\.h5: is damaged, or no result of myobridge"):
        mb.Result.load(path)


@pytest.mark.parametrize("missing", ["series", "scene", "checkpoint", "provenance"])
def test_a_file_without_one_of_its_parts_gives_a_clear_error(missing: str, scenes, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    mb.run(sample(scenes["clamp"], 5), path)
    with h5py.File(path, "a") as file:
        del file[missing]
    with pytest.raises(mb.MyobridgeError, match=f"is damaged, or no result of myobridge.*{missing}"):
        mb.Result.load(path)


@pytest.mark.parametrize("missing", ["bus/population", "motion/velocity"])
def test_a_checkpoint_of_another_simulation_gives_a_clear_error(missing: str, scenes, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    mb.run(sample(scenes["clamp"], 5), path)
    with h5py.File(path, "a") as file:
        del file[f"checkpoint/{missing}"]
    with pytest.raises(mb.MyobridgeError, match=r"the checkpoint does not fit the simulation"):
        mb.resume(path)
    mb.run(sample(scenes["clamp"], 5), path)
    with h5py.File(path, "a") as file:
        del file["checkpoint/bus/population"]
        file["checkpoint/bus/population"] = np.zeros((7, 3))
    with pytest.raises(mb.MyobridgeError, match=r"shape \(7, 3\), expected \(2, "):
        mb.resume(path)


def test_a_composed_run_has_no_scene_to_resume(scenes, tmp_path: Path) -> None:
    simulation = Plan.of(sample(scenes["spring"], 5)).simulation()
    mb.Run(simulation, output=tmp_path / "composed.h5").to(0.01)
    assert mb.Result.load(tmp_path / "composed.h5")["time"][-1] == pytest.approx(0.01, abs=1e-15)
    with pytest.raises(mb.SceneError, match="holds no scene"):
        mb.resume(tmp_path / "composed.h5")


@pytest.mark.parametrize("cut", [0.0061, 0.0068, 0.0085, 0.0105])
def test_a_run_resumes_amid_halved_steps(cut: float, scenes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cls = mb.registry().find("time_integrator", "quasi_static").cls
    real = cls.step

    def fussy(self, solid, law, motion, memory, time, dt):
        if 5.5e-3 < time < 7.5e-3 and dt > 3e-4:
            return mb.StepResult(motion, memory, mb.StepReport(converged=False, reason="too large for me"))
        return real(self, solid, law, motion, memory, time, dt)

    monkeypatch.setattr(cls, "step", fussy)
    scene = sample(scenes["chain"], 20)
    whole = mb.run(scene)
    assert np.diff(whole["time"]).min() == pytest.approx(2.5e-4)
    assert np.diff(whole["time"])[-1] == pytest.approx(1e-3)
    assert_identical(in_two_parts(scene, cut, tmp_path / "part.h5"), whole)


def test_what_an_integrator_remembers_is_resumed(scenes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cls = mb.registry().find("time_integrator", "energy_momentum").cls
    real = cls.step

    def counting(self, solid, law, motion, memory, time, dt):
        result = real(self, solid, law, motion, memory, time, dt)
        return result._replace(memory={"count": memory.get("count", np.zeros(1)) + 1.0})

    monkeypatch.setattr(cls, "step", counting)
    scene = sample(scenes["spring"], 20)
    whole = mb.run(scene)
    assert whole.checkpoint.arrays["memory/count"] == 20.0
    assert_identical(in_two_parts(scene, 0.01, tmp_path / "part.h5"), whole)


def test_the_last_tension_and_activation_are_resumed(scenes, tmp_path: Path) -> None:
    """A clamp books the work of a tension without energy from the last one; `staggered` begins with both."""
    text = scenes["clamp"].replace('["cross_bridges"]', '["cross_bridges", "force_velocity"]')
    hill = sample(text, 40, cross_bridges__plugin="hill")
    assert_identical(in_two_parts(hill, 0.01, tmp_path / "hill.h5"), mb.run(hill))
    staggered = sample(scenes["chain"], 40, coupling__plugin="staggered", cross_bridges__plugin="hill")
    assert_identical(in_two_parts(staggered, 0.005, tmp_path / "staggered.h5"), mb.run(staggered))
