"""Prescribed active tension: the activation signal is the tension."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, Array, CrossBridgeModel, Fluxes, Promises
from myobridge.parameters import number
from myobridge_plugins.cross_bridge.isometric_law import IsometricLaw

__all__ = ["Prescribed"]


@final
@attrs.frozen
class Prescribed(CrossBridgeModel):
    r"""Tension given as a function of time.

    .. math:: T(t) = p_{max}\,r(t)

    There is no population: the tension depends neither on stretch nor on rate, and stores no energy.

    State: none, shape (n_sites, 0). `moments` are zero.

    Parameters
    ----------
    p_max : float
        Nominal tension at activation 1 [Pa].
    """

    summary: ClassVar[str] = "tension r(t) p_max, whatever the stretch; no state"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges", "activation"})
    has_energy: ClassVar[bool] = False

    # Heidlauf and Roehrle (2014), Table 2; also the value of the thesis.
    p_max: float = number(73e3, unit="Pa", within="(0, inf)", doc="nominal tension at activation 1")

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
        return IsometricLaw(activation)

    def steady_law(self, activation: Array, stretch: Array) -> ActiveLaw:
        return IsometricLaw(activation)

    def moments(self, state: Array) -> Array:
        return np.zeros((len(state), 3))


@hookimpl
def myobridge_cross_bridges():
    return {"prescribed": Prescribed}
