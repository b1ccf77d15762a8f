r"""Compiled kernels that carry a label, a head's place on its filament, along a path of constant speed.

Region by region the two-state equation is solved exactly along the path p(t):

.. math::
    p<0:\; \rho' = -g_2 \rho, \qquad
    0<p<1:\; \rho' = c\,p\,(F-\rho),\; c = k f_1 + g_1,\; F = k f_1 a / c, \qquad
    p>1:\; \rho' = -(G p - g_3) \rho,\; G = g_1 + g_3 .

Above the attachable fraction `a` no head attaches: a label in (0, 1) decays at the rate :math:`g_1 p` until
:math:`\rho = a`. Energies are those of a piece of unit length whose cell is centred at p - delta.

Departures: :math:`\int \rho\,dt` of a piece off its cell's centre is integrated by Gauss' rule with four points; it
enters the division of energy among work, attachment and detachment, never their sum.
"""

from __future__ import annotations

import math

import numba as nb

from myobridge_plugins.cross_bridge.window_layout import BARE

__all__ = ["LITTLE", "carry", "decay", "decay_above", "decay_little", "relaxed_time"]

# Gauss' rule with four points on [0, 1].
_N1, _N2, _N3, _N4 = 0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263
_W1, _W2 = 0.17392742256872692, 0.32607257743127307
LITTLE = 0.1


@nb.njit(inline="always", **BARE)
def decay(x):
    """exp(x) for x <= 0 as P12(x/16)^16: absolute error 1.5e-15, at least 4e-18. Vectorises, unlike libm's."""
    return decay_above(max(x, -40.0))


@nb.njit(inline="always", **BARE)
def decay_above(x):
    """`decay` of numbers, or of a vector of them, that are not below -40."""
    y = x * 0.0625
    y2 = y * y
    y4 = y2 * y2
    # Three groups at once: one term after the other takes twice as long.
    high = (1.0 / 40320.0 + y * (1.0 / 362880.0)) + y2 * (1.0 / 3628800.0 + y * (1.0 / 39916800.0))
    p = _expanded(y, y2, y4, high + y4 * (1.0 / 479001600.0))
    p = p * p
    p = p * p
    p = p * p
    return p * p


@nb.njit(inline="always", **BARE)
def decay_little(x):
    """exp(x) for abs(x) <= LITTLE: relative error 2e-16, half the cost of `decay`."""
    x2 = x * x
    return _expanded(x, x2, x2 * x2, 1.0 / 40320.0 + x * (1.0 / 362880.0))


@nb.njit(inline="always", **BARE)
def _expanded(x, x2, x4, high):
    """Terms 1 to x^7/7!, and x^8 times `high`."""
    low = x + x2 * (0.5 + x * (1.0 / 6.0))
    mid = (1.0 / 24.0 + x * (1.0 / 120.0)) + x2 * (1.0 / 720.0 + x * (1.0 / 5040.0))
    return 1.0 + (low + x4 * (mid + x4 * high))  # added last, so that only this sum is rounded


@nb.njit(**BARE)
def relaxed_time(rho, goal, p, v, t, a, b):
    """Integral over `t` of goal + (rho - goal) exp(-int(a p + b)), p starting at `p` with speed `v`."""
    total = 0.0
    for node, weight in ((_N1, _W1), (_N2, _W2), (_N3, _W2), (_N4, _W1)):
        s = node * t
        total += weight * (goal + (rho - goal) * decay(-(a * s * (p + 0.5 * v * s) + b * s)))
    return total * t


@nb.njit(**BARE)
def _energy(rho, p, delta):
    """Energy of a piece of unit length whose cell is centred at p - delta."""
    return 0.5 * rho * (p - delta) ** 2


@nb.njit(**BARE)
def _pass_low(rho, p, v, t, delta, g2):
    """Piece below q=0 for the time t: new value, work, detached energy."""
    new = rho * math.exp(-g2 * t)
    work = 0.0
    if v != 0.0:
        if g2 > 0.0:
            i0 = -rho * math.expm1(-g2 * t) / g2
            i1 = (p * rho - (p + v * t) * new + v * i0) / g2
        else:
            i0 = rho * t
            i1 = rho * t * (p + 0.5 * v * t)
        work = v * (i1 - delta * i0)
    return new, work, work - (_energy(new, p + v * t, delta) - _energy(rho, p, delta))


