"""Methods that are tried on a case: the default, every installed plugin of the varied sections, and further ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import attrs

from myobridge.effects import FAMILY_OF_SECTION
from myobridge.errors import MyobridgeError
from myobridge.interfaces import StabilityCase
from myobridge.parameters import declared
from myobridge.plan import Plan
from myobridge.registry import Registry
from myobridge.scene import Scene

__all__ = ["DEFAULT", "Method", "methods_of"]

DEFAULT = "default"


@attrs.frozen
class Method:
    """What is exchanged in the scene of a case.

    Attributes
    ----------
    axis : str
        Section or key that is exchanged; "default" where none is.
    name : str
    settings : mapping
        On top of the scene, dotted.
    also : tuple of str
        Other names: of the default, the plugins that the scene takes.
    """

    axis: str
    name: str
    settings: Mapping[str, Any]
    also: tuple[str, ...] = ()


def methods_of(case: StabilityCase, scene: Scene, plugins: Registry) -> list[Method]:
    """The methods to try on a scene of a case, the default first; each of them once.

    Whether they go with the scene is found when they are tried.
    """
    try:
        plan: Plan | None = Plan.of(scene, plugins)
    except MyobridgeError:  # it is said when the default is tried
        plan = None
    names = {} if plan is None else dict(plan.names)
    taken = tuple(names[axis] for axis in case.vary if axis in names)
    found = [Method(DEFAULT, DEFAULT, {}, taken)]
    for axis in case.vary:
        if axis in FAMILY_OF_SECTION:
            others = (name for name in _fitting(axis, scene, plugins) if name != names.get(axis))
            found += [Method(axis, name, {f"{axis}.plugin": name}) for name in others]
        else:
            found += [Method(axis, value, {axis: value}) for value in _choices(plan, axis)]
    found += [Method(_axis(case, settings), name, settings) for name, settings in case.methods.items()]
    return found


def _axis(case: StabilityCase, settings: Mapping[str, Any]) -> str:
    """What settings exchange: a varied section or key, else the section of the first of them."""
    sections = [key.split(".")[0] for key in settings]
    return next((axis for axis in case.vary for section in sections if axis.split(".")[0] == section), sections[0])


def _fitting(axis: str, scene: Scene, plugins: Registry) -> Iterator[str]:
    """Plugins of a section that could stand in the scene."""
    for name in plugins.names(FAMILY_OF_SECTION[axis]):
        cls = plugins.find(FAMILY_OF_SECTION[axis], name).cls
        if axis == "integrator" and cls.inertia != ("inertia" in scene.effects):
            continue
        yield name


def _choices(plan: Plan | None, key: str) -> Iterator[str]:
    """Values of a choice other than the one that the plan has; none where there is no such choice."""
    section, *names, last = key.split(".")
    part = None if plan is None else plan.parts.get(section)
    for name in names:
        part = getattr(part, name, None)
    item = declared(type(part)).get(last)
    if item is not None and item.kind == "choice":
        yield from (value for value in item.choices if value != getattr(part, last))
