"""Overlap of thick and thin filaments after Gordon, Huxley and Julian (1966)."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Overlap
from myobridge.parameters import number

__all__ = ["GordonHuxleyJulian"]

# Gordon, Huxley and Julian (1966), Fig. 12 (schematic summary, frog): striation spacing [m] and tension there [-].
_LENGTHS = np.array([1.27e-6, 1.67e-6, 2.0e-6, 2.25e-6, 3.65e-6])
_FRACTIONS = np.array([0.0, 0.84, 1.0, 1.0, 0.0])
# Slope on each of the six stretches of the length axis that the five corners make [1/m].
_SLOPES = np.concatenate([[0.0], np.diff(_FRACTIONS) / np.diff(_LENGTHS), [0.0]])


@final
@attrs.frozen
class GordonHuxleyJulian(Overlap):
    r"""Piecewise-linear overlap of frog sarcomeres.

    .. math:: o(\lambda) = o(\ell = \ell_1 \lambda): \quad
              (1.27, 0),\ (1.67, 0.84),\ (2.0, 1),\ (2.25, 1),\ (3.65, 0) \quad [\mu m, -]

    and 0 outside. At a corner `derivative` is the one towards longer sarcomeres.

    Parameters
    ----------
    sarcomere_length : float
        Length of a sarcomere at stretch 1 [m].

    Notes
    -----
    Departures: the figure shows tension; it is read here as the share of heads that face a thin filament, which is
    what the authors infer above 2.25 um. Below 2.0 um the loss comes from filaments in each other's way.

    References
    ----------
    .. [1] A. M. Gordon, A. F. Huxley, F. J. Julian, J. Physiol. 184 (1966) 170-192, Fig. 12.
    """

    summary: ClassVar[str] = "piecewise-linear overlap of frog sarcomeres (1966)"

    # Twice the half sarcomere of 1.1 um with which Huxley (1957) works; on the plateau, so that o(1) = 1.
    sarcomere_length: float = number(2.2e-6, unit="m", within="(0, inf)", doc="sarcomere length at stretch 1")

    def fraction(self, stretch: Array) -> Array:
        return np.interp(self.sarcomere_length * stretch, _LENGTHS, _FRACTIONS)

    def derivative(self, stretch: Array) -> Array:
        piece = np.searchsorted(_LENGTHS, self.sarcomere_length * stretch, side="right")
        return self.sarcomere_length * _SLOPES[piece]


@hookimpl
def myobridge_overlaps():
    return {"gordon_huxley_julian": GordonHuxleyJulian}
