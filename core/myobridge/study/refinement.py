"""Refinement: which keys of a scene make it finer, and how far a level goes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from myobridge.parameters import declared
from myobridge.plan import Plan
from myobridge.scene import Scene

__all__ = ["of_scene", "refined", "value_of"]

# Numbers that grow with the error; all other ones count something, and fall with it.
_LENGTHS = ("scene.step",)
_TOLERANCES = ("scene.tolerance",)
_COUNTS = ("cross_bridges.bins", "solid.elements", "solid.mesh.cells", "solid.mesh.across")


def of_scene(scene: Scene) -> dict[str, Any]:
    """Keys of the scene that can be refined, with the values that they have, given or not."""
    plan = Plan.of(scene)
    found: dict[str, Any] = {"scene.step": scene.step}
    if scene.tolerance is not None:
        found["scene.tolerance"] = scene.tolerance
    for key in _COUNTS:
        value = value_of(plan, key)
        whole = value if isinstance(value, list | tuple) else [value]
        if all(isinstance(item, int | float) and not isinstance(item, bool) and item == int(item) for item in whole):
            found[key] = [int(item) for item in whole] if isinstance(value, list | tuple) else int(value)
    return found


def value_of(plan: Plan, key: str) -> Any:
    """Value of a declared parameter of a plan by its key; None where there is none."""
    section, *names = key.split(".")
    part = plan.parts.get(section)
    for name in names[:-1]:
        part = getattr(part, name, None)
    if part is None or names[-1] not in declared(type(part)):
        return None
    return getattr(part, names[-1])


def refined(values: Mapping[str, Any], levels: float, keys: Sequence[str] | None = None) -> dict[str, Any]:
    """The values, `levels` times finer: steps halved, counts doubled, tolerances of a step quartered.

    Negative levels are coarser. Only `keys` where they are given.
    """
    found = dict(values)
    for key in values if keys is None else keys:
        if key not in values:
            continue
        value = values[key]
        if key in _TOLERANCES:
            found[key] = value * 4.0**-levels
        elif key in _LENGTHS or isinstance(value, float):
            found[key] = value * 2.0**-levels
        elif isinstance(value, list | tuple):
            found[key] = [max(round(item * 2.0**levels), 1) for item in value]
        else:
            found[key] = max(round(value * 2.0**levels), 1)
    return found
