"""What every discretisation of the two-state equation offers the model `Huxley`."""

from __future__ import annotations

from abc import ABC, abstractmethod

import attrs

from myobridge.interfaces import Array, Fluxes, Promises
from myobridge_plugins.cross_bridge.rates import Rates

__all__ = ["Discretisation"]


@attrs.frozen
class Discretisation(ABC):
    """Abstract discretisation of the attached fraction on `bins` cells a reach.

    Activation and overlap are arrays with one entry a site; an overlap of one entry holds for all sites.
    Displacements are in units of the reach. Fluxes are per isometric tension, see `Fluxes`.

    Parameters
    ----------
    rates : Rates
        Rates of attachment and detachment [1/s].
    bins : int
        Cells a reach.
    low, high : float
        Ends of the window of displacements that is kept [reach].
    filled : bool
        Whether the population starts in its isometric steady state, or empty.
    by_rate : bool
        Whether activation scales the rate of attachment, or the attachable fraction.
    scale : float
        Energy per p_max of :math:`\\kappa = 1`, that is :math:`1/(s Q_1^{iso})` [-].
    """

    rates: Rates
    bins: int
    low: float
    high: float
    filled: bool
    by_rate: bool
    scale: float

    @property
    @abstractmethod
    def promises(self) -> Promises:
        """What it declares of itself."""

    @abstractmethod
    def initial_state(self, n_sites: int) -> Array:
        """State at the start, shape (n_sites, m)."""

    @abstractmethod
    def react(
        self, state: Array, activation: Array, overlap: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        """Attach and detach for `dt` seconds, filaments held."""

    @abstractmethod
    def slide(self, state: Array, displacement: Array, out: Array | None) -> Array:
        """Carry the heads by `displacement`."""

    def slide_and_gain(self, state: Array, displacement: Array, out: Array | None) -> tuple[Array, Array] | None:
        """`slide`, and the energy that each site gained; None where it takes two looks at the moments."""
        return None

    def advance(
        self, state: Array, activation: Array, overlap: Array, displacement: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes] | None:
        """The whole path at once; None where the model's splitting is to be used."""
        return None

    @abstractmethod
    def moments(self, state: Array) -> Array:
        """Moments Q0, Q1, Q2, shape (n_sites, 3)."""

    @abstractmethod
    def density(self, state: Array) -> tuple[Array, Array]:
        """Positions q [reach] and attached fraction, each (n_sites, n_points)."""
