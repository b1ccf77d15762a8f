r"""Cross-bridge model: what a population of myosin heads does at every site.

Two things happen to a population, and a model says both apart, because the coupling lives on the difference:

* it **reacts**, :math:`\partial_t \rho = r f (1-\rho) - g \rho`: heads attach and detach, filaments held;
* it **slides**, :math:`\partial_t \rho + v\,\partial_q \rho = 0`: heads are carried, none attaches.

Work-conjugate scaling (`p` = isometric tension, `s` = gear, :math:`\rho_{sc}` = sarcomere density):

.. math:: T = p\,\rho_{sc}\,\tau, \qquad
          \frac{dT}{d\lambda} = p\,\rho_{sc}\,\frac{d\tau}{d\lambda}, \qquad
          \frac{dE}{dt}\Big|_{slide} = T\,\dot\lambda .

A model states tension and energy **in units of its isometric tension** ``p_max`` (so its isometric tension at full
activation is 1); the bus multiplies by `p_max` and by the local sarcomere density, and turns a change of stretch into
a displacement of the heads, ``displacement = gear * change``.

Shapes: `n` sites, `m` state values a site; state ``(n, m)``, float64, C-contiguous. `activation`, `stretch` and
`displacement` are ``(n,)``. Displacements are in units of the reach `h` of a head; lengthening is positive.
All methods are pure: they read `state` and return the new one. Where an `out` is offered the result is written
there (``out is state`` is allowed), so that the owner of the state can reuse its memory.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

import attrs
import numpy as np

from myobridge.interfaces.active_law import ActiveLaw, Array

__all__ = ["CrossBridgeModel", "Fluxes", "Promises"]


class Fluxes(NamedTuple):
    """Energy that a population gained and lost, per reference volume and isometric tension [-].

    Attributes
    ----------
    attached : ndarray, shape (n_sites,)
        Energy brought in by heads that attached.
    detached : ndarray, shape (n_sites,)
        Energy taken away by heads that detached.
    work : ndarray, shape (n_sites,)
        Work done on the population by sliding, the path integral of tension over stretch.
    numerical : ndarray, shape (n_sites,)
        Energy gained by the discretisation alone (interpolation, diffusion, heads lost at the window's edge).
    """

    attached: Array
    detached: Array
    work: Array
    numerical: Array

    def plus(self, other: Fluxes) -> Fluxes:
        """Sum of two fluxes, entry by entry."""
        return Fluxes(
            self.attached + other.attached,
            self.detached + other.detached,
            self.work + other.work,
            self.numerical + other.numerical,
        )

    @classmethod
    def zero(cls, n_sites: int) -> Fluxes:
        """No flux at any site."""
        nothing: Array = np.zeros(n_sites)
        return cls(nothing, nothing, nothing, nothing)


@attrs.frozen
class Promises:
    """What a model declares of itself; the contract checks hold it to each.

    Attributes
    ----------
    bounds : bool
        The attached fraction stays in [0, 1] for every step, speed and activation.
    conserves_heads : bool
        `slide` keeps Q0 to round-off.
    realizable : bool
        Q0 >= 0 and Q0 Q2 >= Q1^2 for every step.
    exact_slide : bool
        `slide` changes the energy by exactly the work of the active law.
    order : int
        Order of `advance` in the step on a smooth path; 0 where none is promised (a model without time, a scheme
        whose error is that of its grid).
    largest_step : float
        Largest step [s] of `react` and of `advance` for which the promises hold; larger ones are taken, and break them.
    """

    bounds: bool = True
    conserves_heads: bool = True
    realizable: bool = True
    exact_slide: bool = True
    order: int = 2
    largest_step: float = float("inf")


class CrossBridgeModel(ABC):
    """Abstract cross-bridge model; parameters are the attributes of a frozen class, state is an argument.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    inherent_effects : frozenset of str
        Effects that are always there. Optional ones are tied to a parameter, see `myobridge.parameters`.
    has_energy : bool
        Whether tension derives from stored energy, that is, whether `energy` and the law's potential exist.
    has_statics : bool
        Whether an isometric steady state exists (`steady_law`).
    """

    summary: ClassVar[str] = ""
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges"})
    has_energy: ClassVar[bool] = True
    has_statics: ClassVar[bool] = True

    @property
    @abstractmethod
    def p_max(self) -> float:
        """Isometric nominal tension at full activation, full overlap and sarcomere density 1 [Pa]."""

    @property
    def gear(self) -> float:
        """Displacement of the heads per stretch, half-sarcomere length over reach [-]."""
        return 1.0

    @property
    def promises(self) -> Promises:
        """What the contract checks hold this model to."""
        return Promises()

    @abstractmethod
    def initial_state(self, n_sites: int) -> Array:
        """State at the start, shape (n_sites, m)."""

    @abstractmethod
    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        """Attach and detach for `dt` seconds with the filaments held at `stretch`."""

    @abstractmethod
    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        """Carry the heads by `displacement` [reach]; none attaches or detaches."""

    def slide_and_gain(self, state: Array, displacement: Array, out: Array | None = None) -> tuple[Array, Array]:
        """`slide`, and the energy that each site gained by it, in units of `p_max` [-], shape (n_sites,).

        The default asks for the energy before and after; a model that has it at hand saves two passes over its state.
        """
        before = self.energy(state)
        slid = self.slide(state, displacement, out)
        return slid, self.energy(slid) - before

    @abstractmethod
    def active_law(self, state: Array, activation: Array, stretch: Array) -> ActiveLaw:
        """Law of the frozen population, expanded at `stretch`; tension in units of `p_max` [-]."""

    @abstractmethod
    def moments(self, state: Array) -> Array:
        r"""Moments :math:`Q_k = \int q^k \rho\,dq`, k = 0, 1, 2; shape (n_sites, 3)."""

    def energy(self, state: Array) -> Array:
        """Stored energy per reference volume in units of `p_max` [-], shape (n_sites,)."""
        return np.zeros(len(state))

    def advance(
        self,
        state: Array,
        activation: Array,
        stretch0: Array,
        stretch1: Array,
        dt: float,
        out: Array | None = None,
    ) -> tuple[Array, Fluxes]:
        """The whole path at once: stretch goes from `stretch0` to `stretch1` at constant rate in `dt` seconds.

        The default splits it: half the reaction, the slide, half the reaction (order 2).
        """
        state, first = self.react(state, activation, stretch0, 0.5 * dt, out)
        law = self.active_law(state, activation, stretch0)
        before = self.energy(state)
        state = self.slide(state, self.gear * (stretch1 - stretch0), out)
        change = self.energy(state) - before
        work = law.potential(stretch1)
        zero = np.zeros_like(change)
        slid = Fluxes(zero, zero, zero, zero) if work is None else Fluxes(zero, zero, work, change - work)
        state, last = self.react(state, activation, stretch1, 0.5 * dt, out)
        return state, first.plus(slid).plus(last)

    def steady_law(self, activation: Array, stretch: Array) -> ActiveLaw:
        """Isometric steady tension, for statics without time (a frozen population would drag the solid).

        Raises
        ------
        MyobridgeError
            If the model has no isometric steady state.
        """
        from myobridge.errors import PluginError

        raise PluginError(f"{type(self).__name__} has no isometric steady state, so it cannot be used in statics.")

    def density(self, state: Array) -> tuple[Array, Array] | None:
        """Positions q [reach] and attached fraction, each (n_sites, n_points), for pictures; None without."""
        return None
