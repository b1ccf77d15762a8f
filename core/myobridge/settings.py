"""Settings: keys of a scene that are set on top of its file, dotted, with indices where a list is meant."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from myobridge.effects import FAMILY_OF_SECTION, FIELDS_OF_SECTION
from myobridge.errors import ParameterError, nearest
from myobridge.parameters import declared
from myobridge.registry import registry

__all__ = ["normalised", "override"]


def normalised(key: str) -> str:
    """The key with its indices in brackets: ``load.0.boundary`` is ``load[0].boundary``."""
    return re.sub(r"\.(\d+)(?=\.|\[|$)", r"[\1]", key)


def override(data: dict[str, Any], key: str, value: Any, sections: Sequence[str]) -> None:
    """Set a dotted key in nested data; tables on the way are made, entries of lists must be there.

    Raises
    ------
    ParameterError
        If the key leads to nothing that can be set.
    """
    first, *rest = _steps(key)
    if not rest or not isinstance(first, str):
        allowed = [f"{section}." for section in ("scene", *sections)]
        raise ParameterError(key, f"cannot be set: expected SECTION.KEY=VALUE. {nearest(key + '.', allowed)}")
    holder: Any = data
    for step, following in zip((first, *rest[:-1]), rest, strict=True):
        holder = _inside(key, holder, step, following)
    last = rest[-1]
    _check_entry(key, holder, last)
    holder[last] = value
    family = _family(data, first, rest[:-1]) if last == "plugin" and isinstance(value, str) else ""
    if family and value in registry().names(family):
        # Another plugin: what both know (p_max, rates) stays, what only the old one knew goes.
        known = {"plugin", "parameters", *declared(registry().find(family, value).cls)}
        if len(rest) == 1:
            known |= FIELDS_OF_SECTION.get(first, frozenset())
        for name in set(holder) - known:
            del holder[name]


def _steps(key: str) -> list[str | int]:
    """Names and indices on the way."""
    steps: list[str | int] = []
    for part in normalised(key).split("."):
        name, *indices = part.split("[")
        steps += [name, *(int(index[:-1]) if index[:-1].isdigit() else index for index in indices)]
    return steps


def _inside(key: str, holder: Any, step: str | int, following: str | int) -> Any:
    """What stands at a step of the way."""
    _check_entry(key, holder, step)
    holder = holder.setdefault(step, {}) if isinstance(holder, dict) else holder[step]
    if not isinstance(holder, list if isinstance(following, int) else dict):
        kind = "list" if isinstance(following, int) else "table"
        raise ParameterError(key, f"cannot be set: '{step}' is {holder!r}, no {kind}")
    return holder


def _check_entry(key: str, holder: Any, step: str | int) -> None:
    if isinstance(holder, list) and not (isinstance(step, int) and step < len(holder)):
        raise ParameterError(
            key, f"cannot be set: there are {len(holder)} entries, counted from 0, and none is '{step}'"
        )


def _family(data: Mapping[str, Any], section: str, inner: Sequence[str | int]) -> str:
    """Family of the plugin that the table `section`, or a part within it, names; empty where none is known."""
    family, table = FAMILY_OF_SECTION.get(section, ""), data.get(section, {})
    if isinstance(table, list):  # a list of the solid: its declaration knows the family
        return _family({**data, "solid": {**data.get("solid", {}), section: table}}, "solid", (section, *inner))
    for name in inner:
        if isinstance(name, int):
            table = table[name]
            continue
        plugin = table.get("plugin", "") if isinstance(table, Mapping) else ""
        if not family or plugin not in registry().names(family):
            return ""
        item = declared(registry().find(family, plugin).cls).get(name)
        family = "" if item is None else item.family
        table = table.get(name, {})
    return family
