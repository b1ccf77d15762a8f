"""Scaling: what a scene without time raises from nothing, how far, and where states are kept."""

from __future__ import annotations

from typing import final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.parameters import choice, number, numbers

__all__ = ["SCALED", "Scaling"]

SCALED = ("tension", "load", "tension_and_load")
"""What a scale can multiply: the active tension of all sites, all external forces, or both."""


@final
@attrs.frozen(kw_only=True)
class Scaling:
    r"""Scale of a scene without time; its keys stand beside those of the strategy in ``[continuation]``.

    .. math:: s = \ell\,s_{end}, \qquad \ell: 0 \to 1

    Parameters
    ----------
    of : {"tension", "load", "tension_and_load"}, optional
        What the scale multiplies; the rest acts in full from the start. Without: the tension where there are
        cross-bridges, else the load.
    to : float
        Scale reached at level 1 [-].
    report : sequence of float
        Scales at which the states are kept, to the last digit; without, the first and the last state.
    """

    of: str | None = choice(None, SCALED, doc="what the scale multiplies")
    to: float = number(1.0, within="(0, inf)", doc="scale at the end of the path")
    report: tuple[float, ...] | float = numbers((), within="[0, inf)", doc="scales at which states are kept")

    def __attrs_post_init__(self) -> None:
        for index, scale in enumerate(np.atleast_1d(self.report).tolist()):
            if scale > self.to:
                raise ParameterError(
                    f"report[{index}]", f"is {scale:g}, beyond the end of the path; expected at most to = {self.to:g}"
                )

    def kept(self) -> dict[float, float]:
        """Scale that is reported, by the level at which a state is kept; rising."""
        scales = sorted({float(scale) for scale in np.atleast_1d(self.report)}) or [0.0]
        return {scale / self.to: scale for scale in scales} | {1.0: self.to}
