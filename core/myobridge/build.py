"""Build a plugin from plain values: nested tables, parameter sets by name, effects on or off."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import attrs

from myobridge.errors import MyobridgeError, ParameterError, PluginError, nearest
from myobridge.hookspecs import FAMILIES
from myobridge.parameters import Declaration, declared
from myobridge.registry import Registry

__all__ = ["build"]


def build(
    registry: Registry,
    family: str,
    table: Mapping[str, Any],
    effects: Collection[str] | None = None,
    folder: Path | None = None,
) -> Any:
    """Instance of ``table["plugin"]`` with the other keys as parameters.

    Parameters
    ----------
    table : mapping
        ``plugin`` names the class, ``parameters`` a set of its ``parameter_sets``, the rest are parameters.
    effects : collection of str, optional
        Effects that the scene calls for. A parameter of an effect that is not called for is an error, one of an
        effect that is called for but not set takes its `on` value. None: parameters decide alone.
    folder : Path, optional
        Folder against which parameters of kind "file" are read.

    Raises
    ------
    ParameterError
        Naming the key, what is allowed and the nearest match; also when the plugin's own code raises.
    """
    values = dict(table)
    if "plugin" not in values:
        raise ParameterError("plugin", f"is missing. {nearest('', registry.names(family))}")
    try:
        found = registry.find(family, str(values.pop("plugin")))
    except PluginError as error:
        raise ParameterError("plugin", str(error)) from None
    cls = found.cls
    values = {**_parameter_set(cls, values), **values}
    values = _filled(registry, cls, values, effects, folder, str(table["plugin"]))
    try:
        return cls(**values)
    except MyobridgeError:
        raise
    except Exception as error:  # a stranger's constructor may raise anything; say whose it was
        raise ParameterError(
            "plugin", f"'{found.name}' of package '{found.package}' cannot be built: {type(error).__name__}: {error}"
        ) from error


def _parameter_set(cls: type[Any], values: dict[str, Any]) -> Mapping[str, Any]:
    if "parameters" not in values or "parameters" in declared(cls):
        return {}
    name = values.pop("parameters")
    sets: Mapping[str, Mapping[str, Any]] = getattr(cls, "parameter_sets", {})
    if not isinstance(name, str) or name not in sets:
        raise ParameterError("parameters", f"has no set '{name}'. {nearest(str(name), sets)}")
    return sets[name]


def _apply_effects(said: Mapping[str, Declaration], values: dict[str, Any], effects: Collection[str]) -> None:
    for key, item in said.items():
        if not item.effect:
            continue
        if item.effect not in effects and key in values:
            raise ParameterError(
                key,
                f"belongs to the effect '{item.effect}', which the scene does not call for; add it to effects",
            )
        if item.effect in effects and key not in values and item.on is not None:
            values[key] = item.on


def _filled(
    registry: Registry,
    cls: type[Any],
    values: dict[str, Any],
    effects: Collection[str] | None,
    folder: Path | None,
    plugin: str = "",
) -> dict[str, Any]:
    """Values of the declared parameters of a class: known ones only, effects applied, parts built, none missing."""
    said = declared(cls)
    for key in values:
        if key not in said:
            whom, allowed = (f" to '{plugin}'", {*said, "plugin"}) if plugin else ("", set(said))
            raise ParameterError(key, f"is unknown{whom}. {nearest(key, allowed)}")
    if effects is not None:
        _apply_effects(said, values, effects)
    for key, item in said.items():
        if key in values:
            values[key] = _value(registry, key, item, values[key], effects, folder)
        elif _required(cls, key):
            needs = f"'{plugin}' needs" if plugin else "expected"
            raise ParameterError(key, f"is missing; {needs} {item.allowed()}: {item.doc}")
    return values


def _record(
    registry: Registry, cls: type[Any], table: Any, effects: Collection[str] | None, folder: Path | None
) -> Any:
    """Instance of a class of declared parameters that is no plugin."""
    if not isinstance(table, Mapping):
        raise ParameterError("", f"is {table!r}; expected a table with {', '.join(declared(cls))}")
    return cls(**_filled(registry, cls, dict(table), effects, folder))


def _item(
    registry: Registry, item: Declaration, value: Any, effects: Collection[str] | None, folder: Path | None
) -> Any:
    """One entry of a list of plugins or records."""
    if item.kind == "parts":
        return _value(registry, "", attrs.evolve(item, kind="part"), value, effects, folder)
    assert item.record is not None
    return value if isinstance(value, item.record) else _record(registry, item.record, value, effects, folder)


def _value(
    registry: Registry,
    key: str,
    item: Declaration,
    value: Any,
    effects: Collection[str] | None,
    folder: Path | None,
) -> Any:
    if item.kind == "part":
        table = {"plugin": value} if isinstance(value, str) else value
        if value is None or isinstance(value, FAMILIES[item.family].interface):
            return value
        if not isinstance(table, Mapping):
            raise ParameterError(key, f"is {value!r}; expected {item.allowed()}")
        try:
            return build(registry, item.family, table, effects, folder)
        except ParameterError as error:
            raise ParameterError(f"{key}.{error.key}", error.problem) from None
    if item.kind in ("parts", "records"):
        if not isinstance(value, list | tuple):
            raise ParameterError(key, f"is {value!r}; expected {item.allowed()}")
        built = []
        for index, entry in enumerate(value):
            try:
                built.append(_item(registry, item, entry, effects, folder))
            except ParameterError as error:
                inner = error.key.strip(".")
                raise ParameterError(f"{key}[{index}]" + (f".{inner}" if inner else ""), error.problem) from None
        return tuple(built)
    if item.kind == "file" and isinstance(value, str) and folder is not None:
        return str(folder / value)
    return value


def _required(cls: type[Any], key: str) -> bool:
    return getattr(attrs.fields_dict(cls)[key], "default", None) is attrs.NOTHING
