"""What a study costs beside its runs; whether its advice, and what `explain` expects, are right by the clock."""

from __future__ import annotations

import warnings
from pathlib import Path
from time import perf_counter, process_time

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.run import start
from myobridge.static_run import StaticRun, UnstableEquilibrium
from myobridge.study.bench import Bench
from myobridge.study.crew import crew
from myobridge.study.judgement import Judge
from myobridge.study.ladder import ladder
from myobridge.study.levels import Levels
from myobridge.study.prediction import predicted
from myobridge.study.stopwatch import Stopwatch
from myobridge.study.store import Store
from myobridge.study.unit_costs import shares

pytestmark = pytest.mark.benchmark

EXAMPLES = Path(__file__).parents[2] / "examples"
# Ten scenes with time: clamps, springs, and two bodies that are small enough.
SCENES = (
    "isometric",
    "ramp",
    "quick_release",
    "twitch",
    "isotonic",
    "thesis_quasi_steady",
    "thesis_spring_two_state",
    "studies/sine",
    "studies/release",
    "force_velocity",
)
TOLERANCE = 1e-2


def test_a_study_costs_little_beside_its_runs(tmp_path) -> None:
    """Processor time of a study of a minute over that of the steps of its runs."""
    scene = mb.Scene.load(EXAMPLES / "ramp.toml")
    study = mb.Study(scene=scene, vary={"scene.step": [4e-3, 2e-3, 1e-3]}, quantities=["tension"], repeats=3)
    study.run(workers=0)  # loads everything
    study = attrs.evolve(study, scene=scene.with_settings({"scene.duration": 15.0}))
    started = process_time()
    result = study.run(tmp_path, workers=0)
    share = (process_time() - started) / result.cpu - 1.0
    print(f"{result.cpu:.1f} s of steps, overhead {100.0 * share:.1f} %")
    assert share < 0.05


@pytest.mark.parametrize("name", SCENES)
def test_the_recommendation_is_right(name: str) -> None:
    """It meets the tolerance against a reference twice finer, and nothing on the ladder that is cheaper by 1.2 does."""
    study = ladder(mb.Scene.load(EXAMPLES / f"{name}.toml"), TOLERANCE)
    result = study.run(workers=0)
    best = result.recommend()
    assert best is not None, "no rung is good enough"
    levels = Levels(study)
    with crew(0) as hands:
        bench = Bench(Store(None), hands, result.study.quantities, (), None)
        finest = len(result.standards[levels.reference_model].distances)
        fine = [levels.scene(levels.reference_model, finest + 1 - away) for away in (2, 1, 0)]
        if name == "thesis_spring_two_state":  # the finest has all bins that there may be, and its error is the step's
            fine = [scene.with_settings({"cross_bridges.bins": 1024}) for scene in fine]
        runs = bench.run([(scene, 0) for scene in fine])
        judge = Judge(result.study, levels)
        known = judge.learn(levels.reference_model, runs)
        assert known is not None, judge.failures
        again = bench.run([(study.scene_of(best.variant.settings), 0)])[0]
        assert again.course is not None
        assert judge.errors(best.variant, again.course)["error"] <= TOLERANCE
        good = [row for row in result.measured if row.error + result.doubt <= TOLERANCE and row.cpu < 1.1 * best.cpu]
        rivals = [row for row in good if row is not best]
        scenes = [study.scene_of(row.variant.settings) for row in (best, *rivals)]
        rounds = bench.run([(scene, 100 + number) for number in range(9) for scene in scenes])
    for place, row in enumerate(rivals, start=1):
        count = 1 + len(rivals)
        ratio = np.median([rounds[k * count].cpu / rounds[k * count + place].cpu for k in range(9)])
        print(f"{name}: {best.label} over {row.label}: {ratio:.2f}")
        assert ratio <= 1.2


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_explain_expects_what_a_run_takes(path: Path, tmp_path, monkeypatch) -> None:
    """Within a factor of 1.5 a step and of 3 in all, from unit costs measured by `explain` itself."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    plan = mb.Plan.of(mb.Scene.load(path))
    expected = predicted(plan)
    assert expected is not None
    run = start(attrs.evolve(plan))
    clock, processor = perf_counter(), process_time()
    if isinstance(run, StaticRun):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnstableEquilibrium)
            run.trace()
        ratios = ""
    else:
        watch = Stopwatch()
        run.to(plan.scene.duration, lambda simulation, _: watch.stepped(simulation))
        watch.stop(run.simulation)
        spent, wall, cpu = watch.phases()
        ratio = expected.a_step / sum(shares(spent, wall, cpu, watch.steps).values())
        ratios = f"{ratio:.2f} a step, "
    taken = min(perf_counter() - clock, process_time() - processor)
    in_all = expected.seconds / taken
    print(f"{path.stem}: {taken:.2f} s; expected over taken: {ratios}{in_all:.2f} in all")
    assert 1.0 / 3.0 <= in_all <= 3.0
    assert not ratios or 1.0 / 1.5 <= float(ratios.split()[0]) <= 1.5
