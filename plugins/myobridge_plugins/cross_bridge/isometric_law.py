"""Tension that depends on activation and overlap, but not on any population."""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, LawValue, Overlap

__all__ = ["IsometricLaw"]


@final
class IsometricLaw(ActiveLaw):
    r"""Tension of given strength, shaped by the overlap where there is one.

    .. math:: T(\lambda) = T_0\,o(\lambda), \qquad dT/d\lambda = T_0\,o'(\lambda)

    It answers for models without population, and for the steady state of models with one. It offers no potential: the
    work of such a tension is not stored anywhere, and the ledger books it as active work.

    Parameters
    ----------
    strength : ndarray, shape (n_sites,)
        Tension at full overlap, nominal, in units of `p_max` [-], positive in tension.
    overlap : Overlap or None
        Overlap of the filaments; None for 1 at every stretch.
    """

    __slots__ = ("overlap", "strength")

    def __init__(self, strength: Array, overlap: Overlap | None = None) -> None:
        self.strength = strength
        self.overlap = overlap

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        if self.overlap is None:
            return LawValue(self.strength + 0.0 * stretch, np.zeros_like(stretch))
        return LawValue(
            self.strength * self.overlap.fraction(stretch), self.strength * self.overlap.derivative(stretch)
        )

    def scaled(self, factor: Array) -> IsometricLaw:
        return IsometricLaw(factor * self.strength, self.overlap)
