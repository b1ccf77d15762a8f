"""Scenes with one effect less, or one more: what the price list of effects compares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from myobridge.effects import FAMILY_OF_SECTION, LISTS_OF_SOLID, SECTIONS, known_effects
from myobridge.errors import MyobridgeError
from myobridge.parameters import declared
from myobridge.plan import Plan
from myobridge.registry import Registry, registry
from myobridge.scene import Scene

__all__ = ["added", "missing", "removed"]

# What cannot be there without cross-bridges, and what goes with inertia: the defaults of the new scene take its place.
_WITH = {
    "cross_bridges": ("activation", "calcium", "sarcomere_density", "coupling"),
    "inertia": ("integrator", "coupling"),
}


def removed(scene: Scene, effect: str) -> Scene:
    """The scene without an effect, and without what belongs to it alone.

    Raises
    ------
    MyobridgeError
        If nothing is left that could be simulated.
    """
    data = scene.to_data()
    gone = {effect, *(section for section in _WITH.get(effect, ()) if section in SECTIONS)}
    gone |= _orphans(scene, gone)
    data["scene"]["effects"] = [name for name in data["scene"]["effects"] if name not in gone]
    for section in (effect, *_WITH.get(effect, ())):
        data.pop(section, None)
    found = registry()
    for section, family in FAMILY_OF_SECTION.items():
        if section in data:
            data[section] = _without(found, family, data[section], effect)
    _strip_lists(found, data, effect)
    return _scene(scene, data)


def added(scene: Scene, effect: str) -> tuple[Scene, str]:
    """The scene with one effect more, and which plugin supplies it, with its defaults.

    Raises
    ------
    MyobridgeError
        If no installed plugin can supply it here.
    """
    data, found = scene.to_data(), registry()
    data["scene"]["effects"] = [*data["scene"]["effects"], effect]
    if effect == "inertia":
        data.pop("integrator", None)
        data.pop("coupling", None)
    problem = MyobridgeError(f"no installed plugin supplies '{effect}' here")
    if effect in SECTIONS:
        for name in found.names(SECTIONS[effect]):
            table: dict[str, Any] = {"plugin": name}
            try:
                made = _scene(scene, data | {effect: table})
                Plan.of(made).simulation()
            except MyobridgeError as error:
                problem = error
                continue
            return made, f"{effect} '{name}' with its defaults"
        raise problem
    made = _scene(scene, data)
    Plan.of(made).simulation()
    by = next((by for name, state, by in Plan.of(made).effects() if name == effect and state == "on"), "")
    return made, by


def missing(scene: Scene) -> list[str]:
    """Effects that the scene does not call for, and that are not inherent in it."""
    states = {name: state for name, state, _ in Plan.of(scene).effects()}
    return [name for name in known_effects(registry()) if states.get(name, "off") == "off"]


def _orphans(scene: Scene, gone: set[str]) -> set[str]:
    """Effects of the scene that are supplied by what goes, and by nothing else."""
    plan = Plan.of(scene)
    return {
        name
        for name, state, by in plan.effects()
        if state == "on" and by and all(item.partition(" ")[0] in gone & set(SECTIONS) for item in by.split(", "))
    }


def _scene(scene: Scene, data: Mapping[str, Any]) -> Scene:
    import tomli_w

    return Scene.from_toml(tomli_w.dumps(data), folder=scene.folder)


def _without(found: Registry, family: str, table: Mapping[str, Any], effect: str) -> dict[str, Any]:
    """A plugin's table without the parameters of an effect, parts of parts too."""
    plugin = table.get("plugin")
    if not isinstance(plugin, str) or plugin not in found.names(family):
        return dict(table)
    kept = dict(table)
    for key, item in declared(found.find(family, plugin).cls).items():
        if key not in kept:
            continue
        if item.effect == effect:
            del kept[key]
        elif item.kind == "part" and isinstance(kept[key], Mapping):
            kept[key] = _without(found, item.family, kept[key], effect)
        elif item.kind == "parts":
            kept[key] = [_without(found, item.family, entry, effect) for entry in kept[key]]
    return kept


def _strip_lists(found: Registry, data: dict[str, Any], effect: str) -> None:
    """Lists of the solid at the top of a scene: loads that are one of an effect's parameters go with it."""
    solid = declared(found.find("macro_solid", str(data["solid"]["plugin"])).cls)
    for name in LISTS_OF_SOLID:
        if name not in data:
            continue
        item = solid.get(name)
        if item is not None and item.effect == effect:
            del data[name]
        elif item is not None and item.kind == "parts":
            data[name] = [_without(found, item.family, dict(entry), effect) for entry in data[name]]
