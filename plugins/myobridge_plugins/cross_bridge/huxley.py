"""Two-state cross-bridge model of Huxley (1957)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import AffineLaw, Array, CrossBridgeModel, Fluxes, Overlap, Promises
from myobridge.parameters import choice, integer, number, part
from myobridge_plugins.cross_bridge.discretisation import Discretisation
from myobridge_plugins.cross_bridge.huxley_euler import MovingFrameEuler
from myobridge_plugins.cross_bridge.huxley_exact import Exact
from myobridge_plugins.cross_bridge.huxley_upwind import Upwind
from myobridge_plugins.cross_bridge.rates import Rates

__all__ = ["Huxley"]

_DISCRETISATIONS: Mapping[str, type[Discretisation]] = {
    "exact": Exact,
    "upwind": Upwind,
    "moving_frame_euler": MovingFrameEuler,
}
_WHOLE = np.ones(1)


@final
@attrs.frozen(kw_only=True)
class Huxley(CrossBridgeModel):
    r"""Two-state model: every head is attached, with displacement `q`, or not.

    .. math::
        \partial_t \rho + v\,\partial_q \rho = k f(q)\,(a - \rho)^+ - g(q)\,\rho, \qquad
        \tau = \frac{Q_1}{Q_1^{iso}}, \quad \frac{d\tau}{d\lambda} = s \frac{Q_0}{Q_1^{iso}}, \quad
        \frac{E}{p_{max}} = \frac{Q_2}{2 s Q_1^{iso}}

    with the attached fraction :math:`\rho(q, t)` in [0, 1], `q` in units of the reach, `v` the sliding speed [1/s],
    the gear :math:`s = l_{hs}/h` and :math:`Q_k = \int q^k \rho\,dq`. Activation `r` scales the rate of attachment,
    :math:`k=r,\ a=o`, or the attachable fraction, :math:`k=1,\ a=r o`; `o` is the filament overlap. Tension is
    nominal; it is 1 (that is, `p_max`) in the isometric steady state at full activation and overlap.

    State: see the discretisation; shape (n_sites, m).
    Promises: those of the discretisation; "exact" keeps bounds for every step and shifts the moments exactly.
    Departures: the source has full activation and overlap only. The thesis lets activation scale detachment too, so
    that its isometric tension does not depend on it; here it scales attachment alone.

    References
    ----------
    .. [1] A. F. Huxley, Prog. Biophys. Biophys. Chem. 7 (1957) 255-318.
    """

    summary: ClassVar[str] = "two-state population of Huxley (1957), resolved in the displacement of its heads"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges", "activation", "force_velocity"})
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # Huxley (1957): f1 = 43.3, g1 = 10, g2 = 209 [1/s], h = 15.6 nm; half-sarcomere 1.1 um.
        "huxley_1957": {
            "f1": 43.3,
            "g1": 10.0,
            "g2": 209.0,
            "g3": 0.0,
            "reach": 15.6e-9,
            "half_sarcomere_length": 1.1e-6,
        },
    }

    # Heidlauf and Roehrle, Front. Physiol. 5 (2014) 498, Table 2.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="isometric nominal tension at full activation")
    f1: float = number(43.3, unit="1/s", within="(0, inf)", doc="rate of attachment at q = h")
    g1: float = number(10.0, unit="1/s", within="[0, inf)", doc="rate of detachment at q = h")
    g2: float = number(209.0, unit="1/s", within="[0, inf)", doc="rate of detachment of compressed heads, q < 0")
    g3: float = number(0.0, unit="1/s", within="[0, inf)", doc="further rate of detachment a reach beyond q = h")
    reach: float = number(15.6e-9, unit="m", within="(0, inf)", doc="reach h of a head")
    half_sarcomere_length: float = number(1.1e-6, unit="m", within="(0, inf)", doc="length of a half sarcomere at rest")
    bins: int = integer(32, within="[8, 4096]", doc="cells a reach")
    low: float = number(-6.0, unit="h", within="(-inf, -1]", doc="lower end of the window; heads beyond are lost")
    high: float = number(14.0, unit="h", within="[2, inf)", doc="upper end of the window; heads beyond are lost")
    discretisation: str = choice("exact", tuple(_DISCRETISATIONS), doc="how the equation is solved")
    start: str = choice("isometric", ("isometric", "empty"), doc="population at the start")
    activation_scales: str = choice(
        "rate", ("rate", "fraction"), doc="what activation scales: rate of attachment, or attachable fraction"
    )
    overlap: Overlap | None = part(
        "overlap",
        default=None,
        effect="length_dependence",
        on="gordon_huxley_julian",
        doc="filament overlap, scales the attachable fraction",
    )
    _scheme: Discretisation = attrs.field(init=False, eq=False, repr=False)
    _per_tension: float = attrs.field(init=False, eq=False, repr=False)

    @_per_tension.default  # pyright: ignore[reportAttributeAccessIssue]
    def _default_per_tension(self) -> float:
        return 2.0 * (self.f1 + self.g1) / self.f1

    @_scheme.default  # pyright: ignore[reportAttributeAccessIssue]
    def _default_scheme(self) -> Discretisation:
        return _DISCRETISATIONS[self.discretisation](
            rates=self.rates,
            bins=self.bins,
            low=self.low,
            high=self.high,
            filled=self.start == "isometric",
            by_rate=self.activation_scales == "rate",
            scale=2.0 * (self.f1 + self.g1) / (self.f1 * self.gear),
        )

    @property
    def rates(self) -> Rates:
        """Rates of attachment and detachment, with their closed forms."""
        return Rates(self.f1, self.g1, self.g2, self.g3)

    @property
    def gear(self) -> float:
        """Displacement of the heads per stretch, half-sarcomere length over reach [-]."""
        return self.half_sarcomere_length / self.reach

    @property
    def promises(self) -> Promises:
        return self._scheme.promises

    def initial_state(self, n_sites: int) -> Array:
        return self._scheme.initial_state(n_sites)

    def _overlap(self, stretch: Array) -> Array:
        return _WHOLE if self.overlap is None else self.overlap.fraction(stretch)

    def react(
        self, state: Array, activation: Array, stretch: Array, dt: float, out: Array | None = None
    ) -> tuple[Array, Fluxes]:
        return self._scheme.react(state, activation, self._overlap(stretch), dt, out)

    def slide(self, state: Array, displacement: Array, out: Array | None = None) -> Array:
        return self._scheme.slide(state, displacement, out)

    def slide_and_gain(self, state: Array, displacement: Array, out: Array | None = None) -> tuple[Array, Array]:
        done = self._scheme.slide_and_gain(state, displacement, out)
        return super().slide_and_gain(state, displacement, out) if done is None else done

    def advance(
        self,
        state: Array,
        activation: Array,
        stretch0: Array,
        stretch1: Array,
        dt: float,
        out: Array | None = None,
    ) -> tuple[Array, Fluxes]:
        """The whole path at once; "exact" solves it at constant speed with the overlap of the middle stretch."""
        overlap = _WHOLE if self.overlap is None else self._overlap(0.5 * (stretch0 + stretch1))
        done = self._scheme.advance(state, activation, overlap, self.gear * (stretch1 - stretch0), dt, out)
        return super().advance(state, activation, stretch0, stretch1, dt, out) if done is None else done

    def active_law(self, state: Array, activation: Array, stretch: Array) -> AffineLaw:
        Q = self._scheme.moments(state)
        return AffineLaw(stretch, self._per_tension * Q[:, 1], self._per_tension * self.gear * Q[:, 0])

    def moments(self, state: Array) -> Array:
        return self._scheme.moments(state)

    def energy(self, state: Array) -> Array:
        return 0.5 * self._scheme.scale * self._scheme.moments(state)[:, 2]

    def steady_law(self, activation: Array, stretch: Array) -> AffineLaw:
        r"""Isometric steady tension and its slope through the overlap, at `stretch`.

        .. math:: \tau = \frac{k f_1 a}{k f_1 + g_1} \Big/ \frac{f_1}{f_1 + g_1}
        """
        by_rate = self.activation_scales == "rate"
        k = activation if by_rate else 1.0
        scale = k * (self.f1 + self.g1) / np.maximum(k * self.f1 + self.g1, 1e-300)
        scale = scale if by_rate else scale * activation
        if self.overlap is None:
            tension = scale * np.ones_like(stretch)
            return AffineLaw(stretch, tension, np.zeros_like(tension))
        return AffineLaw(stretch, scale * self.overlap.fraction(stretch), scale * self.overlap.derivative(stretch))

    def density(self, state: Array) -> tuple[Array, Array]:
        return self._scheme.density(state)


@hookimpl
def myobridge_cross_bridges() -> Mapping[str, type[CrossBridgeModel]]:
    """The model of this file."""
    return {"huxley": Huxley}
