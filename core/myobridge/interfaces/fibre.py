"""Fibre properties that several models and solids share: filament overlap and sarcomere density."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from myobridge.interfaces.active_law import Array

__all__ = ["Overlap", "SarcomereDensity"]


class Overlap(ABC):
    """Fraction of the heads that face a binding site, as a function of stretch."""

    summary: ClassVar[str] = ""

    @abstractmethod
    def fraction(self, stretch: Array) -> Array:
        """Overlap in [0, 1], same shape as `stretch`."""

    @abstractmethod
    def derivative(self, stretch: Array) -> Array:
        """d overlap / d stretch [-]."""


class SarcomereDensity(ABC):
    """Local density of sarcomeres relative to a fully packed muscle."""

    summary: ClassVar[str] = ""
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"sarcomere_density"})

    @abstractmethod
    def at(self, positions: Array) -> Array:
        """Density [-] at reference `positions` (n_sites, dimension) [m]; shape (n_sites,)."""
