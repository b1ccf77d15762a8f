"""Declared parameters: an attrs field that knows its unit, its range and the effect it belongs to.

A plugin is an ``attrs.frozen`` class whose fields are declared with the functions of this file. The declaration
is all that the scene reader, the error messages, ``myobridge explain`` and the documentation need::

    @final
    @attrs.frozen(kw_only=True)
    class Sine(Signal):
        mean_value: float = number(1.0, unit="-", doc="value about which it swings")
        frequency: float = number(unit="Hz", within="(0, inf)", doc="cycles a second")

`effect` ties a parameter to a phenomenon that a scene may leave out: the parameter then keeps its default (off)
unless the scene calls for the effect, and takes `on` when the scene calls for the effect and says no more.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from myobridge.errors import ParameterError, nearest

__all__ = [
    "Declaration",
    "Interval",
    "choice",
    "declared",
    "flag",
    "integer",
    "number",
    "numbers",
    "optional_effects",
    "part",
    "parts",
    "records",
    "text",
]

_KEY = "myobridge"
_REQUIRED: Any = attrs.NOTHING


@attrs.frozen
class Interval:
    """Interval in the usual notation: ``[0, 1]``, ``(0, inf)``."""

    text: str
    low: float = attrs.field(init=False)
    high: float = attrs.field(init=False)

    @low.default  # pyright: ignore[reportAttributeAccessIssue]
    def _low(self) -> float:
        return float(self.text.strip()[1:-1].split(",")[0])

    @high.default  # pyright: ignore[reportAttributeAccessIssue]
    def _high(self) -> float:
        return float(self.text.strip()[1:-1].split(",")[1])

    def __contains__(self, value: float) -> bool:
        left, right = self.text.strip()[0], self.text.strip()[-1]
        above = value > self.low if left == "(" else value >= self.low
        below = value < self.high if right == ")" else value <= self.high
        return above and below


@attrs.frozen
class Declaration:
    """What a parameter is: its kind, unit, range, choices, effect and meaning."""

    kind: str
    doc: str
    unit: str = "-"
    within: Interval | None = None
    choices: tuple[str, ...] = ()
    family: str = ""
    effect: str = ""
    on: Any = None
    record: type[Any] | None = None

    def allowed(self) -> str:
        """What may be given, in words."""
        words = {
            "number": "a number",
            "numbers": "a number or a list of numbers",
            "integer": "a whole number",
        }
        said = words.get(self.kind, self.kind)
        if self.kind == "choice":
            said = "one of " + ", ".join(self.choices)
        if self.kind == "part":
            said = f"a table naming a plugin of family '{self.family}'"
        if self.kind == "parts":
            said = f"a list of tables, each naming a plugin of family '{self.family}'"
        if self.kind == "records" and self.record is not None:
            said = f"a list of tables with {', '.join(declared(self.record))}"
        if self.within is not None:
            said += f" in {self.within.text}"
        return said + (f" [{self.unit}]" if self.unit != "-" else "")


def declared(cls: type[Any]) -> dict[str, Declaration]:
    """Declared parameters of a plugin class, by name; a field without declaration is none that a scene may set."""
    fields: tuple[attrs.Attribute[Any], ...] = attrs.fields(cls) if attrs.has(cls) else ()
    return {field.name: field.metadata[_KEY] for field in fields if _KEY in field.metadata}


def optional_effects(cls: type[Any]) -> frozenset[str]:
    """Effects tied to a parameter of the class."""
    return frozenset(item.effect for item in declared(cls).values() if item.effect)


def number(
    default: Any = _REQUIRED,
    *,
    doc: str,
    unit: str = "-",
    within: str = "(-inf, inf)",
    effect: str = "",
    on: Any = None,
) -> Any:
    """Real number in `within`; infinite only where that ends with ``inf]``; may be None where the default is None."""
    said = Declaration("number", doc, unit, Interval(within), effect=effect, on=on)
    return _field(default, said, lambda key, value: _real(key, value, said))


def numbers(
    default: Any = _REQUIRED,
    *,
    doc: str,
    unit: str = "-",
    within: str = "(-inf, inf)",
    effect: str = "",
    on: Any = None,
) -> Any:
    """One number for all sites, or a sequence with one for each; held as float or tuple of floats.

    An empty sequence is allowed where it is the default.
    """
    said = Declaration("numbers", doc, unit, Interval(within), effect=effect, on=on)

    def check(key: str, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if isinstance(value, Sequence) and not isinstance(value, str):
            if not value and default != ():
                raise ParameterError(key, f"is empty; expected {said.allowed()}")
            return tuple(_real(f"{key}[{i}]", item, said) for i, item in enumerate(value))
        return _real(key, value, said)

    return _field(default, said, check)


def integer(default: Any = _REQUIRED, *, doc: str, within: str = "[0, inf)", effect: str = "", on: Any = None) -> Any:
    """Whole number in `within`."""
    said = Declaration("integer", doc, "-", Interval(within), effect=effect, on=on)

    def check(key: str, value: Any) -> int:
        if isinstance(value, bool) or not hasattr(value, "__index__"):
            raise ParameterError(key, f"is {value!r}; expected {said.allowed()}")
        _real(key, value, said)
        return operator.index(value)

    return _field(default, said, check)


def flag(default: Any = _REQUIRED, *, doc: str, effect: str = "", on: Any = None) -> Any:
    """True or false."""
    said = Declaration("true or false", doc, effect=effect, on=on)

    def check(key: str, value: Any) -> bool:
        if not isinstance(value, bool):
            raise ParameterError(key, f"is {value!r}; expected true or false")
        return value

    return _field(default, said, check)


def choice(default: Any, choices: Sequence[str], *, doc: str, effect: str = "", on: Any = None) -> Any:
    """One word out of `choices`."""
    said = Declaration("choice", doc, choices=tuple(choices), effect=effect, on=on)

    def check(key: str, value: Any) -> str:
        if value not in said.choices:
            raise ParameterError(key, f"is {value!r}. {nearest(str(value), said.choices)}")
        return value

    return _field(default, said, check)


def text(default: Any = _REQUIRED, *, doc: str, kind: str = "text") -> Any:
    """Free text; `kind` "file" marks a path, read relative to the scene's file."""
    said = Declaration(kind, doc)

    def check(key: str, value: Any) -> str:
        if not isinstance(value, str):
            raise ParameterError(key, f"is {value!r}; expected {said.kind} as a string")
        return value

    return _field(default, said, check)


