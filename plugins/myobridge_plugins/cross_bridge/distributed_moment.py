"""Distributed-moment model of Zahalak: the population as a Gaussian."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, AffineLaw, Array, CrossBridgeModel, Fluxes, Overlap, Promises
from myobridge.parameters import choice, number, part
from myobridge.threads import over_range
from myobridge_plugins.cross_bridge.isometric_law import IsometricLaw
from myobridge_plugins.cross_bridge.moment_kernels import react_euler, react_exactly, shift, steady

__all__ = ["DistributedMoment"]


@final
@attrs.frozen
class DistributedMoment(CrossBridgeModel):
    r"""Moments of the two-state model, closed by a Gaussian.

    .. math:: \dot Q_k = b_k - F_k + k\,v\,Q_{k-1}, \qquad b_k = \int q^k r f\,dq, \qquad
              F_k = \int q^k (r f + g)\,\rho_G\,dq, \qquad k = 0, 1, 2

    with the Gaussian :math:`\rho_G` of the moments Q and the rates f = f1 q on (0, 1); g = g2 for q < 0, g1 q on
    (0, 1), g1 q + g3 (q - 1) beyond. Nominal tension :math:`p_{max} Q_1/Q_1^{iso}`,
    stiffness :math:`s\,p_{max} Q_0/Q_1^{iso}`, energy per reference volume :math:`p_{max} Q_2 / (2 s\,Q_1^{iso})`.

    State: Q0, Q1, Q2, shape (n_sites, 3) [-], q in units of the reach.
    Promises: `slide` is exact. With `projection` and `extrapolated` the moments stay realizable (Q0 >= 0,
    Q0 Q2 >= Q1^2) for every step and speed; order 1 and 2 in the step. With `explicit_euler` they do not. The Gaussian
    may exceed 1, so no bounds are promised for the fraction itself.

    Parameters
    ----------
    p_max : float
        Isometric nominal tension at full activation [Pa].
    f1, g1, g2, g3 : float
        Rates [1/s].
    method : {"projection", "extrapolated", "explicit_euler"}
        How a reaction is done: the exact exponential of the two-state model applied to the Gaussian, moments in closed
        form; the same, extrapolated to order 2 where the result is realizable; explicit Euler, the baseline.
    normalisation : {"own", "huxley"}
        Whether `p_max` is the model's own isometric tension or that of the two-state model (F1/2), to compare them.
    activation_scales : {"rate", "fraction"}
        r f (1 - rho) - g rho, or f (r - rho) - g rho.
    overlap : Overlap, optional
        Scales the attachable fraction; effect `length_dependence`.
    start : {"isometric", "empty"}
        Population at the start: the isometric steady state at r = 1, or none.
    half_sarcomere_length, reach : float
        Their ratio s is the gear [m].

    Notes
    -----
    Departures: the thesis (Model 2.15) prints f - g in F_k and the opposite sign of v. Its and Zahalak's r scales
    attachment and detachment, here attachment only. With an attachable fraction c below 1 the attachment c - rho is
    kept linear (not cut off at 0), as the closure needs. The closure itself is a model error of 3 to 30 %: the
    isometric moments are (.684179, .437663, .321696) against (.812383, .406191, .270794) of the two-state model.

    References
    ----------
    .. [1] G. I. Zahalak, Math. Biosci. 55 (1981) 89-114.
    .. [2] A. F. Huxley, Prog. Biophys. 7 (1957) 255-318: rates, reach 15.6 nm, half sarcomere 1.1 um.
    """

    summary: ClassVar[str] = "population as a Gaussian, three moments a site (Zahalak 1981)"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges", "activation", "force_velocity"})
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # Huxley (1957), frog sartorius at 0 degrees C: f1, g1, g2 [1/s], no g3; h = 15.6 nm, half sarcomere 1.1 um.
        "huxley_1957": {
            "f1": 43.3, "g1": 10.0, "g2": 209.0, "g3": 0.0, "half_sarcomere_length": 1.1e-6, "reach": 15.6e-9
        },
    }  # fmt: skip

    # Heidlauf and Roehrle (2014), Table 2; also the value of the thesis.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="isometric nominal tension at full activation")
    # Huxley (1957): the set huxley_1957 above.
    f1: float = number(43.3, unit="1/s", within="(0, inf)", doc="attachment rate at q = 1")
    g1: float = number(10.0, unit="1/s", within="[0, inf)", doc="detachment rate at q = 1")
    g2: float = number(209.0, unit="1/s", within="(0, inf)", doc="detachment rate for q < 0")
    g3: float = number(0.0, unit="1/s", within="[0, inf)", doc="additional slope of the detachment rate beyond q = 1")
    method: str = choice("projection", ("projection", "extrapolated", "explicit_euler"), doc="how a reaction is done")
    normalisation: str = choice("own", ("own", "huxley"), doc="isometric tension that p_max stands for")
    activation_scales: str = choice("rate", ("rate", "fraction"), doc="what the activation scales in attachment")
    overlap: Overlap | None = part(
        "overlap", None, doc="overlap of the filaments", effect="length_dependence", on="gordon_huxley_julian"
    )
    start: str = choice("isometric", ("isometric", "empty"), doc="population at the start")
    half_sarcomere_length: float = number(1.1e-6, unit="m", within="(0, inf)", doc="length of half a sarcomere")
    reach: float = number(15.6e-9, unit="m", within="(0, inf)", doc="reach h of a head")

    @cached_property
    def _gear(self) -> float:
        return self.half_sarcomere_length / self.reach

    @cached_property
    def _rates(self) -> tuple[float, float, float, float]:
        return self.f1, self.g1, self.g2, self.g3

    @cached_property
    def _isometric(self) -> Array:
        """Own isometric moments at r = 1, shape (3,)."""
        moments = np.empty((1, 3))
        steady(np.ones(1), self._rates, moments)
        return moments[0]

    @cached_property
    def _unit(self) -> float:
        """First moment that pulls with p_max [-]."""
        huxley = 0.5 * self.f1 / (self.f1 + self.g1)
        return huxley if self.normalisation == "huxley" else float(self._isometric[1])

    @cached_property
    def _energy_unit(self) -> float:
        return 0.5 / (self._gear * self._unit)

    @property
    def gear(self) -> float:
        return self._gear

    @property
    def promises(self) -> Promises:
        explicit = self.method == "explicit_euler"
        return Promises(bounds=False, realizable=not explicit, order=2 if self.method == "extrapolated" else 1)

    def initial_state(self, n_sites: int) -> Array:
        return np.zeros((n_sites, 3)) if self.start == "empty" else np.tile(self._isometric, (n_sites, 1))

    def _attachment(self, activation: Array, stretch: Array) -> tuple[Array, Array]:
        """Factor of the attachment rate and attachable fraction, each (n_sites,)."""
        ones = np.ones(activation.size)
        capacity = ones if self.overlap is None else self.overlap.fraction(stretch)
        return (activation, capacity) if self.activation_scales == "rate" else (ones, activation * capacity)

    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        out = np.empty_like(state) if out is None else out
        rate, capacity = self._attachment(activation, stretch)
        fluxes, rates, unit = np.empty((4, activation.size)), self._rates, self._energy_unit

        def part(first: int, last: int) -> None:
            i, here = slice(first, last), np.empty((4, last - first))
            if self.method == "explicit_euler":
                react_euler(state[i], rate[i], capacity[i], dt, rates, unit, out[i], here)
            else:
                extrapolate = self.method == "extrapolated"
                react_exactly(state[i], rate[i], capacity[i], dt, rates, extrapolate, unit, out[i], here)
            fluxes[:, i] = here

        over_range(activation.size, part)
        return out, Fluxes(*fluxes)

    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        out = np.empty_like(state) if out is None else out
        shift(state, displacement, out)
        return out

    def active_law(self, state: Array, activation: Array, stretch: Array) -> ActiveLaw:
        unit = self._unit
        return AffineLaw(stretch, state[:, 1] * (1.0 / unit), state[:, 0] * (self._gear / unit))

    def steady_law(self, activation: Array, stretch: Array) -> ActiveLaw:
        """Isometric steady tension; the closure is homogeneous, so the overlap is a factor, exactly."""
        if self.activation_scales == "fraction":
            return IsometricLaw(activation * (self._isometric[1] / self._unit), self.overlap)
        # Each is found by iteration, and sites mostly share their activation.
        distinct, where = np.unique(activation, return_inverse=True)
        moments = np.empty((distinct.size, 3))
        steady(distinct, self._rates, moments)
        return IsometricLaw(moments[where, 1] / self._unit, self.overlap)

    def moments(self, state: Array) -> Array:
        return state.copy()

    def energy(self, state: Array) -> Array:
        return state[:, 2] * self._energy_unit

    def density(self, state: Array) -> tuple[Array, Array]:
        """Positions [reach] within four standard deviations and the Gaussian there, each (n_sites, 81)."""
        heads = np.maximum(state[:, :1], np.finfo(float).tiny)
        mean = state[:, 1:2] / heads
        width = np.sqrt(np.maximum(state[:, 2:3] / heads - mean**2, 1e-16))
        away = np.linspace(-4.0, 4.0, 81)
        return mean + width * away, state[:, :1] * np.exp(-0.5 * away**2) / (width * np.sqrt(2.0 * np.pi))


@hookimpl
def myobridge_cross_bridges():
    return {"distributed_moment": DistributedMoment}
