"""Variants of a study: scene keys crossed, and which of them change the model and which its discretisation."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

import attrs

from myobridge.effects import FAMILY_OF_SECTION, LISTS_OF_SOLID
from myobridge.errors import ParameterError
from myobridge.settings import normalised

__all__ = ["NUMERICAL", "Variant", "crossed", "flattened", "matches", "toml_value"]

Settings = Mapping[str, Any]

_SECTIONS = ("scene", "record", *FAMILY_OF_SECTION, *LISTS_OF_SOLID)
# What does not change the equations that are solved, only how well; everything else makes another model.
NUMERICAL = (
    "scene.step",
    "scene.tolerance",
    "integrator.*",
    "coupling.*",
    "cross_bridges.bins",
    "cross_bridges.low",
    "cross_bridges.high",
    "cross_bridges.discretisation",
    "cross_bridges.method",
    "solid.elements",
    "solid.quadrature",
    "solid.threads",
    "solid.mesh.cells",
    "solid.mesh.across",
    "solid.mesh.refinements",
    "solid.mesh.shape",
)


@attrs.frozen
class Variant:
    """One scene of a study.

    Attributes
    ----------
    settings : mapping
        Keys that are set on top of the scene.
    family : str
        Line of the plot that it belongs to: what is chosen, without what is refined.
    model : str
        Which equations it solves; empty for those of the scene as it stands.
    label : str
        What distinguishes it, for people.
    """

    settings: Settings
    family: str
    model: str
    label: str

    @property
    def command(self) -> str:
        """The settings as the command line takes them."""
        return " ".join(f"--set {_quoted(f'{key}={toml_value(value)}')}" for key, value in self.settings.items())


def crossed(blocks: Sequence[Mapping[str, Any]], numerical: Sequence[str] = NUMERICAL) -> tuple[Variant, ...]:
    """All variants of all blocks, each once.

    In a block, a list is an axis, a table of tables names the settings of an axis, and anything else is set in every
    variant. ``family`` and ``model`` of a block name those of its variants.

    Raises
    ------
    ParameterError
        If a block has an empty axis, or nothing is left to run.
    """
    found: dict[str, Variant] = {}
    for number, block in enumerate(blocks):
        if not flattened(block):
            break
        for variant in _of_block(block, f"vary[{number}]" if len(blocks) > 1 else "vary", numerical):
            found.setdefault(repr(sorted(variant.settings.items())), variant)
    if not found:
        raise ParameterError("vary", "is empty, so there is nothing to compare; give keys of the scene with lists")
    return tuple(found.values())


def flattened(table: Mapping[str, Any]) -> dict[str, Any]:
    """Tables below a section of a scene as dotted keys: ``{"solid": {"mass": 1}}`` is ``{"solid.mass": 1}``."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        first = str(key).partition(".")[0].partition("[")[0]
        if isinstance(value, Mapping) and first in _SECTIONS:
            for inner, item in value.items():
                found |= flattened({f"{key}.{inner}": item})
        else:
            found[normalised(str(key))] = value
    return found


def _of_block(block: Mapping[str, Any], where: str, numerical: Sequence[str]) -> Iterator[Variant]:
    named = {key: block[key] for key in ("family", "model") if key in block}
    axes: list[list[tuple[str, Settings, bool]]] = []
    for key, value in flattened(block).items():
        if key in named:
            if not isinstance(value, str):
                raise ParameterError(f"{where}.{key}", f"is {value!r}; expected a name")
            continue
        axes.append(list(_axis(key, value, where)))
        if not axes[-1]:
            raise ParameterError(
                f"{where}.{key}", "is an empty list, so the cross product has no variant; give values, or leave it out"
            )
    for combination in itertools.product(*axes):
        settings = {key: value for _, part, _ in combination for key, value in part.items()}
        chosen = [name for name, _, refined in combination if name and not refined]
        label = ", ".join(name for name, _, _ in combination if name)
        physics = [f"{key}={value}" for key, value in sorted(settings.items()) if not matches(key, numerical)]
        yield Variant(
            settings,
            str(named.get("family", ", ".join(chosen))),
            str(named.get("model", ", ".join(physics))),
            ", ".join(filter(None, (named.get("family", ""), label))) or "as it is",
        )


def _axis(key: str, value: Any, where: str) -> Iterator[tuple[str, Settings, bool]]:
    """(name, settings, whether it is refined along the axis) of each value."""
    if isinstance(value, Mapping):
        for name, settings in value.items():
            if not isinstance(settings, Mapping):
                raise ParameterError(
                    f"{where}.{key}.{name}", f"is {settings!r}; expected a table of scene keys, or write '{key}.{name}'"
                )
            yield str(name), flattened(settings), False
        return
    short = key.rpartition(".")[2]
    if short == "plugin":
        short = key.split(".")[-2] if "." in key else key
    if not isinstance(value, list | tuple):
        yield "", {key: value}, False
        return
    for item in value:
        name = item if isinstance(item, str) else f"{short} {_short(item)}"
        yield name, {key: item}, not isinstance(item, str | bool)


def _short(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return "x".join(_short(item) for item in value)
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def matches(key: str, patterns: Sequence[str]) -> bool:
    """Whether a key is one of those that the patterns mean."""
    return any(fnmatchcase(key, pattern) for pattern in patterns)


def toml_value(value: Any) -> str:
    """A value as TOML writes it, in one line."""
    import tomli_w

    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    return tomli_w.dumps({"value": value}).partition("=")[2].strip()


def _quoted(word: str) -> str:
    import shlex

    return shlex.quote(word)
