"""A density of sarcomeres given for each site."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, SarcomereDensity
from myobridge.parameters import numbers

__all__ = ["Table"]


@final
@attrs.frozen
class Table(SarcomereDensity):
    r"""Density given site by site, in the order of the solid's sites.

    .. math:: \rho_{sc}(X_i) = \rho_i

    Parameters
    ----------
    values : sequence of float, shape (n_sites,)
        Density of each site relative to a fully packed muscle [-].
    """

    summary: ClassVar[str] = "one density for each site, in the order of the sites"

    values: tuple[float, ...] = numbers(within="[0, inf)", doc="density of each site, in the order of the sites")

    def at(self, positions: Array) -> Array:
        """Density [-], shape (n_sites,).

        Raises
        ------
        ParameterError
            If there are not as many values as sites.
        """
        values = np.atleast_1d(np.asarray(self.values, dtype=np.float64))
        if len(values) != len(positions):
            raise ParameterError("values", f"has {len(values)} entries for {len(positions)} sites; give one for each")
        return values


@hookimpl
def myobridge_sarcomere_densities():
    return {"table": Table}