@nb.njit(**BARE)
def _pass_high(rho, p, v, t, delta, g1, g3):
    """Piece above q=1 for the time t: new value, work, detached energy."""
    G = g1 + g3
    u = t * (p + 0.5 * v * t)
    new = rho * math.exp(g3 * t - G * u)
    work = 0.0
    if v != 0.0:
        i0 = 0.0
        if g3 > 0.0 or delta != 0.0:
            i0 = relaxed_time(rho, 0.0, p, v, t, G, -g3)
        i1 = (rho - new + g3 * i0) / G if G > 0.0 else rho * u
        work = v * (i1 - delta * i0)
    return new, work, work - (_energy(new, p + v * t, delta) - _energy(rho, p, delta))


@nb.njit(**BARE)
def _relax_mid(rho, p, v, t, delta, c, F, g1):
    """Piece in (0, 1) that relaxes towards F at the rate c p: new value, work, detached, attached energy."""
    u = t * (p + 0.5 * v * t)
    new = F + (rho - F) * math.exp(-c * u)
    end = p + v * t
    work = 0.0
    if v != 0.0:
        i1 = F * u + (rho - new) / c if c > 0.0 else rho * u
        i0 = relaxed_time(rho, F, p, v, t, c, 0.0) if delta != 0.0 else 0.0
        work = v * (i1 - delta * i0)
    reaction = _energy(new, end, delta) - _energy(rho, p, delta) - work
    if c <= 0.0:
        return new, work, 0.0, 0.0
    middle = p + 0.5 * v * t  # Simpson's rule is exact for the cubic w p
    wp = p * _energy(1.0, p, delta) + 4.0 * middle * _energy(1.0, middle, delta)
    wp = (wp + end * _energy(1.0, end, delta)) * t / 6.0
    detached = g1 * (F * wp - reaction / c)
    return new, work, detached, reaction + detached


@nb.njit(**BARE)
def _pass_mid(rho, p, v, t, delta, f, a, g1):
    """Piece in (0, 1): decays while it is above the attachable fraction a, then relaxes."""
    if rho <= a:
        c = f + g1
        return _relax_mid(rho, p, v, t, delta, c, f * a / c if c > 0.0 else 0.0, g1)
    u = t * (p + 0.5 * v * t)
    until = math.log(rho / a) / g1 if a > 0.0 and g1 > 0.0 else math.inf  # int p dt until rho = a
    if until >= u:
        return _relax_mid(rho, p, v, t, delta, g1, 0.0, g1)
    q = math.sqrt(max(p * p + 2.0 * v * until, 0.0))
    first = min(2.0 * until / (p + q), t)
    _, work1, detached1, _ = _relax_mid(rho, p, v, first, delta, g1, 0.0, g1)
    c = f + g1
    new, work2, detached2, attached = _relax_mid(a, p + v * first, v, t - first, delta, c, f * a / c, g1)
    # The two parts meet at rho = a to round-off only; the energies are those of the whole.
    return new, work1 + work2, detached1 + detached2, attached


@nb.njit(**BARE)
def carry(rho, p, D, dt, delta, f, a, g1, g2, g3):
    """Piece along its whole path from p to p + D: new value, work, detached, attached energy."""
    if D == 0.0:
        if p < 0.0:
            new, work, detached = _pass_low(rho, p, 0.0, dt, delta, g2)
            return new, work, detached, 0.0
        if p >= 1.0:
            new, work, detached = _pass_high(rho, p, 0.0, dt, delta, g1, g3)
            return new, work, detached, 0.0
        return _pass_mid(rho, p, 0.0, dt, delta, f, a, g1)
    v = D / dt
    # Fractions of the path at which it meets q=0 and q=1; no difference of near numbers, however short the path.
    at0 = min(max(-p / D, 0.0), 1.0)
    at1 = min(max((1.0 - p) / D, 0.0), 1.0)
    in_mid = abs(at1 - at0) * dt
    in_low = at0 * dt if D > 0.0 else (1.0 - at0) * dt
    in_high = (1.0 - at1) * dt if D > 0.0 else at1 * dt
    m = min(max(p, 0.0), 1.0)
    work = 0.0
    detached = 0.0
    attached = 0.0
    if in_low > 0.0 and D > 0.0:
        rho, w, d = _pass_low(rho, p, v, in_low, delta, g2)
        work += w
        detached += d
    if in_high > 0.0 and D < 0.0:
        rho, w, d = _pass_high(rho, p, v, in_high, delta, g1, g3)
        work += w
        detached += d
    if in_mid > 0.0:
        rho, w, d, attached = _pass_mid(rho, m, v, in_mid, delta, f, a, g1)
        work += w
        detached += d
    if in_low > 0.0 and D < 0.0:
        rho, w, d = _pass_low(rho, min(p, 0.0), v, in_low, delta, g2)
        work += w
        detached += d
    if in_high > 0.0 and D > 0.0:
        rho, w, d = _pass_high(rho, max(p, 1.0), v, in_high, delta, g1, g3)
        work += w
        detached += d
    return rho, work, detached, attached
