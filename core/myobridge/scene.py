"""Scene: what is simulated, as frozen data; TOML for people, the same classes for Python.

A scene only says what should be; `myobridge.plan` builds it and finds what does not go together.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import attrs

from myobridge.effects import EFFECTS, FAMILY_OF_SECTION
from myobridge.errors import ParameterError, SceneError, nearest
from myobridge.location import Origin
from myobridge.parameters import declared, number, text
from myobridge.recording import Record
from myobridge.registry import registry

__all__ = ["Scene"]

Table = Mapping[str, Any]


def _freeze(value: Any, key: str) -> Any:
    """Frozen copy of plain data; `key` is for the message where it is not plain."""
    if isinstance(value, Mapping):
        # None says "not given", as a key that is not there.
        items = {str(name): item for name, item in value.items() if item is not None}
        return MappingProxyType({name: _freeze(item, f"{key}.{name}") for name, item in items.items()})
    if hasattr(value, "tolist"):  # arrays and scalars of numpy
        value = value.tolist()
    if isinstance(value, list | tuple):
        return tuple(_freeze(item, f"{key}[{index}]") for index, item in enumerate(value))
    if isinstance(value, str | int | float):
        return value
    raise ParameterError(
        key,
        f"is {value!r}; a scene is plain data: text, numbers, true or false, lists and tables. "
        "Plugins that are built already go into mb.Simulation",
    )


def _thaw(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _thaw(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_thaw(item) for item in value]
    return value


def _table(value: Any, _self: Any, field: attrs.Attribute[Any]) -> Table | None:
    if value is None:
        return None
    if isinstance(value, str):
        value = {"plugin": value}
    if not isinstance(value, Mapping):
        raise ParameterError(field.name, f"is {value!r}; expected a table naming a plugin")
    return _freeze(value, field.name)


def _effects(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list | tuple) or not all(isinstance(item, str) for item in value):
        raise ParameterError("effects", f"is {value!r}; expected a list of names. {nearest('', EFFECTS)}")
    for index, item in enumerate(value):
        if item in value[:index]:
            raise ParameterError(f"effects[{index}]", f"names '{item}' a second time; once is enough")
    return tuple(value)


def _section(required: bool = False) -> Any:
    converter = attrs.Converter(_table, takes_self=True, takes_field=True)  # pyright: ignore[reportCallIssue]
    return attrs.field(default=attrs.NOTHING if required else None, converter=converter)


@attrs.frozen(kw_only=True)
class Scene:
    """Frozen description of a simulation.

    Parameters
    ----------
    name : str
    effects : sequence of str
        Phenomena called for; nothing else is computed.
    duration, step : float
        Simulated time and nominal step [s].
    solid : mapping
        ``plugin`` and its parameters; likewise `cross_bridges`, `activation`, `calcium`, `sarcomere_density`,
        `integrator` and `coupling`, which may be left out.
    record : Record or mapping
        What is kept.
    folder : Path, optional
        Where files named in the scene are looked for; not part of the description.
    origin : Origin, optional
        Where it was written, for messages; not part of the description.
    """

    name: str = text("scene", doc="name of the scene")
    duration: float = number(unit="s", within="(0, inf)", doc="simulated time")
    step: float = number(unit="s", within="(0, inf)", doc="nominal step")
    effects: tuple[str, ...] = attrs.field(default=(), converter=_effects)
    solid: Table = _section(required=True)
    cross_bridges: Table | None = _section()
    activation: Table | None = _section()
    calcium: Table | None = _section()
    sarcomere_density: Table | None = _section()
    integrator: Table | None = _section()
    coupling: Table | None = _section()
    record: Record = attrs.field(factory=Record, converter=lambda value: _record(value))
    folder: Path | None = attrs.field(default=None, eq=False, repr=False)
    origin: Origin = attrs.field(factory=Origin, eq=False, repr=False)

    @classmethod
    def load(cls, path: str | os.PathLike[str], settings: Mapping[str, Any] | None = None) -> Scene:
        """Read a scene from a TOML file; `settings` override keys, dotted (``solid.stiffness``).

        Raises
        ------
        SceneError
            With file, line and key, what is allowed and the nearest match.
        """
        source = Path(path)
        try:
            written = source.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise SceneError(f"{source}: cannot be read ({error.strerror})") from None
        except UnicodeDecodeError:
            raise SceneError(f"{source}: is not a text file in UTF-8") from None
        return cls.from_toml(written, folder=source.parent, source=str(source), settings=settings)

    @classmethod
    def from_toml(
        cls, written: str, *, folder: Path | None = None, source: str = "", settings: Mapping[str, Any] | None = None
    ) -> Scene:
        """Scene from the text of a TOML file."""
        try:
            data = tomllib.loads(written)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{source or 'scene'}: is not valid TOML: {error}") from None
        return cls._from_data(data, folder, Origin(source, written), settings or {})

    @classmethod
    def _from_data(
        cls, data: dict[str, Any], folder: Path | None, origin: Origin, settings: Mapping[str, Any]
    ) -> Scene:
        origin = attrs.evolve(origin, settings=(*origin.settings, *settings))
        for key, value in settings.items():
            try:
                _override(data, key, value)
            except ParameterError as error:
                raise SceneError(f"{origin.of(key)}{error.key}: {error.problem}") from None
        try:
            return cls(**_fields(data), folder=folder, origin=origin)
        except ParameterError as error:
            top = error.key.split(".")[0].split("[")[0]
            key = f"scene.{error.key}" if top in _HEAD else error.key
            raise SceneError(f"{origin.of(key)}{key}: {error.problem}") from None

    def to_data(self) -> dict[str, Any]:
        """Plain nested data, as in the TOML file."""
        data: dict[str, Any] = {"scene": {key: _thaw(getattr(self, key)) for key in _HEAD}}
        for key in _SECTIONS:
            value = getattr(self, key)
            if key == "record":
                standard = Record()
                fields = {item.name: getattr(value, item.name) for item in attrs.fields(Record)}
                value = {name: item for name, item in fields.items() if item != getattr(standard, name)} or None
            if value is not None:
                data[key] = _thaw(value)
        return data

    def to_toml(self) -> str:
        """The scene as TOML; reading it gives an equal scene."""
        import tomli_w

        return tomli_w.dumps(self.to_data())

    def with_settings(self, settings: Mapping[str, Any]) -> Scene:
        """The same scene with some keys set, dotted as in ``--set``."""
        return Scene._from_data(self.to_data(), self.folder, self.origin, settings)


_HEAD = ("name", "duration", "step", "effects")
_SECTIONS = (
    "solid",
    "cross_bridges",
    "activation",
    "calcium",
    "sarcomere_density",
    "integrator",
    "coupling",
    "record",
)


def _fields(data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Scene` from nested data; every table and key is a known one, and what must be there is there."""
    for key, value in data.items():
        if key != "scene" and key not in _SECTIONS:
            raise ParameterError(key, f"is no section. {nearest(key, ['scene', *_SECTIONS])}")
        if not isinstance(value, Mapping):
            raise ParameterError(key, f"is {value!r}; expected a table, [{key}]")
    head = dict(data.get("scene", {}))
    for key in head:
        if key not in _HEAD:
            raise ParameterError(f"scene.{key}", f"is unknown. {nearest(key, _HEAD)}")
    for key in ("duration", "step"):
        if key not in head:
            raise ParameterError(f"scene.{key}", "is missing; expected a number in (0, inf) [s]")
    if "solid" not in data:
        raise ParameterError("solid", "is missing; a scene needs a [solid] with a plugin")
    return head | {key: data[key] for key in _SECTIONS if key in data}


