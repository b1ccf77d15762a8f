"""Bell-shaped active force-length relation of Thelen (2003)."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Overlap
from myobridge.parameters import number

__all__ = ["Gaussian"]


@final
@attrs.frozen
class Gaussian(Overlap):
    r"""Smooth force-length relation of whole muscle.

    .. math:: o(\lambda) = \exp\!\big(-(\lambda - \lambda_0)^2 / \gamma\big)

    Parameters
    ----------
    optimum : float
        Stretch at which the force is largest [-].
    width : float
        Shape factor gamma [-].

    References
    ----------
    .. [1] D. G. Thelen, J. Biomech. Eng. 125 (2003) 70-77, Eq. (4), gamma = 0.45.
    """

    summary: ClassVar[str] = "bell-shaped force-length relation of whole muscle (Thelen 2003)"

    optimum: float = number(1.0, within="(0, inf)", doc="stretch at which the force is largest")
    # Thelen (2003), Eq. (4): chosen there to approximate the relation of single sarcomeres.
    width: float = number(0.45, within="(0, inf)", doc="shape factor gamma")

    def fraction(self, stretch: Array) -> Array:
        away = stretch - self.optimum
        return np.exp(away * away * (-1.0 / self.width))

    def derivative(self, stretch: Array) -> Array:
        return (-2.0 / self.width) * (stretch - self.optimum) * self.fraction(stretch)


@hookimpl
def myobridge_overlaps():
    return {"gaussian": Gaussian}
