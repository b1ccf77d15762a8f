"""Declared parameters: what is taken, what is refused, and what the refusal says."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from myobridge.errors import ParameterError
from myobridge.parameters import (
    Interval,
    choice,
    declared,
    flag,
    integer,
    number,
    numbers,
    optional_effects,
    part,
    parts,
    records,
    text,
)


@attrs.frozen
class Place:
    """A record: declared parameters, no plugin."""

    where: str = text(doc="a name")
    share: float = number(1.0, within="[0, 1]", doc="a number")


@attrs.frozen
class Sample:
    """One parameter of every kind."""

    length: float = number(1.0, unit="m", within="(0, 2]", doc="length")
    optional: float | None = number(None, within="[0, 1]", doc="may be left out")
    values: tuple[float, ...] | float = numbers(0.5, within="[0, 1]", doc="one or many")
    times: tuple[float, ...] | float = numbers((), unit="s", doc="may be empty")
    count: int = integer(1, within="[1, 10]", doc="how many")
    on: bool = flag(False, doc="switch")
    kind: str = choice("linear", ("linear", "hold"), doc="how")
    file: str = text("", doc="a path", kind="file")
    inner: object = part("signal", None, doc="another plugin", effect="viscosity", on="constant")
    others: tuple[object, ...] = parts("signal", doc="any number of plugins")
    places: tuple[Place, ...] = records(Place, doc="any number of records")
    hidden: int = 3


ACCEPTED = [
    ("length", 2, 2.0),
    ("length", np.float32(0.5), 0.5),
    ("optional", None, None),
    ("optional", 1, 1.0),
    ("values", 1, 1.0),
    ("values", [0, 1], (0.0, 1.0)),
    ("values", np.array([0.25, 0.75]), (0.25, 0.75)),
    ("times", [], ()),
    ("count", np.int64(3), 3),
    ("on", True, True),
    ("kind", "hold", "hold"),
    ("file", "a.csv", "a.csv"),
    ("others", [], ()),
    ("places", [Place(where="here")], (Place(where="here"),)),
]

REFUSED = [
    ("length", 0.0, "expected a number in (0, 2] [m]"),
    ("length", 2.1, "expected a number in (0, 2] [m]"),
    ("length", math.nan, "is nan"),
    ("length", -math.inf, "is -inf"),
    ("length", 10**400, "expected a number"),
    ("length", "1.0", "is '1.0'"),
    ("length", True, "is True"),
    ("length", None, "is None"),
    ("length", np.array([1.0, 2.0]), "expected a number"),
    ("length", {"plugin": "ramp"}, "expected a number"),
    ("optional", -0.1, "in [0, 1]"),
    ("values", [0.5, 1.5], "values[1]: is 1.5"),
    ("values", [], "is empty"),
    ("values", [[0.1]], "values[0]: is [0.1]"),
    ("values", "0.5", "a number or a list of numbers"),
    ("count", 2.0, "is 2.0; expected a whole number in [1, 10]"),
    ("count", 0, "in [1, 10]"),
    ("count", True, "is True"),
    ("on", 1, "expected true or false"),
    ("kind", "hold on", "Did you mean 'hold'?"),
    ("kind", ["hold"], "Allowed: hold, linear."),
    ("file", 3, "expected file as a string"),
    ("others", {"plugin": "ramp"}, "expected a list"),
    ("places", "here", "is 'here'; expected a list"),
]


@pytest.mark.parametrize(("key", "value", "held"), ACCEPTED)
def test_accepted(key: str, value: object, held: object) -> None:
    found = getattr(Sample(**{key: value}), key)
    assert found == held
    assert type(found) is type(held)


@pytest.mark.parametrize(("key", "value", "says"), REFUSED)
def test_refused(key: str, value: object, says: str) -> None:
    with pytest.raises(ParameterError) as caught:
        Sample(**{key: value})
    assert caught.value.key.split("[")[0] == key
    assert says in str(caught.value)


def test_a_required_parameter_must_be_given() -> None:
    @attrs.frozen
    class Needs:
        size: float = number(doc="size")

    with pytest.raises(TypeError, match="size"):
        Needs()  # pyright: ignore[reportCallIssue]


def test_only_declared_fields_are_for_scenes() -> None:
    said = declared(Sample)
    assert list(said) == [
        "length",
        "optional",
        "values",
        "times",
        "count",
        "on",
        "kind",
        "file",
        "inner",
        "others",
        "places",
    ]
    assert said["length"].unit == "m"
    assert said["length"].allowed() == "a number in (0, 2] [m]"
    assert said["inner"].allowed() == "a table naming a plugin of family 'signal'"
    assert said["others"].allowed() == "a list of tables, each naming a plugin of family 'signal'"
    assert said["places"].allowed() == "a list of tables with where, share"
    assert Sample().others == Sample().places == (), "none unless given"
    assert optional_effects(Sample) == {"viscosity"}
    assert declared(int) == {}


@given(
    st.sampled_from("[("),
    st.floats(-1e6, 1e6),
    st.floats(0.0, 1e6),
    st.sampled_from("])"),
    st.floats(-3e6, 3e6),
)
def test_interval_is_what_its_notation_says(left: str, low: float, width: float, right: str, value: float) -> None:
    interval = Interval(f"{left}{low!r}, {low + width!r}{right}")
    high = low + width
    above = value > low or (left == "[" and value == low)
    below = value < high or (right == "]" and value == high)
    assert (value in interval) == (above and below)
    assert (low in interval) == (left == "[" and (high > low or right == "]"))
    assert (high in interval) == (right == "]" and (high > low or left == "["))
