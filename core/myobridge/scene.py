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

from myobridge.effects import EFFECTS, LISTS_OF_SOLID
from myobridge.errors import ParameterError, SceneError, nearest
from myobridge.location import Origin
from myobridge.parameters import choice, declared, number, text
from myobridge.recording import Record
from myobridge.settings import normalised, override
from myobridge.starts import STARTS

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


def _tables(value: Any, _self: Any, field: attrs.Attribute[Any]) -> tuple[Table, ...]:
    key = field.name.removesuffix("s")
    if not isinstance(value, list | tuple):
        raise ParameterError(key, f"is {value!r}; expected a list of tables, [[{key}]]")
    for index, item in enumerate(value):
        if not isinstance(item, Mapping):
            raise ParameterError(f"{key}[{index}]", f"is {item!r}; expected a table")
    return _freeze(value, key)


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


def _list() -> Any:
    converter = attrs.Converter(_tables, takes_self=True, takes_field=True)  # pyright: ignore[reportCallIssue]
    return attrs.field(default=(), converter=converter)


@attrs.frozen(kw_only=True)
class Scene:
    """Frozen description of a simulation.

    Parameters
    ----------
    name : str
    effects : sequence of str
        Phenomena called for; nothing else is computed.
    duration, step : float
        Simulated time and nominal step [s]; not given in a scene without time.
    tolerance : float, optional
        Largest estimated error of a displacement in one step [m]; the nominal step is the longest then.
    start : {"as_given", "projected", "equilibrium"}, optional
        Where it begins, see `myobridge.starts`; as given without.
    solid : mapping
        ``plugin`` and its parameters; likewise `cross_bridges`, `activation`, `calcium`, `sarcomere_density`,
        `integrator` and `coupling`, which may be left out.
    loads, supports, regions : sequence of mapping
        Lists ``[[load]]``, ``[[support]]``, ``[[region]]``, which belong to the solid, where it declares them.
    continuation : mapping, optional
        Makes a scene without time: ``plugin`` and the parameters of the strategy, and those of
        `myobridge.scaling.Scaling`, which say what is raised and how far.
    record : Record or mapping
        What is kept.
    folder : Path, optional
        Where files named in the scene are looked for; not part of the description.
    origin : Origin, optional
        Where it was written, for messages; not part of the description.
    """

    name: str = text("scene", doc="name of the scene")
    duration: float = number(None, unit="s", within="(0, inf)", doc="simulated time")
    step: float = number(None, unit="s", within="(0, inf)", doc="nominal step")
    tolerance: float | None = number(
        None, unit="m", within="(0, inf)", doc="largest error of a step, else it is halved; without, no control"
    )
    start: str | None = choice(None, STARTS, doc="where it begins; as the solid has it when left out")
    effects: tuple[str, ...] = attrs.field(default=(), converter=_effects)
    solid: Table = _section(required=True)
    loads: tuple[Table, ...] = _list()
    supports: tuple[Table, ...] = _list()
    regions: tuple[Table, ...] = _list()
    cross_bridges: Table | None = _section()
    activation: Table | None = _section()
    calcium: Table | None = _section()
    sarcomere_density: Table | None = _section()
    integrator: Table | None = _section()
    coupling: Table | None = _section()
    continuation: Table | None = _section()
    record: Record = attrs.field(factory=Record, converter=lambda value: _record(value))
    folder: Path | None = attrs.field(default=None, eq=False, repr=False)
    origin: Origin = attrs.field(factory=Origin, eq=False, repr=False)

    def __attrs_post_init__(self) -> None:
        for key in ("duration", "step"):
            given = getattr(self, key) is not None
            if self.static and given:
                raise ParameterError(
                    key, "is given, and [continuation] makes a scene without time; leave out duration and step, or that"
                )
            if not self.static and not given:
                raise ParameterError(
                    key, "is missing; expected a number in (0, inf) [s], or a [continuation] for a scene without time"
                )
        for key in ("integrator", "coupling", "tolerance", "start"):
            if self.static and getattr(self, key) is not None:
                raise ParameterError(key, "steps through time, and a scene with [continuation] has none; leave it out")

    @property
    def static(self) -> bool:
        """Whether the scene is without time."""
        return self.continuation is not None

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
        origin = attrs.evolve(origin, settings=(*origin.settings, *map(normalised, settings)))
        for key, value in settings.items():
            try:
                override(data, key, value, _SECTIONS)
            except ParameterError as error:
                raise SceneError(f"{origin.of(normalised(key))}{error.key}: {error.problem}") from None
        try:
            return cls(**_fields(data), folder=folder, origin=origin)
        except ParameterError as error:
            top = error.key.split(".")[0].split("[")[0]
            key = f"scene.{error.key}" if top in _HEAD else error.key
            raise SceneError(f"{origin.of(key)}{key}: {error.problem}") from None

    def to_data(self) -> dict[str, Any]:
        """Plain nested data, as in the TOML file."""
        head = {key: _thaw(getattr(self, key)) for key in _HEAD}
        data: dict[str, Any] = {"scene": {key: value for key, value in head.items() if value is not None}}
        for key in _SECTIONS:
            value = getattr(self, _attribute(key))
            if key == "record":
                standard = Record()
                fields = {item.name: getattr(value, item.name) for item in attrs.fields(Record)}
                value = {name: item for name, item in fields.items() if item != getattr(standard, name)} or None
            if value is not None and value != ():
                data[key] = _thaw(value)
        return data

    def to_toml(self) -> str:
        """The scene as TOML; reading it gives an equal scene."""
        import tomli_w

        return tomli_w.dumps(self.to_data())

    def with_settings(self, settings: Mapping[str, Any]) -> Scene:
        """The same scene with some keys set, dotted as in ``--set``."""
        return Scene._from_data(self.to_data(), self.folder, self.origin, settings)


_HEAD = ("name", "duration", "step", "tolerance", "start", "effects")
_SECTIONS = (
    "solid",
    *LISTS_OF_SOLID,
    "cross_bridges",
    "activation",
    "calcium",
    "sarcomere_density",
    "integrator",
    "coupling",
    "continuation",
    "record",
)


def _fields(data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Scene` from nested data; every table and key is a known one, and what must be there is there."""
    for key, value in data.items():
        if key != "scene" and key not in _SECTIONS:
            raise ParameterError(key, f"is no section. {nearest(key, ['scene', *_SECTIONS])}")
        if key not in LISTS_OF_SOLID and not isinstance(value, Mapping):
            raise ParameterError(key, f"is {value!r}; expected a table, [{key}]")
    head = dict(data.get("scene", {}))
    for key in head:
        if key not in _HEAD:
            raise ParameterError(f"scene.{key}", f"is unknown. {nearest(key, _HEAD)}")
    if "solid" not in data:
        raise ParameterError("solid", "is missing; a scene needs a [solid] with a plugin")
    return head | {_attribute(key): data[key] for key in _SECTIONS if key in data}


def _attribute(section: str) -> str:
    """Name of the attribute of a scene that holds a section."""
    return f"{section}s" if section in LISTS_OF_SOLID else section


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
