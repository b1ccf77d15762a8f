"""One-state population: attached heads that are carried and never let go."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, AffineLaw, Array, CrossBridgeModel, Fluxes, Promises
from myobridge.parameters import number
from myobridge_plugins.cross_bridge.moment_kernels import shift

__all__ = ["Liouville"]


@final
@attrs.frozen
class Liouville(CrossBridgeModel):
    r"""Liouville equation of attached heads, without attachment and detachment.

    .. math:: \partial_t \rho + v\,\partial_q \rho = 0

    The density is constant in the frame that rides with the filament, so for a displacement x

    .. math:: Q_0' = Q_0, \qquad Q_1' = Q_1 + x Q_0, \qquad Q_2' = Q_2 + 2 x Q_1 + x^2 Q_0

    exactly: tension is affine and the population a quadratic potential in the stretch. Coupled to a hyperelastic solid
    the system is Hamiltonian, which makes this the reference for energy conservation.

    .. math:: T = p_{max} Q_1 / Q_1^{iso}, \qquad dT/d\lambda = s\,p_{max} Q_0 / Q_1^{iso}, \qquad
              E = p_{max} Q_2 / (2 s\,Q_1^{iso})

    State: Q0, Q1, Q2, shape (n_sites, 3) [-], q in units of the reach.
    Promises: `slide` is exact for any displacement. There is no reaction, hence no steady state and no statics; the
    activation does not act, since nothing attaches.

    Parameters
    ----------
    p_max : float
        Nominal tension of the initial population with default values [Pa].
    attached, mean, width : float
        Q0 of the initial population [-], mean and standard deviation of its displacements [reach]; the default is the
        isometric population of Huxley (1957), F1 on (0, 1).
    isometric_moment : float
        First moment that pulls with `p_max` [-].
    half_sarcomere_length, reach : float
        Their ratio s is the gear [m].

    References
    ----------
    .. [1] The thesis, Model 3.12 (mixed Euler-Lagrange and Liouville equations).
    .. [2] A. F. Huxley, Prog. Biophys. 7 (1957) 255-318.
    """

    summary: ClassVar[str] = "attached heads are carried, none attaches or detaches: a quadratic potential"
    has_statics: ClassVar[bool] = False

    # Heidlauf and Roehrle (2014), Table 2; also the value of the thesis.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="nominal tension of the isometric population")
    # Huxley (1957): F1 = f1 / (f1 + g1) with 43.3 and 10 1/s, uniform on (0, 1).
    attached: float = number(43.3 / 53.3, within="[0, inf)", doc="attached fraction integrated over q, Q0")
    mean: float = number(0.5, unit="reach", doc="mean displacement of the attached heads")
    width: float = number(math.sqrt(1.0 / 12.0), unit="reach", within="[0, inf)", doc="standard deviation of it")
    isometric_moment: float = number(43.3 / 106.6, within="(0, inf)", doc="first moment that pulls with p_max")
    half_sarcomere_length: float = number(1.1e-6, unit="m", within="(0, inf)", doc="length of half a sarcomere")
    reach: float = number(15.6e-9, unit="m", within="(0, inf)", doc="reach h of a head")

    @cached_property
    def _gear(self) -> float:
        return self.half_sarcomere_length / self.reach

    @property
    def gear(self) -> float:
        return self._gear

    @property
    def promises(self) -> Promises:
        return Promises(order=2)

    def initial_state(self, n_sites: int) -> Array:
        moments = np.array([1.0, self.mean, self.mean**2 + self.width**2])
        return np.tile(self.attached * moments, (n_sites, 1))

    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        if out is None:
            out = state.copy()
        elif out is not state:
            out[...] = state
        return out, Fluxes.zero(len(state))

    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        out = np.empty_like(state) if out is None else out
        shift(state, displacement, out)
        return out

    def active_law(self, state: Array, activation: Array, stretch: Array) -> ActiveLaw:
        return AffineLaw(
            stretch,
            state[:, 1] * (1.0 / self.isometric_moment),
            state[:, 0] * (self._gear / self.isometric_moment),
        )

    def moments(self, state: Array) -> Array:
        return state.copy()

    def energy(self, state: Array) -> Array:
        return state[:, 2] * (0.5 / (self._gear * self.isometric_moment))


@hookimpl
def myobridge_cross_bridges():
    return {"liouville": Liouville}
