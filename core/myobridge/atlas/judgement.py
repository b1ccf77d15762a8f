"""Judgement: try a cell, hold what was measured against what must hold and what is expected."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from time import process_time

from myobridge.atlas.catalogue import QUANTITIES
from myobridge.atlas.cell import Cell, Finding, unlike
from myobridge.atlas.largest_step import largest_step
from myobridge.atlas.methods import DEFAULT
from myobridge.atlas.trial import Trial, tried
from myobridge.errors import MyobridgeError
from myobridge.interfaces import Limit
from myobridge.scene import Scene

__all__ = ["found"]


def found(cell: Cell) -> Finding:
    """Try a cell."""
    started = process_time()
    case, expectation = cell.case, cell.expectation
    try:
        scene = cell.base.with_settings(cell.method.settings)
    except MyobridgeError as error:
        return _refused(cell, str(error), process_time() - started)
    predicted: dict[str, float] = {}
    trial = _tried(cell, scene, predicted)
    if trial.refused:
        return _refused(cell, trial.refused, process_time() - started)
    if case.refused_with:
        return Finding.of(
            cell, "fails", why="the scene was not refused", measured=trial.measured, seconds=process_time() - started
        )
    measured = dict(trial.measured)
    why = violations(trial, case.limits)
    step, beyond = None, False
    if ((cell.full and case.bisect) or "largest_step" in expectation.agrees) and not scene.static:
        step, beyond = largest_step(scene, lambda other: not violations(_tried(cell, other), case.limits), not why)
        if step is not None:
            measured["largest_step"] = step
    outcome = "fails" if why else "holds"
    surprises = [unlike(expectation, outcome), *_disagreements(expectation.agrees, measured, predicted)]
    return Finding.of(
        cell,
        outcome,
        why=why,
        surprise="; ".join(filter(None, surprises)),
        measured=measured,
        predicted={name: value for name, value in predicted.items() if name in expectation.agrees},
        largest_step=step,
        beyond=beyond,
        seconds=process_time() - started,
    )


def _refused(cell: Cell, message: str, seconds: float) -> Finding:
    wanted = cell.case.refused_with
    if wanted:
        good = wanted in message
        why = f"refused: {message}" if good else f"refused, but without the words '{wanted}': {message}"
        return Finding.of(cell, "holds" if good else "fails", why=why, seconds=seconds)
    # A method that does not go with the scene says so; the default must go with it.
    outcome = "fails" if cell.method.name == DEFAULT else "not applicable"
    return Finding.of(cell, outcome, why=message, seconds=seconds)


def _tried(cell: Cell, scene: Scene, predicted: dict[str, float] | None = None) -> Trial:
    case = cell.case
    try:
        measured = case.measured(scene)
    except MyobridgeError as error:
        return Trial(refused=str(error))
    if measured is not None:
        return Trial(measured=measured)
    wanted = {limit.quantity for limit in case.limits} | set(cell.expectation.agrees)
    allowed = min((limit.at_most for limit in case.limits if limit.quantity == "halvings"), default=math.inf)
    return tried(
        scene,
        wanted,
        halvings=allowed,
        seconds=case.seconds,
        fine=_reference(cell) if case.reference else None,
        inspect=None if predicted is None else lambda composed: predicted.update(case.predicted(composed)),
    )


def _reference(cell: Cell) -> Trial:
    wanted = tuple(sorted({limit.quantity for limit in cell.case.limits}))
    return _fine(cell.base.with_settings(cell.case.reference).to_toml(), wanted)


@lru_cache(maxsize=8)
def _fine(written: str, wanted: tuple[str, ...]) -> Trial:
    """The reference run of a variant, once for all its methods."""
    trial = tried(Scene.from_toml(written), wanted)
    if trial.refused or trial.stopped:
        raise MyobridgeError(f"the reference run failed: {trial.refused or trial.stopped}")
    return trial


def violations(trial: Trial, limits: tuple[Limit, ...]) -> str:
    """Everything that does not hold, in a sentence; empty where all does."""
    said = [trial.stopped or trial.refused]
    for limit in limits:
        if limit.quantity in trial.measured:
            problem = limit.violation(trial.measured[limit.quantity])
            # More halvings than allowed have ended the trial, and are said already.
            if problem and not (trial.stopped and limit.quantity == "halvings"):
                words, unit = QUANTITIES.get(limit.quantity, (limit.quantity.replace("_", " "), "-"))
                said.append(f"{words}{'' if unit == '-' else f' [{unit}]'} {problem}")
    return "; ".join(filter(None, said))


def _disagreements(
    agrees: Mapping[str, float], measured: Mapping[str, float], predicted: Mapping[str, float]
) -> list[str]:
    """Measured numbers that are further from the prediction than allowed."""
    said: list[str] = []
    for name, tolerance in agrees.items():
        if name not in measured or name not in predicted:
            said.append(f"{name} was {'not measured' if name not in measured else 'not predicted'}")
            continue
        value, theory = measured[name], predicted[name]
        if not abs(value - theory) <= tolerance * abs(theory):
            said.append(f"{name} is {value:.4g}, predicted is {theory:.4g} within {100.0 * tolerance:g} %")
    return said
