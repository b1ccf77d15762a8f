"""What the plan of a scene needs beside its plugins: lists of the solid, and the parts of a scene without time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myobridge.effects import FIELDS_OF_SECTION, LISTS_OF_SOLID, NEED_TIME
from myobridge.errors import ParameterError
from myobridge.parameters import declared
from myobridge.registry import Registry
from myobridge.scaling import Scaling
from myobridge.scene import Scene
from myobridge.static_recording import check_static_record
from myobridge.statics import Statics

__all__ = ["check_effects", "composed_statics", "lists_given", "merged", "scaling_of"]


def lists_given(scene: Scene) -> dict[str, Any]:
    """Lists at the top of the scene that belong to its solid, by their names in the file."""
    lists = {name: getattr(scene, f"{name}s") for name in LISTS_OF_SOLID}
    return {name: entries for name, entries in lists.items() if entries}


def merged(scene: Scene, plugins: Registry) -> Mapping[str, Any]:
    """Table of the solid with the lists that belong to it.

    Raises
    ------
    ParameterError
        If the solid takes no such list, or has it in its own table too.
    """
    given = lists_given(scene)
    name = scene.solid.get("plugin")
    if not given or name not in plugins.names("macro_solid"):  # an unknown solid is said first
        return scene.solid
    said = declared(plugins.find("macro_solid", str(name)).cls)
    taken = {key for key, item in said.items() if item.kind in ("parts", "records")}
    for key in given:
        if key not in taken:
            listed = [item.name for item in plugins if item.family == "macro_solid" and _takes(item.cls, key)]
            others = f"Solids that do: {', '.join(listed)}." if listed else "No installed solid does."
            own = f" Its parameter solid.{key} is {said[key].allowed()}." if key in said else ""
            raise ParameterError(f"{key}[0]", f"the solid '{name}' takes no [[{key}]]. {others}{own}")
        if key in scene.solid:
            raise ParameterError(f"{key}[0]", f"is given, and so is solid.{key}; one list is enough")
    return {**scene.solid, **given}


def _takes(solid: type[Any], key: str) -> bool:
    item = declared(solid).get(key)
    return item is not None and item.kind in ("parts", "records")


def check_effects(scene: Scene) -> None:
    """A scene without time calls for no effect that would do nothing.

    Raises
    ------
    ParameterError
    """
    for index, effect in enumerate(scene.effects if scene.static else ()):
        if effect in NEED_TIME:
            raise ParameterError(
                f"scene.effects[{index}]",
                f"'{effect}' acts in time, and a scene with [continuation] has none; leave it out, or give a duration",
            )


def scaling_of(scene: Scene) -> Scaling | None:
    """What a scene without time raises.

    Raises
    ------
    ParameterError
    """
    if scene.continuation is None:
        return None
    own = {key: value for key, value in scene.continuation.items() if key in FIELDS_OF_SECTION["continuation"]}
    try:
        return Scaling(**own)
    except ParameterError as error:
        raise ParameterError(f"continuation.{error.key}", error.problem) from None


def composed_statics(scene: Scene, scaling: Scaling, parts: Mapping[str, Any]) -> Statics:
    """Statics of the parts, with a record that goes with them.

    Raises
    ------
    MyobridgeError
        If the parts do not go together.
    """
    statics = Statics(**parts, of=scaling.of, to=scaling.to, report=scaling.report)
    try:
        check_static_record(scene.record, statics)
    except ParameterError as error:
        raise ParameterError(f"record.{error.key}", error.problem) from None
    return statics
