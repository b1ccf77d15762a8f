"""Hill's three-factor model: activation, length and velocity."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numba
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, Array, CrossBridgeModel, Fluxes, LawValue, Overlap, Promises
from myobridge.parameters import flag, number, part
from myobridge_plugins.cross_bridge.isometric_law import IsometricLaw

__all__ = ["Hill", "HillLaw"]


@final
@attrs.frozen
class Hill(CrossBridgeModel):
    r"""Hill-type model: the product of activation, force-length and force-velocity relation.

    .. math:: T = p_{max}\, r\, f_l(\lambda)\, f_v(w), \qquad w = \dot\lambda / v_{max}

    .. math:: f_v = \begin{cases} 0 & w \le -1 \\ (1 + w) / (1 - w/A) & -1 < w \le 0 \quad\text{(shortening)} \\
              (1 + c F w) / (1 + c w) & w > 0 \quad\text{(lengthening)} \end{cases},
              \qquad c = \frac{1 + 1/A}{F - 1}

    :math:`f_v(-1) = 0`, :math:`f_v(0) = 1`, :math:`f_v \to F` for fast lengthening, and the slope
    :math:`1 + 1/A` is the same on both sides of w = 0. Without the effect `force_velocity` it is 1, without
    `length_dependence` :math:`f_l` is 1.

    State: none, shape (n_sites, 0). The law depends on the rate, so it has no potential: its work on the tissue is
    booked as active work. `moments` are zero.

    Parameters
    ----------
    p_max : float
        Isometric nominal tension at full activation [Pa].
    force_velocity : bool
        Effect `force_velocity`.
    overlap : Overlap, optional
        Force-length relation; effect `length_dependence`.
    max_rate : float
        Stretch rate of unloaded shortening v_max [1/s].
    curvature : float
        Hill's a/P0, here A [-]; smaller is more curved.
    eccentric_limit : float
        Tension of very fast lengthening over the isometric one, F [-].

    Notes
    -----
    Departures from Thelen: v_max does not depend on the activation, and the lengthening branch begins with the slope of
    the shortening branch instead of twice it, so that the tangent of a solid is continuous at rest.

    References
    ----------
    .. [1] A. V. Hill, Proc. R. Soc. B 126 (1938) 136-195.
    .. [2] D. G. Thelen, J. Biomech. Eng. 125 (2003) 70-77, Eqs. (6)-(7): A = 0.25, F = 1.4, v_max = 10 optimal fibre
       lengths a second (young adults).
    """

    summary: ClassVar[str] = "activation times force-length times force-velocity; no state (Hill 1938, Thelen 2003)"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges", "activation"})
    has_energy: ClassVar[bool] = False

    # Heidlauf and Roehrle (2014), Table 2; also the value of the thesis.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="isometric nominal tension at full activation")
    force_velocity: bool = flag(
        False, doc="whether tension depends on the stretch rate", effect="force_velocity", on=True
    )
    overlap: Overlap | None = part(
        "overlap", None, doc="force-length relation", effect="length_dependence", on="gaussian"
    )
    # Thelen (2003): 10 optimal fibre lengths a second, young adults.
    max_rate: float = number(10.0, unit="1/s", within="(0, inf)", doc="stretch rate of unloaded shortening")
    # Thelen (2003), Eq. (7): force-velocity shape factor 0.25; Hill (1938) measured a/P0 = 0.25 in frog sartorius.
    curvature: float = number(0.25, within="(0, inf)", doc="a/P0 of Hill; smaller is more curved")
    # Thelen (2003): 1.4 for young adults.
    eccentric_limit: float = number(1.4, within="(1, inf)", doc="tension of fast lengthening over isometric tension")

    @property
    def promises(self) -> Promises:
        return Promises(order=0)

    def initial_state(self, n_sites: int) -> Array:
        return np.empty((n_sites, 0))

    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        return (state.copy() if out is None else out), Fluxes.zero(len(state))

    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        return state.copy() if out is None else out

    def active_law(self, state: Array, activation: Array, stretch: Array) -> ActiveLaw:
        return HillLaw(activation, self) if self.force_velocity else IsometricLaw(activation, self.overlap)

    def steady_law(self, activation: Array, stretch: Array) -> ActiveLaw:
        return IsometricLaw(activation, self.overlap)

    def moments(self, state: Array) -> Array:
        return np.zeros((len(state), 3))

    def force_velocity_factor(self, stretch_rate: Array) -> tuple[Array, Array]:
        """Factor f_v [-] and its derivative by the stretch rate [s], each the shape of `stretch_rate` [1/s]."""
        factor, derivative = np.empty_like(stretch_rate), np.empty_like(stretch_rate)
        _force_velocity(stretch_rate, self.max_rate, self.curvature, self.eccentric_limit, factor, derivative)
        return factor, derivative


@numba.njit(cache=True)
def _force_velocity(stretch_rate, max_rate, curvature, limit, factor, derivative):
    slope = 1.0 + 1.0 / curvature
    gain = slope / (limit - 1.0)
    for i in range(stretch_rate.size):
        w = stretch_rate[i] / max_rate
        if w > 0.0:
            below = 1.0 + gain * w
            factor[i] = (1.0 + gain * limit * w) / below
            derivative[i] = slope / (below * below * max_rate)
        elif w >= -1.0:
            below = 1.0 - w / curvature
            factor[i] = (1.0 + w) / below
            derivative[i] = slope / (below * below * max_rate)
        else:
            factor[i] = derivative[i] = 0.0


@final
class HillLaw(ActiveLaw):
    r"""Law of a `Hill` model with force-velocity relation.

    .. math:: T = T_0\,f_l(\lambda)\,f_v(\dot\lambda / v_{max})

    Parameters
    ----------
    strength : ndarray, shape (n_sites,)
        Isometric tension at full overlap, nominal [-], positive in tension.
    model : Hill
        Supplies the two relations.
    """

    __slots__ = ("model", "strength")

    def __init__(self, strength: Array, model: Hill) -> None:
        self.strength = strength
        self.model = model

    def evaluate(self, stretch: Array, stretch_rate: Array) -> LawValue:
        factor, sensitivity = self.model.force_velocity_factor(stretch_rate)
        overlap = self.model.overlap
        if overlap is None:
            return LawValue(self.strength * factor, np.zeros_like(stretch), self.strength * sensitivity)
        isometric = self.strength * overlap.fraction(stretch)
        return LawValue(
            isometric * factor, self.strength * overlap.derivative(stretch) * factor, isometric * sensitivity
        )

    def scaled(self, factor: Array) -> HillLaw:
        return HillLaw(factor * self.strength, self.model)


@hookimpl
def myobridge_cross_bridges():
    return {"hill": Hill}
