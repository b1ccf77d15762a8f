"""Price list of effects: what each costs in time and work, and what it changes."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import final

import attrs
import numpy as np

from myobridge.effects import suppliers
from myobridge.errors import MyobridgeError, SceneError
from myobridge.plan import Plan
from myobridge.registry import registry
from myobridge.scene import Scene
from myobridge.study.bench import Bench, Job
from myobridge.study.crew import crew
from myobridge.study.measurement import Course, Measurement
from myobridge.study.norms import relative_error
from myobridge.study.progress import Watch
from myobridge.study.quantities import Quantity, usual
from myobridge.study.store import Store
from myobridge.study.without import added, missing, removed

__all__ = ["EffectPrice", "EffectPrices", "price_effects"]


@attrs.frozen(kw_only=True)
class EffectPrice:
    """What one effect costs and changes.

    Attributes
    ----------
    effect : str
    state : {"on", "off"}
        Whether the scene calls for it.
    seconds : float
        CPU time of the run with it minus that without it [s]; median over the rounds.
    share : float
        The same over the CPU time of the scene as it stands.
    change : float
        Largest relative difference of a quantity that both runs have, at any time.
    work : mapping
        The same difference in the counts of `myobridge.work.WORK`.
    said : str
        What supplies it, or why there is no price.
    """

    effect: str
    state: str
    seconds: float = math.nan
    share: float = math.nan
    change: float = math.nan
    work: Mapping[str, int] = attrs.field(factory=dict)
    said: str = ""


@final
@attrs.frozen(eq=False)
class EffectPrices:
    """Price list of a scene.

    Attributes
    ----------
    scene : Scene
    cpu : float
        CPU time of the scene as it stands [s].
    prices : tuple of EffectPrice
        Effects of the scene first, then the others.
    computed, kept : int
        Runs computed now, and runs that were kept from before.
    """

    scene: Scene
    cpu: float
    prices: tuple[EffectPrice, ...]
    computed: int = 0
    kept: int = 0


def price_effects(
    scene: Scene,
    folder: str | os.PathLike[str] | None = None,
    *,
    quantities: Sequence[Quantity | str] = (),
    repeats: int = 3,
    workers: int | None = None,
    scheduler: str | None = None,
    watch: Watch | None = None,
) -> EffectPrices:
    """Run a scene as it stands, without each of its effects, and with each that it does without.

    The runs are interleaved; what fails is in the list with its reason. The other parameters are those of `Study.run`.

    Raises
    ------
    MyobridgeError
        If the scene itself does not run, or is without time.
    """
    if scene.static:
        raise SceneError(f"{scene.origin.of('continuation')}continuation: effects are priced in scenes with time")
    read = tuple(map(Quantity.of, quantities)) or usual(Plan.of(scene).simulation())
    others, prices = _others(scene)
    jobs: list[Job] = [(one, number) for number in range(repeats) for one in (scene, *others.values())]
    with crew(workers, scheduler) as hands:
        bench = Bench(Store(folder), hands, read, (), watch, optional=True)
        answers = bench.run(jobs)
    rounds = [answers[place :: 1 + len(others)] for place in range(1 + len(others))]
    standing, *varied = rounds
    if standing[0].failure:
        raise MyobridgeError(f"the scene as it stands fails: {standing[0].failure}")
    for effect, runs in zip(others, varied, strict=True):
        prices[effect] = _priced(prices[effect], standing, runs)
    return EffectPrices(scene, _middle(standing), tuple(prices.values()), bench.computed, bench.found)


def _others(scene: Scene) -> tuple[dict[str, Scene], dict[str, EffectPrice]]:
    """Scenes to compare with, and a line for every effect, without its price."""
    scenes: dict[str, Scene] = {}
    prices: dict[str, EffectPrice] = {}
    supplied = {name: by for name, _, by in Plan.of(scene).effects()}
    for effect in scene.effects:
        said = f"by {supplied.get(effect, '')}"
        try:
            scenes[effect] = removed(scene, effect)
            Plan.of(scenes[effect]).simulation()
        except MyobridgeError as error:
            scenes.pop(effect, None)
            said = f"cannot be left out: {error}"
        prices[effect] = EffectPrice(effect=effect, state="on", said=said)
    for effect in missing(scene):
        try:
            scenes[effect], by = added(scene, effect)
            said = f"by {by}"
        except MyobridgeError:
            by = ", ".join(suppliers(registry(), effect)) or "no installed plugin"
            said = f"not with the plugins of this scene; supplied by {by}"
        prices[effect] = EffectPrice(effect=effect, state="off", said=said)
    return scenes, prices


def _middle(runs: Sequence[Measurement]) -> float:
    return float(np.median([one.cpu for one in runs]))


def _priced(price: EffectPrice, standing: Sequence[Measurement], varied: Sequence[Measurement]) -> EffectPrice:
    failed = next((one.failure for one in varied if one.failure), "")
    if failed:
        return attrs.evolve(price, said=f"{'without' if price.state == 'on' else 'with'} it: {failed}")
    sign = 1.0 if price.state == "on" else -1.0
    pairs = [sign * (one.cpu - other.cpu) for one, other in zip(standing, varied, strict=True)]
    work = {name: int(sign * (amount - varied[0].work[name])) for name, amount in standing[0].work.items()}
    seconds = float(np.median(pairs))
    return attrs.evolve(
        price,
        seconds=seconds,
        share=seconds / _middle(standing),
        change=_change(standing[0].course, varied[0].course),
        work={name: amount for name, amount in work.items() if amount},
    )


def _change(course: Course | None, other: Course | None) -> float:
    """Largest relative difference of what both have; a tension that nobody makes is none: the whole of it changes."""
    if course is None or other is None:
        return math.nan
    found = [
        relative_error(other.times, other.values[name], course.times, values, "max") if name in other.values else 1.0
        for name, values in course.values.items()
    ]
    return max(found)
