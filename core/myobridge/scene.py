"""Scene: what is simulated, as frozen data; TOML for people, the same classes for Python.

A scene only says what should be; `myobridge.plan` builds it and finds what does not go together.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import attrs

from myobridge.effects import EFFECTS, FAMILY_OF_SECTION
from myobridge.errors import ParameterError, SceneError, nearest
from myobridge.parameters import declared, number, text
from myobridge.recording import Record
from myobridge.registry import registry

__all__ = ["Scene", "locate"]

Table = Mapping[str, Any]


def _freeze(value: Any) -> Any:
    if isinstance(value, Mapping):
        return MappingProxyType({str(key): _freeze(item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return tuple(_freeze(item) for item in value)
    if hasattr(value, "item") and not hasattr(value, "__len__"):
        return value.item()
    return value


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
    return _freeze(value)


def _effects(value: Any) -> tuple[str, ...]:
    if isinstance(value, str) or not all(isinstance(item, str) for item in value):
        raise ParameterError("effects", f"is {value!r}; expected a list of names. {nearest('', EFFECTS)}")
    if len(set(value)) < len(value):
        raise ParameterError("effects", f"names an effect twice: {', '.join(value)}")
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
    source: str = attrs.field(default="", eq=False, repr=False)

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
            written = source.read_text(encoding="utf-8")
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
        try:
            for key, value in (settings or {}).items():
                _override(data, key, value)
            return cls._from_data(data, folder, source)
        except ParameterError as error:
            raise SceneError(f"{locate(source, written, error.key)}{error.key}: {error.problem}") from None

    @classmethod
    def _from_data(cls, data: Mapping[str, Any], folder: Path | None, source: str) -> Scene:
        sections = [field.name for field in attrs.fields(cls) if field.name in _SECTIONS]
        for key, value in data.items():
            if key != "scene" and key not in sections:
                raise ParameterError(key, f"is no section. {nearest(key, ['scene', *sections])}")
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
        try:
            return cls(**head, **{key: data[key] for key in sections if key in data}, folder=folder, source=source)
        except ParameterError as error:
            prefix = "" if error.key.split(".")[0].split("[")[0] in sections else "scene."
            raise ParameterError(prefix + error.key, error.problem) from None

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
        data = self.to_data()
        try:
            for key, value in settings.items():
                _override(data, key, value)
            return Scene._from_data(data, self.folder, self.source)
        except ParameterError as error:
            raise SceneError(f"{error.key}: {error.problem}") from None


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


def _record(value: Any) -> Record:
    if isinstance(value, Record):
        return value
    allowed = [*declared(Record), "quantities", "sites"]
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
    table: Any = data.setdefault(first, {})
    for name in rest[:-1]:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            raise ParameterError(key, f"cannot be set: '{name}' is no table")
    table[rest[-1]] = value
    if key == f"{first}.plugin" and first in FAMILY_OF_SECTION and isinstance(value, str):
        # Another plugin: what both know (p_max, rates) stays, what only the old one knew goes.
        found = registry()
        if value in found.names(FAMILY_OF_SECTION[first]):
            known = {"plugin", "parameters", *declared(found.find(FAMILY_OF_SECTION[first], value).cls)}
            for name in set(table) - known:
                del table[name]


def locate(source: str, written: str, key: str) -> str:
    """Where `key` stands in a TOML text, as ``file:line: `` (the nearest enclosing table if it is not written)."""
    parts = [part.split("[")[0] for part in key.split(".")]
    best, table = 0, ""
    for number_, line in enumerate(written.splitlines(), start=1):
        bare = line.split("#")[0].strip()
        if bare.startswith("["):
            table = bare.strip("[] ").replace('"', "")
            if table == parts[0] and best == 0:
                best = number_
            continue
        name = bare.partition("=")[0].strip().strip('"')
        written_key = [*table.split("."), *name.split(".")]
        if name and written_key == parts[: len(written_key)] and len(written_key) > 1:
            best = number_
            break
    if not source:
        return ""
    return f"{source}:{best}: " if best else f"{source}: "
