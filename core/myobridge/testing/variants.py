"""Every way in which a registered plugin can be built from its defaults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from myobridge.build import build
from myobridge.parameters import declared
from myobridge.registry import Registry, registry

__all__ = ["variants"]


def variants(
    family: str, name: str, extra: Mapping[str, Any] | None = None, source: Registry | None = None
) -> dict[str, Any]:
    """Instances of a plugin by what distinguishes them: the default, each choice, flag, effect and parameter set.

    Parameters
    ----------
    family, name : str
        The plugin.
    extra : mapping, optional
        Values of parameters without default, or cheaper ones for a test.
    source : Registry, optional
        Where the plugin is registered; by default the registry of this process.
    """
    where = registry() if source is None else source
    base = {"plugin": name, **(extra or {})}
    cls = where.find(family, name).cls
    inherent = frozenset(getattr(cls, "inherent_effects", frozenset()))
    built = {name: build(where, family, base)}
    for label, change, effect in _changes(cls):
        if not any(key in base for key in change):
            effects = inherent | {effect} if effect else None
            built[f"{name}-{label}"] = build(where, family, {**base, **change}, effects)
    return built


def _changes(cls: type[Any]) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Label, parameters and effect of each change from the default."""
    for key, item in declared(cls).items():
        if item.effect and item.on is not None:
            yield item.effect, {}, item.effect
        elif item.kind == "choice":
            for option in item.choices:
                yield f"{key}={option}", {key: option}, item.effect
        elif item.kind == "true or false":
            for option in (True, False):
                yield f"{key}={option}", {key: option}, item.effect
    for known in getattr(cls, "parameter_sets", {}):
        yield str(known), {"parameters": known}, ""
