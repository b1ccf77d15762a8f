"""Fibre properties that several models and solids share: filament direction, filament overlap, sarcomere density."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

from myobridge.interfaces.active_law import Array

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Fibres", "Overlap", "SarcomereDensity"]


class Fibres(ABC):
    """Reference direction of the muscle fibres."""

    summary: ClassVar[str] = ""

    @abstractmethod
    def directions(self, mesh: Mesh, points: Array) -> Array:
        """Unit vectors at the local coordinates `points` (dim, n_points) of every cell; (n_cells, n_points, dim).

        Raises
        ------
        ParameterError
            If a boundary that is named does not exist, or a direction is undefined somewhere.
        """


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
