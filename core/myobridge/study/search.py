"""Search: the cheapest variant that is good enough, without running those that cannot be it.

The variants are run in the order of their expected cost. One that is good enough bounds the time of all that follow: a
run that exceeds it is given up, and a variant of the same family that is finer in every key than one which already took
longer is not begun. No variant is left out because a coarser one was bad, for errors may cancel.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from myobridge.errors import MyobridgeError
from myobridge.plan import Plan
from myobridge.study.bench import Bench
from myobridge.study.judgement import Judge
from myobridge.study.levels import Levels
from myobridge.study.measurement import Measurement
from myobridge.study.progress import weight
from myobridge.study.rows import Row
from myobridge.study.variants import Variant

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["searched"]

# A reference that is off by this share of the tolerance decides nothing wrongly that matters.
_SHARE = 0.25
_MOST_LEVELS = 8
# Runs are given up, and not begun, only where they cost this much more than the best: times are noisy, short ones most.
_MARGIN, _NOISE = 1.2, 0.05
# Those within this factor of the best are timed again, side by side.
_CONTENDERS = 2.0


def searched(study: Study, bench: Bench, levels: Levels) -> tuple[Judge, list[Row]]:
    """Rows of all variants, those that were left out with the reason, and the judge that knows the standards."""
    tolerance = study.tolerance
    if tolerance is None:
        raise MyobridgeError("study.tolerance: is missing; a search needs to know what is good enough")
    judge = Judge(study, levels)
    for model in levels.models():
        _learn(judge, bench, levels, model, tolerance)
    found: dict[int, list[Measurement]] = {}
    left_out: dict[int, str] = {}
    order = sorted(range(len(study.variants)), key=lambda number: _expected(study, study.variants[number]))
    best = float("inf")
    while order:
        wave: list[int] = []
        while order and len(wave) < bench.crew.size:
            number = order.pop(0)
            dearer = _dearer(study, number, found, _limit(best))
            if dearer:
                left_out[number] = dearer
            else:
                wave.append(number)
        if not wave:
            break
        jobs = [(study.scene_of(study.variants[number].settings), 0) for number in wave]
        for number, measurement in zip(wave, bench.run(jobs, _limit(best)), strict=True):
            found[number] = [measurement]
        for number in wave:
            if _good(judge, study.variants[number], found[number][0], tolerance):
                best = min(best, found[number][0].cpu)
    _time_again(study, bench, judge, found, best, tolerance)
    rows: list[Row] = []
    for number, variant in enumerate(study.variants):
        if number in found:
            rows.append(judge.row(variant, found[number]))
        else:
            rows.append(Row(variant=variant, reason=left_out[number]))
    return judge, rows


def _limit(best: float) -> float:
    """CPU time beyond which a run cannot be the best [s]."""
    return _MARGIN * best + _NOISE


def _learn(judge: Judge, bench: Bench, levels: Levels, model: str, tolerance: float) -> None:
    """Fine runs of a model, more of them until the finest is good enough to judge by."""
    runs = bench.run([(levels.scene(model, level), 0) for level in range(levels.count)])
    known = judge.learn(model, runs)
    while known is not None and known.error > _SHARE * tolerance and len(runs) < _MOST_LEVELS:
        finer = bench.run([(levels.scene(model, len(runs)), 0)])
        if finer[0].failure:  # bins, say, have a limit: what is known remains, with its error
            break
        runs += finer
        known = judge.learn(model, runs)


def _time_again(
    study: Study, bench: Bench, judge: Judge, found: dict[int, list[Measurement]], best: float, tolerance: float
) -> None:
    """Time those that may be the best once more and more, in rounds."""
    again = [
        number
        for number, (first,) in found.items()
        if first.cpu <= max(_CONTENDERS * best, _limit(best)) and _good(judge, study.variants[number], first, tolerance)
    ]
    jobs = [
        (study.scene_of(study.variants[number].settings), repeat)
        for repeat in range(1, study.repeats)
        for number in again
    ]
    for place, measurement in enumerate(bench.run(jobs)):
        found[again[place % len(again)]].append(measurement)


def _good(judge: Judge, variant: Variant, measurement: Measurement, tolerance: float) -> bool:
    if measurement.failure or measurement.stopped or measurement.course is None:
        return False
    return judge.errors(variant, measurement.course).get("error", float("inf")) + judge.doubt <= tolerance


def _dearer(study: Study, number: int, found: Mapping[int, list[Measurement]], limit: float) -> str:
    """Why a variant cannot win; empty where it can."""
    variant = study.variants[number]
    for other, (first, *_) in found.items():
        coarser = study.variants[other]
        if first.cpu > limit and not first.failure and _finer(variant, coarser):
            return "finer than one that already costs more than another which is good enough"
    return ""


def _finer(variant: Variant, other: Variant) -> bool:
    """Whether a variant is finer than another of its family, or as fine, in every key."""
    if variant.family != other.family or variant.settings.keys() != other.settings.keys():
        return False
    return all(_at_least(key, variant.settings[key], other.settings[key]) for key in variant.settings)


def _at_least(key: str, value: Any, other: Any) -> bool:
    if isinstance(value, list | tuple):
        return len(value) == len(other) and all(mine >= yours for mine, yours in zip(value, other, strict=True))
    if isinstance(value, str | bool):
        return value == other
    return value <= other if key in ("scene.step", "scene.tolerance") else value >= other


def _expected(study: Study, variant: Variant) -> float:
    """Rough cost, for the order alone."""
    try:
        scene = study.scene_of(variant.settings)
        sizes = Plan.of(scene).sizes()
    except MyobridgeError:
        return 0.0
    return weight(scene.duration / scene.step, sizes["unknowns"], sizes["sites"] * sizes.get("values a site", 0))
