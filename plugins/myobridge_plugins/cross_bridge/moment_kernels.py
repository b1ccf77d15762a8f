r"""Kernels on the moments Q0, Q1, Q2 of a population: sliding, reaction of a Gaussian, steady state.

All take and fill arrays of shape (n_sites, 3); `out` may be the input. `fluxes` is (4, n_sites), in the order of
`Fluxes`; `unit` is the energy of a second moment of 1.
The reaction is written for attachment `ra f (c - rho)` with rate factor ra and attachable fraction c, linear in rho.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from myobridge_plugins.cross_bridge.truncated_gaussian import inner, left, right

__all__ = ["react_euler", "react_exactly", "shift", "steady"]

_EMPTY = 1e-300  # a population smaller than this is none: its mean would be 0/0
_NARROW = 1e-8  # smallest standard deviation, relative to 1 + |mean|: below it, a difference of squares is noise


@numba.njit(cache=True)
def _rounded(q0, q1, q2):
    """Second moment, put back on the edge Q0 Q2 = Q1^2 where rounding alone has carried it below.

    What is further below is left: a method that breaks realizability must show it.
    """
    square, product = q1 * q1, q0 * q2
    if q0 > _EMPTY and product < square and product > (1.0 - 1e-10) * square:
        return square / q0 * (1.0 + 1e-15)
    return q2


@numba.njit(cache=True)
def shift(state, displacement, out):
    """Carry each population by its displacement [reach]: exact for any density."""
    for i in range(state.shape[0]):
        x, q0, q1, q2 = displacement[i], state[i, 0], state[i, 1], state[i, 2]
        out[i, 0] = q0
        out[i, 1] = q1 + x * q0
        out[i, 2] = _rounded(q0, q1 + x * q0, q2 + x * (2.0 * q1 + x * q0))


@numba.njit(cache=True)
def _gaussian(q0, q1, q2):
    """Mean and standard deviation of the Gaussian with these moments, the latter kept above round-off."""
    mean = q1 / q0
    variance = q2 / q0 - mean * mean
    floor = _NARROW * (1.0 + abs(mean))
    return mean, math.sqrt(max(variance, floor * floor))


@numba.njit(cache=True)
def _source(a):
    r"""int_0^1 q^k (1 - exp(-a q)) dq for k = 0, 1, 2; a >= 0."""
    if a < 0.5:
        s0 = s1 = s2 = 0.0
        term = -1.0
        for n in range(1, 16):
            term *= -a / n
            s0 += term / (n + 1)
            s1 += term / (n + 2)
            s2 += term / (n + 3)
        return s0, s1, s2
    e = math.exp(-a)
    i0 = (1.0 - e) / a
    i1 = (i0 - e) / a
    i2 = (2.0 * i1 - e) / a
    return 1.0 - i0, 0.5 - i1, 1.0 / 3.0 - i2


@numba.njit(cache=True)
def _step(q0, q1, q2, ra, c, dt, f1, g1, g2, g3):
    """One exact reaction of the Gaussian; the new moments, and the second moments that attached and detached."""
    k = ra * f1 + g1
    share = ra * f1 / k if k > 0.0 else 0.0
    s0, s1, s2 = _source(k * dt)
    n0, n1, n2 = c * share * s0, c * share * s1, c * share * s2
    was_inside = lost_outside = 0.0
    if q0 > _EMPTY:
        mean, sd = _gaussian(q0, q1, q2)
        left0, left1, left2, _ = left(mean, sd)
        kept = math.exp(-g2 * dt)
        b0, b1, b2, _ = inner(mean, sd, k * dt)
        d0, d1, d2, _ = right(mean, sd, (g1 + g3) * dt, g3 * dt)
        _, _, w2, _ = inner(mean, sd, 0.0)
        _, _, right2, _ = right(mean, sd, 0.0, 0.0)
        n0 += q0 * (kept * left0 + b0 + d0)
        n1 += q0 * (kept * left1 + b1 + d1)
        was_inside = q0 * w2
        lost_outside = q0 * (-math.expm1(-g2 * dt) * left2 + (right2 - d2))
        n2 += q0 * b2
        change = n2 - was_inside
        n2 += q0 * (kept * left2 + d2)
    else:
        change = n2
    # Inside (0, 1) rho follows one exponential, so what attached and what detached are fractions of its change plus the
    # turnover at rest, int q^2 c ra f1 g1 q / k dq = c share g1 / 4.
    turnover = 0.25 * c * share * g1 * dt
    attached = turnover + share * change
    detached = turnover - (1.0 - share) * change + lost_outside if k > 0.0 else lost_outside
    return n0, n1, _rounded(n0, n1, n2), attached, detached


@numba.njit(cache=True)
def _book(fluxes, i, unit, attached, detached, change):
    """Energies of site i from second moments: attached, detached, no work, and the rounding, booked and not hidden."""
    fluxes[0, i], fluxes[1, i], fluxes[2, i] = unit * attached, unit * detached, 0.0
    fluxes[3, i] = unit * (change - (attached - detached))


@numba.njit(cache=True, nogil=True)
def react_exactly(state, rate, capacity, dt, rates, extrapolate, unit, out, fluxes):
    """Exponential projection; with `extrapolate` twice at half the step, minus once, where that is realizable."""
    f1, g1, g2, g3 = rates
    for i in range(state.shape[0]):
        q0, q1, q2, ra, c = state[i, 0], state[i, 1], state[i, 2], rate[i], capacity[i]
        n0, n1, n2, up, down = _step(q0, q1, q2, ra, c, dt, f1, g1, g2, g3)
        if extrapolate:
            h0, h1, h2, up1, down1 = _step(q0, q1, q2, ra, c, 0.5 * dt, f1, g1, g2, g3)
            h0, h1, h2, up2, down2 = _step(h0, h1, h2, ra, c, 0.5 * dt, f1, g1, g2, g3)
            e0, e1, e2 = 2.0 * h0 - n0, 2.0 * h1 - n1, 2.0 * h2 - n2
            if e0 > _EMPTY and e0 * e2 > e1 * e1:
                n0, n1, n2 = e0, e1, e2
                up, down = 2.0 * (up1 + up2) - up, 2.0 * (down1 + down2) - down
        out[i, 0], out[i, 1], out[i, 2] = n0, n1, n2
        _book(fluxes, i, unit, up, down, n2 - q2)


@numba.njit(cache=True)
def _slopes(q0, q1, q2, ra, c, f1, g1, g2, g3):
    """Attachment of Q0, Q1, Q2 a second, then their detachment: the right-hand side of the moment equations."""
    up0, up1, up2 = c * ra * f1 / 2.0, c * ra * f1 / 3.0, c * ra * f1 / 4.0
    if not q0 > _EMPTY:
        return up0, up1, up2, 0.0, 0.0, 0.0
    mean, sd = _gaussian(q0, q1, q2)
    a0, a1, a2, _ = left(mean, sd)
    _, b1, b2, b3 = inner(mean, sd, 0.0)
    d0, d1, d2, d3 = right(mean, sd, 0.0, 0.0)
    f, g, h = ra * f1 * q0, g1 * q0, g3 * q0
    low = g2 * q0
    return (
        up0 - f * b1,
        up1 - f * b2,
        up2 - f * b3,
        low * a0 + g * (b1 + d1) + h * (d1 - d0),
        low * a1 + g * (b2 + d2) + h * (d2 - d1),
        low * a2 + g * (b3 + d3) + h * (d3 - d2),
    )


@numba.njit(cache=True, nogil=True)
def react_euler(state, rate, capacity, dt, rates, unit, out, fluxes):
    """Explicit Euler step of the moment equations: the baseline, unrealizable after few steps."""
    f1, g1, g2, g3 = rates
    for i in range(state.shape[0]):
        q0, q1, q2 = state[i, 0], state[i, 1], state[i, 2]
        u0, u1, u2, d0, d1, d2 = _slopes(q0, q1, q2, rate[i], capacity[i], f1, g1, g2, g3)
        out[i, 0], out[i, 1], out[i, 2] = q0 + dt * (u0 - d0), q1 + dt * (u1 - d1), q2 + dt * (u2 - d2)
        _book(fluxes, i, unit, dt * u2, dt * d2, out[i, 2] - q2)


@numba.njit(cache=True)
def slopes(state, rate, capacity, rates, out):
    """Right-hand side of the moment equations at rest [1/s], shape (n_sites, 3)."""
    f1, g1, g2, g3 = rates
    for i in range(state.shape[0]):
        q = state[i]
        u0, u1, u2, d0, d1, d2 = _slopes(q[0], q[1], q[2], rate[i], capacity[i], f1, g1, g2, g3)
        out[i, 0], out[i, 1], out[i, 2] = u0 - d0, u1 - d1, u2 - d2


@numba.njit(cache=True)
def _newton(q, r, ra, f1, g1, g2, g3):
    """One Newton step for zero slopes at q (3,), derivatives by differences; its relative size."""
    base = np.empty(3)
    a = np.empty((3, 3))
    u0, u1, u2, d0, d1, d2 = _slopes(q[0], q[1], q[2], ra, 1.0, f1, g1, g2, g3)
    base[0], base[1], base[2] = u0 - d0, u1 - d1, u2 - d2
    for j in range(3):
        old = q[j]
        q[j] = old * (1.0 + 1e-7)
        u0, u1, u2, d0, d1, d2 = _slopes(q[0], q[1], q[2], ra, 1.0, f1, g1, g2, g3)
        width = q[j] - old
        a[0, j], a[1, j], a[2, j] = (
            (u0 - d0 - base[0]) / width,
            (u1 - d1 - base[1]) / width,
            (u2 - d2 - base[2]) / width,
        )
        q[j] = old
    det = 0.0
    for j in range(3):
        k, m = (j + 1) % 3, (j + 2) % 3
        det += a[0, j] * (a[1, k] * a[2, m] - a[1, m] * a[2, k])
    for j in range(3):
        # Cramer's rule: column j replaced by the negative slopes.
        k, m = (j + 1) % 3, (j + 2) % 3
        top = -(
            base[0] * (a[1, k] * a[2, m] - a[1, m] * a[2, k])
            - base[1] * (a[0, k] * a[2, m] - a[0, m] * a[2, k])
            + base[2] * (a[0, k] * a[1, m] - a[0, m] * a[1, k])
        )
        r[j] = top / det
    return abs(r[0] / q[0]) + abs(r[1] / q[1]) + abs(r[2] / q[2])


@numba.njit(cache=True)
def steady(rate, rates, out):
    """Isometric steady moments for attachable fraction 1; they are proportional to it. Empty where nothing attaches."""
    f1, g1, g2, g3 = rates
    step, trial = np.empty(3), np.empty(3)
    for i in range(rate.size):
        ra = rate[i]
        for j in range(3):  # a whole row at once would compile the text of an error that cannot occur
            out[i, j] = 0.0
        k = ra * f1 + g1
        if not ra * f1 > 0.0:
            continue
        q = out[i]
        q[0], q[1], q[2] = ra * f1 / k, 0.5 * ra * f1 / k, ra * f1 / (3.0 * k)
        # The projection, which cannot fail, brings the state near; Newton ends it in 3 or 4 iterations.
        for _ in range(60):
            q[0], q[1], q[2], _, _ = _step(q[0], q[1], q[2], ra, 1.0, 0.5 / k, f1, g1, g2, g3)
        for _ in range(40):
            size = _newton(q, step, ra, f1, g1, g2, g3)
            if not size > 1e-14:
                break
            scale = 1.0
            for _ in range(20):
                for j in range(3):
                    trial[j] = q[j] + scale * step[j]
                if trial[0] > 0.0 and trial[0] * trial[2] > trial[1] * trial[1]:
                    break
                scale *= 0.5
            for j in range(3):
                q[j] = trial[j]
