"""Activation that follows stimulation with first-order kinetics."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActivationKinetics, Array
from myobridge.parameters import number

__all__ = ["FirstOrder"]


@final
@attrs.frozen
class FirstOrder(ActivationKinetics):
    r"""First-order kinetics with different times for rise and decay.

    .. math:: \dot r = (u - r)/\tau, \qquad
              \tau = \tau_{rise} \text{ if } u > r, \text{ else } \tau_{decay}

    For constant stimulation u the sign of u - r never changes, so the step is exact for any dt:

    .. math:: r(t) = u + (r_0 - u) e^{-t/\tau}, \qquad
              \bar r = u + (r_0 - u) \frac{1 - e^{-t/\tau}}{t/\tau}

    Both are means of u and r0 with weights in [0, 1]: with u in [0, 1], r stays in [0, 1].

    Parameters
    ----------
    rise, decay : float
        Time constants [s].
    initial : float
        Activation at the start [-].

    Notes
    -----
    Departures: Thelen's time constants vary with the activation, tau_rise (0.5 + 1.5 r) and tau_decay / (0.5 + 1.5 r);
    here they are constant (his values at r = 1/3), which is what makes the step exact.

    References
    ----------
    .. [1] F. E. Zajac, Crit. Rev. Biomed. Eng. 17 (1989) 359-411: first-order activation dynamics.
    .. [2] D. G. Thelen, J. Biomech. Eng. 125 (2003) 70-77, Eqs. (1)-(2).
    """

    summary: ClassVar[str] = "activation follows stimulation with a time constant for rise and one for decay"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"calcium"})

    # Thelen (2003), young adults: activation 15 ms, deactivation 50 ms.
    rise: float = number(0.015, unit="s", within="(0, inf)", doc="time constant while activation grows")
    decay: float = number(0.050, unit="s", within="(0, inf)", doc="time constant while activation falls")
    initial: float = number(0.0, within="[0, 1]", doc="activation at the start")

    def initial_state(self, n_sites: int) -> Array:
        return np.full(n_sites, self.initial)

    def advance(self, state: Array, stimulation: Array, dt: float) -> tuple[Array, Array]:
        x = dt / np.where(stimulation > state, self.rise, self.decay)
        lag = state - stimulation
        # (1 - exp(-x))/x; for small x its series, exact to round-off below 1e-8 and free of 0/0.
        share = np.where(x > 1e-8, -np.expm1(-x) / np.maximum(x, 1e-8), 1.0 - 0.5 * x)
        return stimulation + lag * np.exp(-x), stimulation + lag * share


@hookimpl
def myobridge_calcium_kinetics():
    return {"first_order": FirstOrder}