def _record(value: Any) -> Record:
    if isinstance(value, Record):
        return value
    if not isinstance(value, Mapping):
        raise ParameterError("record", f"is {value!r}; expected a table")
    allowed = [*declared(Record), "quantities", "sites", "fields"]
    for key in value:
        if key not in allowed:
            raise ParameterError(f"record.{key}", f"is unknown. {nearest(key, allowed)}")
    try:
        return Record(**value)
    except ParameterError as error:
        raise ParameterError(f"record.{error.key}", error.problem) from None


def _override(data: dict[str, Any], key: str, value: Any) -> None:
    """Set a dotted key; tables on the way are made."""
    first, *rest = key.split(".")
    if not rest:
        allowed = [f"{section}." for section in ("scene", *_SECTIONS)]
        raise ParameterError(key, f"cannot be set: expected SECTION.KEY=VALUE. {nearest(key + '.', allowed)}")
    table: Any = data
    for name in (first, *rest[:-1]):
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise ParameterError(key, f"cannot be set: '{name}' is {table!r}, no table")
    table[rest[-1]] = value
    family = _family(data, first, rest[:-1]) if rest[-1] == "plugin" and isinstance(value, str) else ""
    if family and value in registry().names(family):
        # Another plugin: what both know (p_max, rates) stays, what only the old one knew goes.
        known = {"plugin", "parameters", *declared(registry().find(family, value).cls)}
        for name in set(table) - known:
            del table[name]


def _family(data: Mapping[str, Any], section: str, inner: Sequence[str]) -> str:
    """Family of the plugin that the table `section`, or a part within it, names; empty where none is known."""
    family, table = FAMILY_OF_SECTION.get(section, ""), data.get(section, {})
    for name in inner:
        plugin = table.get("plugin", "") if isinstance(table, Mapping) else ""
        if not family or plugin not in registry().names(family):
            return ""
        item = declared(registry().find(family, plugin).cls).get(name)
        family = "" if item is None else item.family
        table = table.get(name, {})
    return family
