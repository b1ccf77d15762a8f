"""Dead force."""

from __future__ import annotations

from typing import ClassVar, final

import attrs

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Load, Signal, Surface
from myobridge.parameters import numbers, part, text
from myobridge_plugins.load.spreading import factor, spread, vector

__all__ = ["Force"]


@final
@attrs.frozen
class Force(Load):
    r"""Total force on a boundary, spread evenly over its reference area, of constant direction.

    .. math:: f_a = s(t)\,\frac{F}{A} \int N_a\,dA, \qquad \sum_a f_a = s(t)\,F

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    force : sequence of float, shape (dim,)
        Total force F [N], along the axes. In 2D it is that on the whole thickness.
    scale : Signal, optional
        Factor s(t) [-]; without it 1.
    """

    summary: ClassVar[str] = "dead total force, spread evenly"
    dead: ClassVar[bool] = True

    boundary: str = text(doc="name of the boundary")
    force: float | tuple[float, ...] = numbers(unit="N", doc="total force, one number an axis")
    scale: Signal | None = part("signal", None, doc="factor as a function of time")

    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        traction = vector("force", self.force, surface, "N") / surface.areas.sum()
        return factor(self.scale, time) * spread(surface, traction)

    def jumps(self) -> tuple[float, ...]:
        return () if self.scale is None else self.scale.jumps()


@hookimpl
def myobridge_loads():
    return {"force": Force}
