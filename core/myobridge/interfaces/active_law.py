r"""Active law: the tension a fibre answers with while its cross-bridge population is frozen.

.. math:: T = T(\lambda, \dot\lambda), \qquad
          K = \partial T / \partial \lambda, \qquad D = \partial T / \partial \dot\lambda

With the population frozen, every sliding model is affine, :math:`T = T_n + K_n (\lambda - \lambda_n)`: a quadratic
fibre energy. A solid sees a law only; it never knows which model stands behind it.

Shapes: everything has one entry a site, ``(n_sites,)``. Tension is the *nominal* (first Piola-Kirchhoff) stress along
the reference fibre, positive in tension. A model states its law in units of its isometric tension [-]; the bus
scales it to [Pa].
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

__all__ = ["ActiveLaw", "AffineLaw", "Array", "LawValue"]

Array = NDArray[np.float64]


class LawValue(NamedTuple):
    """Tension and its derivatives at all sites.

    Attributes
    ----------
    tension : ndarray, shape (n_sites,)
        Nominal active stress [Pa], positive in tension.
    stiffness : ndarray, shape (n_sites,)
        d tension / d stretch [Pa].
    rate_sensitivity : ndarray, shape (n_sites,), or None
        d tension / d stretch rate [Pa s]; None when the law does not depend on the rate.
    """

    tension: Array
    stiffness: Array
    rate_sensitivity: Array | None = None


class ActiveLaw(ABC):
    """Tension as a function of stretch [-] and stretch rate [1/s], population frozen.

    Class attributes
    ----------------
    has_potential : bool
        Whether the tension derives from an energy, that is, whether `potential` answers.
    """

    __slots__ = ()

    has_potential: ClassVar[bool] = False

    @abstractmethod
    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        """Tension, stiffness and rate sensitivity at the given stretch and stretch rate."""

    @abstractmethod
    def scaled(self, factor: Array) -> ActiveLaw:
        """The same law times `factor`, shape (n_sites,): how the bus turns [-] into [Pa]."""

    def potential(self, stretch: Array) -> Array | None:
        r"""Energy density :math:`\psi` with :math:`T = d\psi/d\lambda` [J/m^3], or None where there is none."""
        return None

    @property
    def inertance(self) -> Array | None:
        r"""Tension per stretch acceleration [Pa s^2] of heads with mass; None for massless heads."""
        return None


@final
class AffineLaw(ActiveLaw):
    r"""Affine law, the exact answer of a frozen population.

    .. math:: T = T_n + K_n (\lambda - \lambda_n) \;(+\, I\,\ddot\lambda), \qquad
              \psi = T_n (\lambda - \lambda_n) + \tfrac12 K_n (\lambda - \lambda_n)^2

    Parameters
    ----------
    stretch, tension, stiffness : ndarray, shape (n_sites,)
        Point of expansion [-], tension there and slope.
    inertance : ndarray, shape (n_sites,), or None
        Tension per stretch acceleration of heads with mass [s^2 times the unit of tension].
    """

    __slots__ = ("_inertance", "stiffness", "stretch", "tension")

    has_potential: ClassVar[bool] = True

    def __init__(self, stretch: Array, tension: Array, stiffness: Array, inertance: Array | None = None) -> None:
        self.stretch = stretch
        self.tension = tension
        self.stiffness = stiffness
        self._inertance = inertance

    @property
    def inertance(self) -> Array | None:
        return self._inertance

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        return LawValue(self.tension + self.stiffness * (stretch - self.stretch), self.stiffness)

    def scaled(self, factor: Array) -> AffineLaw:
        inertance = None if self._inertance is None else factor * self._inertance
        return AffineLaw(self.stretch, factor * self.tension, factor * self.stiffness, inertance)

    def potential(self, stretch: Array) -> Array:
        change = stretch - self.stretch
        return change * (self.tension + 0.5 * self.stiffness * change)
