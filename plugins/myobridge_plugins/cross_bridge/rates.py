r"""Rates of attachment and detachment of the two-state model, and what follows from them in closed form."""

from __future__ import annotations

import math
from typing import final

import attrs
import numpy as np
from scipy.special import dawsn, erf, erfcx

from myobridge.interfaces import Array

__all__ = ["Rates"]


@final
@attrs.frozen
class Rates:
    r"""Piecewise linear rates of Huxley (1957), `q` in units of the reach of a head.

    .. math::
        f(q) = f_1 q \;(0<q<1), \quad 0 \text{ else}; \qquad
        g(q) = g_2 \;(q<0), \quad g_1 q \;(0<q<1), \quad g_1 q + g_3 (q-1) \;(q>1)

    Activation `r` in [0, 1] scales attachment only: :math:`c = r f_1 + g_1`, :math:`F = r f_1 / c`.

    Parameters
    ----------
    f1, g1, g2, g3 : float
        Rates [1/s], not negative.

    References
    ----------
    .. [1] A. F. Huxley, Prog. Biophys. Biophys. Chem. 7 (1957) 255-318.
    .. [2] G. I. Zahalak, Math. Biosci. 55 (1981) 89-114: the term in `g3`.
    """

    f1: float = 43.3
    g1: float = 10.0
    g2: float = 209.0
    g3: float = 0.0

    def attachment(self, q: Array) -> Array:
        """Rate of attachment f(q) at full activation [1/s], same shape as `q`."""
        return np.where((q > 0.0) & (q < 1.0), self.f1 * q, 0.0)

    def detachment(self, q: Array) -> Array:
        """Rate of detachment g(q) [1/s], same shape as `q`."""
        return np.where(q < 0.0, self.g2, self.g1 * q + self.g3 * np.maximum(q - 1.0, 0.0))

    def duty(self, activation: float = 1.0) -> float:
        """Attached fraction F of an isometric population within reach [-]."""
        total = activation * self.f1 + self.g1
        return activation * self.f1 / total if total > 0.0 else 0.0

    def fastest(self, high: float) -> float:
        """Largest f + g of heads with q <= `high` [1/s]: explicit steps are bounded by its inverse."""
        return max(self.g2, self.f1 + self.g1, self.g1 * high + self.g3 * (high - 1.0))

    def isometric_moments(self, activation: float = 1.0) -> Array:
        """Moments F (1, 1/2, 1/3) of the isometric steady state, shape (3,)."""
        return self.duty(activation) * np.array([1.0, 1.0 / 2.0, 1.0 / 3.0])

    def steady_state(self, q: Array, speed: float, activation: float = 1.0) -> Array:
        r"""Attached fraction at constant `speed` v [1/s, lengthening positive], same shape as `q`.

        .. math::
            v<0:\; \rho = F\left(1 - e^{-\frac{c}{2|v|}(1-q^2)}\right),\;
                   F\left(1 - e^{-\frac{c}{2|v|}}\right) e^{g_2 q/|v|} \;(q<0); \qquad
            v>0:\; \rho = F\left(1 - e^{-\frac{c}{2v}q^2}\right),\;
                   F\left(1 - e^{-\frac{c}{2v}}\right) e^{-\int_1^q g/v} \;(q>1)
        """
        F, c = self.duty(activation), activation * self.f1 + self.g1
        inside = (q > 0.0) & (q < 1.0)
        if speed == 0.0:
            return np.where(inside, F, 0.0)
        b = 0.5 * c / abs(speed)
        edge = -F * math.expm1(-b)
        square = np.clip(q, 0.0, 1.0) ** 2
        if speed < 0.0:
            mid = -F * np.expm1(-b * (1.0 - square))
            return np.where(inside, mid, np.where(q <= 0.0, edge * np.exp(self.g2 * np.minimum(q, 0.0) / -speed), 0.0))
        x = np.maximum(q, 1.0)
        decay = 0.5 * (self.g1 + self.g3) * (x * x - 1.0) - self.g3 * (x - 1.0)
        return np.where(inside, -F * np.expm1(-b * square), np.where(q >= 1.0, edge * np.exp(-decay / speed), 0.0))

    def steady_moments(self, speed: float, activation: float = 1.0) -> Array:
        """Moments of `steady_state` in closed form, shape (3,); Q1 / Q1(isometric) is Huxley's force-velocity curve."""
        if speed == 0.0:
            return self.isometric_moments(activation)
        F, c = self.duty(activation), activation * self.f1 + self.g1
        b = 0.5 * c / abs(speed)
        edge = -F * math.expm1(-b)
        root = math.sqrt(b)
        i1 = -0.5 * math.expm1(-b) / b
        if speed < 0.0:
            i0 = dawsn(root) / root
            inner = np.array([i0, i1, 0.5 * (1.0 - i0) / b])
            far = -speed / self.g2
            outer = np.array([far, -(far**2), 2.0 * far**3])
        else:
            i0 = 0.5 * math.sqrt(math.pi) * erf(root) / root
            inner = np.array([i0, i1, 0.5 * (i0 - math.exp(-b)) / b])
            G = self.g1 + self.g3
            alpha, m = 0.5 * G / speed, self.g3 / G
            j0 = 0.5 * math.sqrt(math.pi / alpha) * erfcx(math.sqrt(alpha) * (1.0 - m))
            k1, k2 = 0.5 / alpha, 0.5 * (1.0 - m + j0) / alpha
            outer = np.array([j0, k1 + m * j0, k2 + 2.0 * m * k1 + m * m * j0])
        return F * (np.array([1.0, 1.0 / 2.0, 1.0 / 3.0]) - inner) + edge * outer

    def fastest_shortening(self) -> float:
        """Speed of unloaded shortening v_max > 0 [1/s], where Q1 vanishes; 106.65 for the default rates."""
        from scipy.optimize import brentq  # it takes longer to import than all the rest

        return float(brentq(lambda v: self.steady_moments(-v)[1], 1e-3 * self.f1, 1e3 * (self.f1 + self.g2)))  # pyright: ignore[reportArgumentType]
