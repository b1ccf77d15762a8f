"""Levels: the scenes of the reference runs, model by model, each twice finer than the one before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, final

from myobridge.errors import MyobridgeError
from myobridge.plan import Plan
from myobridge.scene import Scene
from myobridge.study.reference import LEVELS
from myobridge.study.refinement import of_scene, refined
from myobridge.study.variants import matches

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["Levels"]


@final
class Levels:
    """Scenes of the reference runs.

    Attributes
    ----------
    reference_model : str
        Model whose solution is the truth.
    count : int
        Levels of each model.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self.count = LEVELS
        names = [variant.model for variant in study.variants]
        self._settings: dict[str, Mapping[str, Any]] = {}
        for variant in study.variants:
            own = {key: value for key, value in variant.settings.items() if not matches(key, study.numerical)}
            self._settings.setdefault(variant.model, own)
        self._settings.setdefault("", {})
        chosen = study.reference.model
        self.reference_model = chosen if chosen is not None else ("" if "" in names else self._first(names))
        self._starts: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {}

    def _first(self, names: list[str]) -> str:
        """The model that is the scene as it stands, said in other words, or else the first."""
        plain = self._study.scene_of({})
        for name in names:
            try:
                if self._study.scene_of(self._settings[name]) == plain:
                    return name
            except MyobridgeError:  # it will be a row with its reason
                continue
        return names[0]

    def models(self) -> list[str]:
        """Models that need fine runs: all that are varied, and the reference model; a closed form needs none."""
        wanted = dict.fromkeys([self.reference_model, *(variant.model for variant in self._study.variants)])
        closed = self._study.reference.closed_form is not None
        return [model for model in wanted if not (closed and model == self.reference_model)]

    def scene(self, model: str, level: int) -> Scene:
        """Scene of a reference run."""
        if model not in self._starts:
            self._starts[model] = self._start(model)
        fixed, start = self._starts[model]
        return self._study.scene_of({**fixed, **refined(start, level)})

    def _start(self, model: str) -> tuple[dict[str, Any], dict[str, Any]]:
        """What all levels set, and the values of the coarsest one that the finer ones refine."""
        study, own = self._study, dict(self._settings[model])
        values = of_scene(study.scene_of(own))
        if study.search:
            start = refined(values, -1, [key for key in values if key.startswith("solid.")])
        else:
            start = {key: self._finest(model, key, value) for key, value in values.items()}
        given = {key: value for key, value in study.reference.settings.items() if self._fits(own, key, value)}
        start |= given
        keys = study.reference.refine
        fixed = {key: value for key, value in start.items() if key not in (values if keys is None else keys)}
        return own | fixed, {key: value for key, value in start.items() if key not in fixed}

    def _finest(self, model: str, key: str, value: Any) -> Any:
        """Twice finer than the finest of the variants of a model; as the scene has it where none varies it."""
        given = [
            variant.settings[key]
            for variant in self._study.variants
            if variant.model == model and key in variant.settings and _comparable(variant.settings[key], value)
        ]
        if not given:
            return value
        finest = min(given) if isinstance(value, float) else max(given)
        return refined({key: finest}, 1)[key]

    def _fits(self, own: Mapping[str, Any], key: str, value: Any) -> bool:
        """Whether a key of the reference is one of this model too: moments have no bins."""
        try:
            Plan.of(self._study.scene_of({**own, key: value}))
        except MyobridgeError:
            return False
        return True


def _comparable(value: Any, other: Any) -> bool:
    return isinstance(value, list | tuple) == isinstance(other, list | tuple)
