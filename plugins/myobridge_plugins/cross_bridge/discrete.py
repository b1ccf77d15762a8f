"""Single heads at every site, tied to the filament by constraints."""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, AffineLaw, Array, CrossBridgeModel, Fluxes, Promises
from myobridge.parameters import choice, integer, number

__all__ = ["Discrete"]


@final
@attrs.frozen
class Discrete(CrossBridgeModel):
    r"""N attached heads a site, each a spring with mass that must follow the filament.

    .. math:: q_i = q_f + c_i, \qquad \mu_i = \kappa q_i + m\,\ddot q_f

    The constraint fixes all heads to the filament, so they slide together; its multiplier :math:`\mu_i` is the force
    that head i puts on the filament. With :math:`q_f = \ell\,\lambda` (half sarcomere :math:`\ell`), gear
    :math:`s = \ell/h`, and the density of heads chosen so that the isometric tension is p_max,

    .. math:: T = \frac{p_{max}}{Q_1^{iso}} \left(Q_1 + s\,Q_0\,\frac{m}{\kappa}\,\ddot\lambda\right), \qquad
              \frac{dT}{d\lambda} = \frac{p_{max}}{Q_1^{iso}}\,s\,Q_0, \qquad
              I = \frac{m}{\kappa}\,\frac{dT}{d\lambda}, \qquad
              Q_k = \frac{Q_0}{N} \sum_i q_i^k \;[q \text{ in } h]

    so the inertance I [Pa s^2] is the stiffness times m/kappa. As N grows the model converges
    to the Liouville equation (`liouville`): stratified heads with 1/N^2, random ones with 1/sqrt(N).

    State: displacement of each head, shape (n_sites, heads) [reach].
    Promises: `slide` is exact. No head lets go, so there is no steady state and no statics, and the activation does not
    act.

    Parameters
    ----------
    p_max : float
        Nominal tension of the isometric population [Pa].
    heads : int
        Heads at a site, N.
    sampling : {"stratified", "random"}
        Midpoints of N equal parts of the initial density, or drawn from it anew at each site.
    seed : int
        Seed of the random sample; the first sites of a larger sample are those of a smaller one.
    attached, mean, width : float
        Q0 [-], mean and standard deviation [reach] of the uniform density that is sampled.
    head_mass, head_stiffness : float
        m [kg] and kappa [N/m] of a head; only their ratio acts. Effect `cross_bridge_mass`.
    isometric_moment : float
        First moment that pulls with `p_max` [-].
    half_sarcomere_length, reach : float
        Their ratio s is the gear [m].

    Notes
    -----
    Departures: the thesis prints a minus sign before the mass in Eq. (3.13), against its own Eq. (3.6); plus is right.

    References
    ----------
    .. [1] The thesis, Models 3.1-3.5, Eqs. (3.4)-(3.7).
    """

    summary: ClassVar[str] = "single heads as springs, with or without mass, that follow the filament"
    has_statics: ClassVar[bool] = False

    # Heidlauf and Roehrle (2014), Table 2; also the value of the thesis.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="nominal tension of the isometric population")
    heads: int = integer(64, within="[1, inf)", doc="heads at a site")
    sampling: str = choice("stratified", ("stratified", "random"), doc="how heads are placed in the density")
    seed: int = integer(0, doc="seed of the random sample")
    # Huxley (1957): F1 = f1 / (f1 + g1) with 43.3 and 10 1/s, uniform on (0, 1).
    attached: float = number(43.3 / 53.3, within="[0, inf)", doc="attached fraction integrated over q, Q0")
    mean: float = number(0.5, unit="reach", doc="mean displacement of the attached heads")
    width: float = number(math.sqrt(1.0 / 12.0), unit="reach", within="[0, inf)", doc="standard deviation of it")
    # 2.2e-22 kg: a head (subfragment 1) of 130 kDa at 1.66e-27 kg a dalton, Rayment et al., Science 261 (1993) 50-58.
    head_mass: float = number(
        0.0, unit="kg", within="[0, inf)", doc="mass of a head", effect="cross_bridge_mass", on=2.2e-22
    )
    # 1.79 pN/nm, single heads in rigor: Lewalle et al., Biophys. J. 94 (2008) 2160-2169.
    head_stiffness: float = number(1.79e-3, unit="N/m", within="(0, inf)", doc="stiffness of a head")
    isometric_moment: float = number(43.3 / 106.6, within="(0, inf)", doc="first moment that pulls with p_max")
    half_sarcomere_length: float = number(1.1e-6, unit="m", within="(0, inf)", doc="length of half a sarcomere")
    reach: float = number(15.6e-9, unit="m", within="(0, inf)", doc="reach h of a head")

    @cached_property
    def _gear(self) -> float:
        return self.half_sarcomere_length / self.reach

    @cached_property
    def _stiffness(self) -> float:
        """d tension / d stretch in units of p_max [-]; the same at every site and time, since no head lets go."""
        return self._gear * self.attached / self.isometric_moment

    @property
    def gear(self) -> float:
        return self._gear

    @property
    def promises(self) -> Promises:
        return Promises(order=2)

    def initial_state(self, n_sites: int) -> Array:
        if self.sampling == "random":
            place = np.random.default_rng(self.seed).random((n_sites, self.heads))
        else:
            place = np.tile((np.arange(self.heads) + 0.5) / self.heads, (n_sites, 1))
        return self.mean + math.sqrt(12.0) * self.width * (place - 0.5)

    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        if out is None:
            out = state.copy()
        elif out is not state:
            out[...] = state
        return out, Fluxes.zero(len(state))

    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        return np.add(state, displacement[:, None], out=out)

    def active_law(self, state: Array, activation: Array, stretch: Array) -> ActiveLaw:
        tension = np.add.reduce(state, axis=1) * (self.attached / (self.heads * self.isometric_moment))
        stiffness = 0.0 * tension + self._stiffness
        inertance = stiffness * (self.head_mass / self.head_stiffness) if self.head_mass else None
        return AffineLaw(stretch, tension, stiffness, inertance)

    def moments(self, state: Array) -> Array:
        ones = np.ones_like(state)
        return np.stack([np.mean(power, axis=1) for power in (ones, state, state * state)], axis=1) * self.attached

    def energy(self, state: Array) -> Array:
        squares = np.einsum("ij,ij->i", state, state)
        return squares * (self.attached / (2.0 * self.heads * self._gear * self.isometric_moment))


@hookimpl
def myobridge_cross_bridges():
    return {"discrete": Discrete}
