"""Which of Newton's methods, where a scene names none: the ordinary one, unless another says that it suits the task."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

from myobridge.errors import PluginError
from myobridge.interfaces import MacroSolid, NewtonMethod, NewtonTask, SystemSize
from myobridge.solvers.choice import choose, size_of_solid
from myobridge.solvers.newton import Ordinary

__all__ = ["MethodChoice", "method_for", "method_for_size"]

# Below this size tangents and factors cost less than more iterations, whatever the method.
_SMALL = 300
_ORDINARY = Ordinary()


class MethodChoice(NamedTuple):
    """Name of a method, the reason for it in words, and the method."""

    name: str
    reason: str
    method: NewtonMethod


def method_for(solid: MacroSolid, *, path: bool = False) -> MethodChoice:
    """The method for the steps of a solid, or for a path of its equilibria."""
    if solid.n_unknowns + solid.rest_motion().multiplier.size <= _SMALL:
        return MethodChoice("ordinary", "few unknowns", _ORDINARY)
    return method_for_size(size_of_solid(solid), path=path)


def method_for_size(size: SystemSize, *, path: bool = False) -> MethodChoice:
    """The method for steps with systems of a size, or for a path of equilibria; the first by name that says so."""
    from myobridge.registry import registry

    if size.n_unknowns <= _SMALL:
        return MethodChoice("ordinary", "few unknowns", _ORDINARY)
    return _chosen(registry(), size, path)


@functools.lru_cache(maxsize=64)
def _chosen(found: Any, size: SystemSize, path: bool) -> MethodChoice:
    try:
        solver = choose(size).solver
    except PluginError:  # said by the linear solver's own choice, with what to do
        solver = None
    task = NewtonTask(size, direct=solver is None or solver.direct, path=path)
    for name in found.names("newton"):
        cls = found.find("newton", name).cls
        if cls.suits(task):
            return MethodChoice(name, cls.summary, cls())
    return MethodChoice("ordinary", "no other method says that it suits the task", _ORDINARY)
