r"""Moments of a Gaussian that decays exponentially in q, over the three pieces of the line between 0 and 1.

.. math:: M_k = \int_A^B q^k\, e^{-a q + b}\, \frac{1}{\sigma\sqrt{2\pi}} e^{-(q-\mu)^2/2\sigma^2}\,dq,
          \quad k = 0 \ldots 3

Closed forms by erfc lose all digits in the tails, so each case has the form that only adds what is positive:

* tail (:math:`\alpha = (A - m)/\sigma > 0`, m the mean of the tilted Gaussian): the moments about A are
  :math:`e^{..} \sigma^k J_k(\alpha)/\sqrt{2\pi}`, :math:`J_k = \int_0^\infty t^k e^{-t^2/2-\alpha t} dt`, whose ratios
  :math:`R_k = J_k/J_{k-1} = k/(\alpha + R_{k+1})` are a continued fraction: no erfcx, no overflow, no cancellation;
* otherwise erfc and the recurrence of the Gaussian's moments;
* between 0 and 1 where the integrand is flat, Gauss-Legendre with 16 nodes (a difference of two tails would cancel).

The exponent -a q + b never exceeds 0 inside the piece, so nothing overflows for any step.
"""

from __future__ import annotations

import math

import numba
import numpy as np

__all__ = ["inner", "left", "right"]

_S = 1.0 / math.sqrt(2.0 * math.pi)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
_FLAT = 8.0  # largest slope of the exponent on (0, 1) for which 16 nodes give round-off (error below 1e-15)
_Moments = tuple[float, float, float, float]


@numba.njit(cache=True)
def _mills(alpha: float) -> _Moments:
    r"""J_0 to J_3 for alpha >= 0, relative error below 3e-14."""
    if alpha < 2.0:
        j0 = math.sqrt(0.5 * math.pi) * math.exp(0.5 * alpha * alpha) * math.erfc(alpha / math.sqrt(2.0))
        j1 = 1.0 - alpha * j0
        j2 = j0 - alpha * j1
        return j0, j1, j2, 2.0 * j1 - alpha * j2
    # So many terms leave a relative error of 1e-15 in R_3, measured from alpha = 2 to 100.
    n = 16 + int(500.0 / (alpha * alpha))
    ratio = 0.0
    r3 = r2 = r1 = 0.0
    for k in range(n, 0, -1):
        ratio = k / (alpha + ratio)
        if k == 3:
            r3 = ratio
        elif k == 2:
            r2 = ratio
        elif k == 1:
            r1 = ratio
    j0 = 1.0 / (alpha + r1)
    j1 = j0 * r1
    j2 = j1 * r2
    return j0, j1, j2, j2 * r3


@numba.njit(cache=True)
def _tail(edge: float, mean: float, sd: float, a: float, b: float) -> _Moments:
    """Moments about `edge` of the piece beyond it."""
    tilted = mean - a * sd * sd
    alpha = (edge - tilted) / sd
    away = (edge - mean) / sd
    at_edge = _S * math.exp(min(b - a * edge - 0.5 * away * away, 0.0))
    if alpha > 0.0:
        j0, j1, j2, j3 = _mills(alpha)
        return at_edge * j0, at_edge * sd * j1, at_edge * sd * sd * j2, at_edge * sd * sd * sd * j3
    shift = tilted - edge
    n0 = 0.5 * math.exp(min(b - a * mean + 0.5 * (a * sd) ** 2, 0.0)) * math.erfc(alpha / math.sqrt(2.0))
    n1 = shift * n0 + sd * at_edge
    n2 = shift * n1 + sd * sd * n0
    return n0, n1, n2, shift * n2 + 2.0 * sd * sd * n1


@numba.njit(cache=True)
def left(mean: float, sd: float) -> _Moments:
    """Moments over q < 0, without weight: the decay there does not depend on q."""
    n0, n1, n2, n3 = _tail(0.0, -mean, sd, 0.0, 0.0)
    return n0, -n1, n2, -n3


@numba.njit(cache=True)
def right(mean: float, sd: float, a: float, b: float) -> _Moments:
    """Moments over q > 1 with the weight exp(-a q + b), b <= a."""
    n0, n1, n2, n3 = _tail(1.0, mean, sd, a, b)
    return n0, n0 + n1, n0 + 2.0 * n1 + n2, n0 + 3.0 * (n1 + n2) + n3


@numba.njit(cache=True)
def inner(mean: float, sd: float, a: float) -> _Moments:
    """Moments over 0 < q < 1 with the weight exp(-a q), a >= 0."""
    tilted = mean - a * sd * sd
    if max(abs(tilted), abs(1.0 - tilted)) < _FLAT * sd * sd:
        m0 = m1 = m2 = m3 = 0.0
        for i in range(_NODES.size):
            q = _NODES[i]
            away = (q - mean) / sd
            w = _WEIGHTS[i] * (_S / sd) * math.exp(-a * q - 0.5 * away * away)
            m0 += w
            m1 += w * q
            m2 += w * q * q
            m3 += w * q * q * q
        return m0, m1, m2, m3
    if tilted <= 0.0:
        n0, n1, n2, n3 = _tail(0.0, mean, sd, a, 0.0)
        r0, r1, r2, r3 = right(mean, sd, a, 0.0)
        return n0 - r0, n1 - r1, n2 - r2, n3 - r3
    if tilted >= 1.0:
        # Seen from q = 1, with t = 1 - q.
        n0, n1, n2, n3 = _tail(0.0, 1.0 - mean, sd, -a, -a)
        r0, r1, r2, r3 = right(1.0 - mean, sd, -a, -a)
        n0, n1, n2, n3 = n0 - r0, n1 - r1, n2 - r2, n3 - r3
        return n0, n0 - n1, n0 - 2.0 * n1 + n2, n0 - 3.0 * (n1 - n2) - n3
    low, high = tilted / sd, (1.0 - tilted) / sd
    level = math.exp(min(-a * mean + 0.5 * (a * sd) ** 2, 0.0))
    away0, away1 = mean / sd, (1.0 - mean) / sd
    at0 = sd * _S * math.exp(-0.5 * away0 * away0)
    at1 = sd * _S * math.exp(-a - 0.5 * away1 * away1)
    m0 = 0.5 * level * (math.erf(high / math.sqrt(2.0)) + math.erf(low / math.sqrt(2.0)))
    m1 = tilted * m0 + at0 - at1
    m2 = tilted * m1 + sd * sd * m0 - at1
    return m0, m1, m2, tilted * m2 + 2.0 * sd * sd * m1 - at1
