"""The study that a plain scene makes: rungs that cannot win are left out, and the recommendation stays right."""

from __future__ import annotations

import attrs
import pytest

import myobridge as mb
from myobridge.study import crew
from myobridge.study.ladder import ladder
from myobridge.study.measurement import Measurement, Task
from myobridge.study.tables import recommendation_text

SCENE = """
[scene]
name = "hold"
effects = ["cross_bridges"]
duration = 0.05
step = 1e-3
[solid]
plugin = "clamp"
path = { plugin = "ramp", initial = 1.0, final = 1.005, start = 0.01, end = 0.03 }
[cross_bridges]
plugin = "huxley"
start = "empty"
bins = 16
"""


@pytest.fixture
def priced_by_work(monkeypatch) -> None:
    """CPU seconds that are the same on every machine and in every run: so much a step, so much a value."""
    real = crew.measured

    def counted(task: Task) -> Measurement:
        found = real(attrs.evolve(task, limit=float("inf")))
        cost = 0.2 * found.steps + 1e-4 * found.work.get("bin_steps", 0)
        return attrs.evolve(found, cpu=cost, stopped=cost > task.limit)

    monkeypatch.setattr(crew, "measured", counted)


@pytest.mark.parametrize("tolerance", [3e-2, 5e-4])
def test_the_recommendation_is_that_of_the_whole_ladder(tolerance: float, priced_by_work) -> None:
    study = mb.Study(
        scene=mb.Scene.from_toml(SCENE),
        vary={"scene.step": [8e-3, 4e-3, 2e-3, 1e-3], "cross_bridges.bins": [8, 16]},
        reference={"settings": {"scene.step": 1e-3, "cross_bridges.bins": 64}},
        tolerance=tolerance,
        repeats=1,
        search=True,
    )
    found, whole = study.run(workers=0), attrs.evolve(study, search=False).run(workers=0)
    best, truly = found.recommend(), whole.recommend(tolerance)
    assert best is not None
    assert truly is not None
    assert best.variant == truly.variant
    assert best.error == truly.error
    left_out = [row for row in found.rows if "finer than one" in row.reason]
    given_up = [row for row in found.rows if "given up" in row.reason]
    assert len(left_out) + len(given_up) == sum(row.cpu > 1.2 * truly.cpu + 0.05 for row in whole.rows) > 0
    assert left_out or tolerance < 1e-3
    for row in left_out:
        same = next(other for other in whole.rows if other.variant == row.variant)
        assert same.cpu > 1.2 * best.cpu, "nothing that could have won was left out"


def test_a_ladder_has_rungs_for_what_the_scene_has(scenes) -> None:
    study = ladder(mb.Scene.from_toml(SCENE), 1e-2)
    steps = sorted({variant.settings["scene.step"] for variant in study.variants})
    bins = sorted({variant.settings["cross_bridges.bins"] for variant in study.variants})
    assert steps[0] == pytest.approx(1e-3 / 64)
    assert steps[-1] == pytest.approx(8e-3), "four steps at least"
    assert bins == [8, 16, 32]
    rope = ladder(mb.Scene.from_toml(scenes["rope"]), 1e-2)
    assert {variant.settings["solid.elements"] for variant in rope.variants} == {1, 2}
    assert study.search


def test_nothing_is_recommended_that_is_not_good_enough(priced_by_work) -> None:
    study = mb.Study(
        scene=mb.Scene.from_toml(SCENE), vary={"cross_bridges.bins": [8]}, tolerance=1e-9, repeats=1, search=True
    )
    result = study.run(workers=0)
    assert result.recommend() is None
    assert "nothing is recommended for 1e-09: the reference itself is off by" in recommendation_text(result, "")
    assert result.rows[0].measured
    assert result.standards[""].error > 1e-9, "eight levels are enough effort"


def test_a_level_that_cannot_be_made_ends_the_refinement_not_the_study(priced_by_work) -> None:
    """No more than 4096 bins: the third level has them, and the fourth is none."""
    fine = mb.Scene.from_toml(SCENE).with_settings({"cross_bridges.bins": 1024})
    study = mb.Study(scene=fine, vary={"scene.step": [4e-3]}, tolerance=1e-9, repeats=1, search=True)
    result = study.run(workers=0)
    assert not result.failures
    assert len(result.standards[""].distances) == 2
    assert result.doubt == result.standards[""].error > 0.0
    assert result.rows[0].measured


def test_a_search_needs_a_tolerance() -> None:
    study = mb.Study(scene=mb.Scene.from_toml(SCENE), vary={"cross_bridges.bins": [8]}, repeats=1, search=True)
    with pytest.raises(mb.MyobridgeError, match="tolerance: is missing; a search needs to know what is good enough"):
        study.run(workers=0)


def test_the_command_recommends_and_writes(cli, write, scenes, tmp_path) -> None:
    path = write(scenes["clamp"], "clamp.toml")
    options = ("--tolerance", "2e-2", "--workers", "0", "--repeats", "1")
    outcome = cli("cost", path, *options)
    assert outcome.code == 0, outcome.err
    assert "recommended for 0.02: --set scene.step=" in outcome.out
    assert "reference: estimated error" in outcome.out
    line = next(line for line in outcome.out.splitlines() if line.startswith("recommended"))
    ran = cli("run", path, "-q", *line.partition(": ")[2].split())
    assert ran.code == 0, ran.err
    names = {file.name for file in (tmp_path / "clamp.cost").iterdir()}
    assert names == {"runs", "study.json", "work_precision.png", "work_precision.svg", "report.html"}
    quiet = cli("cost", path, *options, "-q")
    assert quiet.out.startswith("recommended for 0.02")
    assert len(quiet.out.splitlines()) == 2


def test_a_file_that_is_neither_is_told(cli, write) -> None:
    assert "nowhere.toml: cannot be read (No such file or directory)" in cli("cost", "nowhere.toml").err
    assert "is not valid TOML" in cli("cost", write("a = = b")).err
    assert "solid: is missing" in cli("cost", write("[scene]\nname = 'a'\nduration = 1.0\nstep = 0.1")).err
