"""Checks of a study before anything is run: its keys, its quantities, that its scene has time."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from myobridge.errors import MyobridgeError, ParameterError, SceneError
from myobridge.plan import Plan
from myobridge.study.quantities import Quantity, reader, usual

if TYPE_CHECKING:
    from myobridge.study.study import Study

__all__ = ["check", "quantities_of"]

# How the scene and its plugins say that a key leads nowhere; other complaints are about the variant alone.
_NO_SUCH_KEY = re.compile(r"is unknown|cannot be set|is no section|there is no effect|Unknown")


def check(study: Study) -> None:
    """Look for what would fail in every run.

    Raises
    ------
    MyobridgeError
        If a key is misspelt, a quantity does not exist, or the scene has no time.
    """
    if study.scene.static:
        raise SceneError(
            f"{study.scene.origin.of('continuation')}continuation: the scene is without time, and a study compares "
            "runs through time; give a scene with duration and step"
        )
    for key, value in (("settings", study.settings), ("reference.settings", study.reference.settings)):
        try:
            Plan.of(study.scene_of(value))
        except MyobridgeError as error:
            raise ParameterError(key, _bare(error)) from None
    for variant in study.variants:
        try:
            Plan.of(study.scene_of(variant.settings))
        except MyobridgeError as error:
            if _NO_SUCH_KEY.search(str(error)):
                raise ParameterError("vary", _bare(error)) from None
    for number, time in enumerate(study.at):
        if isinstance(time, bool) or not isinstance(time, int | float) or not 0.0 < time <= study.scene.duration:
            raise ParameterError(f"at[{number}]", f"is {time!r}; expected a time in (0, {study.scene.duration:g}] [s]")
    models = {variant.model for variant in study.variants}
    if study.reference.model is not None and study.reference.model not in models | {""}:
        raise ParameterError(
            "reference.model", f"is '{study.reference.model}'; the variants have: {', '.join(sorted(models))}"
        )
    quantities_of(study)


def quantities_of(study: Study) -> tuple[Quantity, ...]:
    """Quantities of the study, the usual ones where it names none.

    Raises
    ------
    MyobridgeError
        If one of them does not exist in its scene.
    """
    simulation = Plan.of(study.scene_of({})).simulation()
    quantities = study.quantities or usual(simulation)
    for quantity in quantities:
        try:
            reader(quantity, simulation)
        except MyobridgeError as error:
            key, _, problem = str(error).partition(": ")
            raise ParameterError(key, problem) from None
    return quantities


def _bare(error: MyobridgeError) -> str:
    """Message without the place in the scene's file, which is not where the key of a study stands."""
    return re.sub(r"^.*?--set ", "", str(error))