def part(family: str, default: Any = _REQUIRED, *, doc: str, effect: str = "", on: Any = None) -> Any:
    """Another plugin, of `family`; in a scene a table such as ``{ plugin = "ramp", slope = 0.1 }``.

    `on` names the plugin that is built when the scene calls for `effect` and gives no table.
    """
    return _field(default, Declaration("part", doc, family=family, effect=effect, on=on), lambda key, value: value)


def parts(family: str, *, doc: str) -> Any:
    """Any number of plugins of `family`; in a scene a list of tables, ``[[load]]`` and the like. Default: none."""
    return _field((), Declaration("parts", doc, family=family), lambda key, value: _listed(key, value))


def records(cls: type[Any], *, doc: str) -> Any:
    """Any number of instances of `cls`, a frozen class of declared parameters that is no plugin. Default: none."""
    return _field((), Declaration("records", doc, record=cls), lambda key, value: _listed(key, value))


def _listed(key: str, value: Any) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise ParameterError(key, f"is {value!r}; expected a list")
    return tuple(value)


def _real(key: str, value: Any, said: Declaration) -> float:
    if isinstance(value, bool) or (not isinstance(value, int | float) and not hasattr(value, "__float__")):
        raise ParameterError(key, f"is {value!r}; expected {said.allowed()}")
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):  # an array, or a whole number beyond all floats
        raise ParameterError(key, f"is {value!r}; expected {said.allowed()}") from None
    closed = said.within is not None and math.isinf(said.within.high) and said.within.text.strip().endswith("]")
    finite = math.isfinite(result) or (closed and result == math.inf)
    if not finite or (said.within is not None and result not in said.within):
        raise ParameterError(key, f"is {value!r}; expected {said.allowed()}")
    return result


def _field(default: Any, said: Declaration, check: Callable[[str, Any], Any]) -> Any:
    optional = default is None

    def convert(value: Any, _self: Any, field: attrs.Attribute[Any]) -> Any:
        return None if optional and value is None else check(field.name, value)

    converter = attrs.Converter(convert, takes_self=True, takes_field=True)  # pyright: ignore[reportCallIssue]
    return attrs.field(default=default, converter=converter, metadata={_KEY: said}, kw_only=True)
