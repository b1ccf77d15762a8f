"""Plugins built from plain values: lists of plugins, lists of records, effects within them, and what errors say."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import attrs
import pytest

from myobridge.build import build
from myobridge.errors import ParameterError, PluginError
from myobridge.interfaces import Signal
from myobridge.parameters import number, part, parts, records, text
from myobridge.registry import registry
from myobridge_plugins.signal.constant import Constant
from myobridge_plugins.signal.ramp import Ramp


@attrs.frozen
class Held:
    """A record with a plugin, a file and a parameter of an effect."""

    where: str = text(doc="a name")
    weight: float | None = number(None, effect="gravity", on=2.0, doc="acts with gravity")
    table: str = text("", doc="a path", kind="file")
    scale: Signal | None = part("signal", None, doc="over time")


@attrs.frozen
class Body:
    """A plugin with a list of each kind."""

    load: tuple[Signal, ...] = parts("signal", doc="loads")
    support: tuple[Held, ...] = records(Held, doc="supports")
    size: float = number(1.0, doc="a number")


class Shelf:
    """The registry, with one more plugin."""

    def find(self, family: str, name: str) -> Any:
        if (family, name) == ("mesh", "body"):
            return SimpleNamespace(cls=Body, name="body", package="test")
        return registry().find(family, name)

    def names(self, family: str) -> tuple[str, ...]:
        return registry().names(family)


def body(table: Mapping[str, Any], effects: tuple[str, ...] | None = None, folder: Path | None = None) -> Body:
    """The plugin from a table."""
    return build(Shelf(), "mesh", {"plugin": "body", **table}, effects, folder)  # pyright: ignore[reportArgumentType]


def test_lists_are_built_entry_by_entry() -> None:
    ready = Constant(level=3.0)
    made = body(
        {
            "load": [{"plugin": "ramp", "initial": 1.0, "slope": 2.0}, "constant", ready],
            "support": ({"where": "left", "scale": {"plugin": "constant", "level": 0.5}}, Held(where="right")),
        }
    )
    assert [type(item) for item in made.load] == [Ramp, Constant, Constant]
    assert made.load[0] == Ramp(initial=1.0, slope=2.0)
    assert made.load[2] is ready, "an instance is taken as it is"
    assert made.support == (Held(where="left", scale=Constant(level=0.5)), Held(where="right"))
    assert body({}).load == body({}).support == ()


def test_effects_reach_into_records(tmp_path: Path) -> None:
    (held,) = body({"support": [{"where": "left"}]}, ("gravity",)).support
    assert held.weight == 2.0, "called for and not set: on"
    (held,) = body({"support": [{"where": "left", "weight": 3.0}]}, ("gravity",)).support
    assert held.weight == 3.0
    (held,) = body({"support": [{"where": "left", "table": "a.csv"}]}, (), tmp_path).support
    assert held.weight is None
    assert held.table == str(tmp_path / "a.csv"), "files are beside the scene"


MISTAKES = {
    "no list": ({"load": {"plugin": "ramp"}}, "load", "expected a list of tables"),
    "text": ({"support": "left"}, "support", "a list of tables with where, weight, table, scale"),
    "no plugin": ({"load": ["constant", {}]}, "load[1].plugin", "is missing"),
    "unknown plugin": ({"load": ["constnat"]}, "load[0].plugin", "Did you mean 'constant'?"),
    "unknown key of a part": ({"load": [{"plugin": "constant", "levle": 1}]}, "load[0].levle", "'level'?"),
    "part is a number": ({"load": ["constant", 3]}, "load[1]", "is 3; expected a table naming a plugin"),
    "record is a number": ({"support": [3]}, "support[0]", "is 3; expected a table with where"),
    "unknown key of a record": ({"support": [{"where": "a"}, {"were": "b"}]}, "support[1].were", "'where'?"),
    "missing key of a record": ({"support": [{"weight": None}]}, "support[0].where", "is missing; expected text"),
    "wrong type in a record": ({"support": [{"where": 3}]}, "support[0].where", "is 3"),
    "deep": (
        {"support": [{"where": "a", "scale": {"plugin": "constant", "level": "x"}}]},
        "support[0].scale.level",
        "is 'x'",
    ),
}


@pytest.mark.parametrize("kind", MISTAKES)
def test_a_mistake_is_named_with_its_place(kind: str) -> None:
    table, key, says = MISTAKES[kind]
    with pytest.raises(ParameterError) as caught:
        body(table)
    assert caught.value.key == key
    assert says in caught.value.problem


def test_a_parameter_of_an_absent_effect_is_refused_within_a_record() -> None:
    with pytest.raises(ParameterError, match=r"support\[0\]\.weight: belongs to the effect 'gravity'"):
        body({"support": [{"where": "left", "weight": 3.0}]}, ())


def test_an_unknown_family_member_is_refused() -> None:
    with pytest.raises(ParameterError, match="plugin: unknown"):
        build(registry(), "signal", {"plugin": "body"})
    with pytest.raises(PluginError):
        Shelf().find("mesh", "boddy")
