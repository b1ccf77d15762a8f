"""The same density of sarcomeres everywhere."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, SarcomereDensity
from myobridge.parameters import number

__all__ = ["Uniform"]


@final
@attrs.frozen
class Uniform(SarcomereDensity):
    r"""Uniform density.

    .. math:: \rho_{sc}(X) = \rho_0

    Parameters
    ----------
    value : float
        Density relative to a fully packed muscle [-]; 0 is tendon.
    """

    summary: ClassVar[str] = "the same density everywhere"

    value: float = number(1.0, within="[0, inf)", doc="density relative to a fully packed muscle")

    def at(self, positions: Array) -> Array:
        return np.full(len(positions), self.value)


@hookimpl
def myobridge_sarcomere_densities():
    return {"uniform": Uniform}
