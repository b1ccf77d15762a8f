"""Dead traction."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Load, Signal, Surface
from myobridge.parameters import numbers, part, text
from myobridge_plugins.load.spreading import factor, spread, vector

__all__ = ["Traction"]


@final
@attrs.frozen
class Traction(Load):
    r"""Force per reference area that keeps its direction and its size.

    .. math:: f_a = s(t) \int N_a\,T\,dA

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    traction : sequence of float, shape (dim,)
        Nominal traction T [Pa], along the axes.
    scale : Signal, optional
        Factor s(t) [-]; without it 1.
    """

    summary: ClassVar[str] = "dead force per reference area"
    dead: ClassVar[bool] = True

    boundary: str = text(doc="name of the boundary")
    traction: float | tuple[float, ...] = numbers(unit="Pa", doc="nominal traction, one number an axis")
    scale: Signal | None = part("signal", None, doc="factor as a function of time")

    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        return factor(self.scale, time) * spread(surface, vector("traction", self.traction, surface, "Pa"))

    def jumps(self) -> tuple[float, ...]:
        return () if self.scale is None else self.scale.jumps()


@hookimpl
def myobridge_loads():
    return {"traction": Traction}
