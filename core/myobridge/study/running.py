"""Running of a study: reference first, then the variants in rounds, so that their times can be compared."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import attrs

from myobridge.study.bench import Bench
from myobridge.study.checks import quantities_of
from myobridge.study.crew import crew
from myobridge.study.judgement import Judge
from myobridge.study.levels import Levels
from myobridge.study.progress import Watch
from myobridge.study.result import StudyResult
from myobridge.study.rows import Row
from myobridge.study.search import searched
from myobridge.study.store import Store

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["run"]


def run(
    study: Study,
    folder: str | os.PathLike[str] | None,
    *,
    workers: int | None,
    scheduler: str | None,
    watch: Watch | None,
) -> StudyResult:
    """Run a study; see `Study.run`."""
    quantities = quantities_of(study)
    study = attrs.evolve(study, quantities=quantities)
    store = Store(folder)
    with crew(workers, scheduler) as hands:
        bench = Bench(store, hands, quantities, study.at, watch)
        levels = Levels(study)
        if study.search:
            judge, rows = searched(study, bench, levels)
        else:
            judge, rows = _all(study, bench, levels)
    counts = bench.computed, bench.found, bench.cpu
    return StudyResult(study, tuple(rows), judge.standards, judge.failures, *counts, doubt=judge.doubt)


def _all(study: Study, bench: Bench, levels: Levels) -> tuple[Judge, list[Row]]:
    """Every variant, `repeats` times: first all of them once, then all once more, and so on."""
    models = levels.models()
    fine = [(levels.scene(model, level), 0) for model in models for level in range(levels.count)]
    scenes: dict[int, Any] = {}
    rows: dict[int, Row] = {}
    for number, variant in enumerate(study.variants):
        scenes[number] = study.scene_of(variant.settings)
    timed = [(scene, repeat) for repeat in range(study.repeats) for scene in scenes.values()]
    answers = bench.run([*fine, *timed])
    judge = Judge(study, levels)
    for index, model in enumerate(models):
        judge.learn(model, answers[index * levels.count : (index + 1) * levels.count])
    for place, (number, _) in enumerate(scenes.items()):
        mine = answers[len(fine) + place :: len(scenes)]
        rows[number] = judge.row(study.variants[number], mine)
    return judge, list(rows.values())
