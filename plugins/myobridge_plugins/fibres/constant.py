"""The same fibre direction everywhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Fibres
from myobridge.parameters import numbers

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Constant"]


@final
@attrs.frozen
class Constant(Fibres):
    r"""Parallel fibres.

    .. math:: N(X) = n / |n|

    Parameters
    ----------
    direction : sequence of float, shape (dim,), optional
        Direction n, of any length but 0; its sign means nothing. Default: along x.

    Raises
    ------
    ParameterError
        If the direction has no length, or (when the mesh is known) another dimension.
    """

    summary: ClassVar[str] = "parallel fibres"

    direction: tuple[float, ...] | None = numbers(None, doc="2 or 3 numbers, of any length but 0; along x by default")

    def __attrs_post_init__(self) -> None:
        given = self.direction
        if given is not None and (not isinstance(given, tuple) or len(given) not in (2, 3) or not any(given)):
            raise ParameterError("direction", f"is {given!r}; expected 2 or 3 numbers, not all of them 0")

    def directions(self, mesh: Mesh, points: Array) -> Array:
        given = (1.0, 0.0, 0.0)[: mesh.dim()] if self.direction is None else self.direction
        if len(given) != mesh.dim():
            raise ParameterError("direction", f"has {len(given)} numbers; the mesh has {mesh.dim()} dimensions")
        # Scaled first: the square of a tiny or huge number is none.
        unit = np.array(given) / max(map(abs, given))
        return np.tile(unit / math.hypot(*unit), (mesh.nelements, points.shape[1], 1))


@hookimpl
def myobridge_fibres():
    return {"constant": Constant}
