"""A Python function of the place as density of sarcomeres."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, SarcomereDensity

__all__ = ["Function"]


@final
@attrs.frozen
class Function(SarcomereDensity):
    """A Python function of the place, for composition without a file (a scene is data, and names no code).

    Parameters
    ----------
    of_positions : callable
        Density [-] at reference positions (n_sites, dimension) [m]: one number, or one a site, none negative.
    """

    summary: ClassVar[str] = "a Python function of the place"

    of_positions: Callable[[Array], Any]

    def at(self, positions: Array) -> Array:
        """Density [-], shape (n_sites,).

        Raises
        ------
        ParameterError
            If the function answers another number of values, or one that is negative or not finite.
        """
        values = np.asarray(self.of_positions(positions), dtype=np.float64)
        sites = (len(positions),)
        if values.shape not in ((), sites):
            raise ParameterError("of_positions", f"answers shape {values.shape}; expected () or {sites}, one for each")
        wrong = values[~((values >= 0.0) & (values < np.inf))]
        if wrong.size:
            raise ParameterError("of_positions", f"answers {wrong.flat[0]}; expected numbers in [0, inf)")
        return np.array(np.broadcast_to(values, sites))
