"""A weight that hangs on a boundary."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Load, Surface
from myobridge.parameters import number, numbers, text
from myobridge_plugins.load.spreading import spread, vector

__all__ = ["HangingMass"]

# [m/s^2] Standard gravity rounded, as in the thesis.
_GRAVITY = 9.81


@final
@attrs.frozen
class HangingMass(Load):
    r"""Mass spread evenly over a boundary: its weight pulls, and with inertia it resists acceleration.

    .. math:: f_a = m\,g\,\frac{1}{A} \int N_a\,dA, \qquad M_{ab} = \frac{m}{A} \int N_a N_b\,dA

    The weight acts in every scene, whether or not its effects name `gravity`, which is the weight of the solid.

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    mass : float
        Mass m [kg].
    gravity : sequence of float, shape (dim,), optional
        Acceleration g [m/s^2]; without it 9.81 against the last axis.
    """

    summary: ClassVar[str] = "a weight: dead force and inertia"
    dead: ClassVar[bool] = True

    boundary: str = text(doc="name of the boundary")
    mass: float = number(unit="kg", within="[0, inf)", doc="mass that hangs on the boundary")
    gravity: float | tuple[float, ...] = numbers((), unit="m/s^2", doc="acceleration; 9.81 against the last axis")

    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        if self.gravity == ():
            acceleration = np.zeros(surface.dimension)
            acceleration[-1] = -_GRAVITY
        else:
            acceleration = vector("gravity", self.gravity, surface, "m/s^2")
        return spread(surface, self.mass / surface.areas.sum() * acceleration)

    def nodal_mass(self, surface: Surface) -> Array:
        density = self.mass / surface.areas.sum()
        return density * np.einsum("fp,pa,pb->fab", surface.areas, surface.shapes, surface.shapes)


@hookimpl
def myobridge_loads():
    return {"hanging_mass": HangingMass}
