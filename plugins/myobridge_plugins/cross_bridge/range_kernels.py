"""Compiled kernels of whole cells in a row, all in the same region for the whole path; they vectorise."""

from __future__ import annotations

import math

import numba as nb

from myobridge_plugins.cross_bridge.label_kernels import carry, decay, relaxed_time
from myobridge_plugins.cross_bridge.row_vectors import above, give, sum_of, take, where_positive
from myobridge_plugins.cross_bridge.window_layout import BARE, HEADER, LANES, PART

__all__ = ["high_dwell", "some_above", "step_crowded", "step_high", "step_low", "step_mid", "tabulate"]

TINY = 1e-30  # means below are set to zero: they would become denormal and slow


@nb.njit(**BARE)
def tabulate(tables, size, rate):
    """Fill tables of exp(-rate i) and i, i < size, behind LANES zeros.

    The places of the cells are equidistant: those above q=1 fade by the first, times one factor for all.
    """
    fade, ramp = tables[0], tables[1]
    for i in range(LANES):
        fade[i] = ramp[i] = 0.0
    for i in range(size):
        x = float(i)
        fade[LANES + i] = decay(-rate * x)
        ramp[LANES + i] = x


@nb.njit(**BARE)
def _moments_at(s0, s1, s2, q, dq):
    """Moment sums of cells, the first centred at q, from their sums over their numbers."""
    return s0, q * s0 + dq * s1, q * q * s0 + dq * (2.0 * q * s1 + dq * s2)


@nb.njit(**PART)
def step_low(cells, q, dq, factor, ramp):
    """Cells below q=0, whole LANES of them, the first centred at q: all decay by one factor. Moment sums before."""
    s0 = s1 = s2 = 0.0
    for i in range(cells.size):
        x = cells[i]
        s0 += x
        y = x * ramp[i]
        s1 += y
        s2 += y * ramp[i]
        x *= factor
        cells[i] = x if x > TINY else 0.0
    return _moments_at(s0, s1, s2, q, dq)


@nb.njit(**BARE)
def step_mid(cells, q, D, dq, c, F, dt):
    """Cells within (0, 1), none above the attachable fraction. Moment sums before and after."""
    b0 = b1 = b2 = a0 = a1 = a2 = 0.0
    # The rate is linear in the place, so the factors are a geometric row; a vector of exponentials is slower here.
    factor, ratio = math.exp(-c * (q + 0.5 * D) * dt), math.exp(-c * dq * dt)
    for i in range(cells.size):
        m = q + i * dq
        x = cells[i]
        y = x * m
        b0 += x
        b1 += y
        b2 += y * m
        x = F + (x - F) * factor
        factor *= ratio
        x = x if x > TINY else 0.0
        cells[i] = x
        m += D
        y = x * m
        a0 += x
        a1 += y
        a2 += y * m
    return b0, b1, b2, a0, a1, a2


@nb.njit(**BARE)
def step_crowded(cells, flux, site, q, D, dq, dt, f, a, g1, g2, g3):
    """Cells within (0, 1), some above the attachable fraction. Moment sums before and after."""
    b0 = b1 = b2 = a0 = a1 = a2 = 0.0
    for i in range(cells.size):
        m = q + i * dq
        x = cells[i]
        b0 += x
        b1 += x * m
        b2 += x * m * m
        x, w, d, t = carry(x, m, D, dt, 0.0, f, a, g1, g2, g3)
        x = min(max(x, 0.0), 1.0)
        cells[i] = x
        flux[0, site] += dq * t
        flux[1, site] += dq * d
        flux[2, site] += dq * w
        m += D
        a0 += x
        a1 += x * m
        a2 += x * m * m
    return b0, b1, b2, a0, a1, a2


@nb.njit(**PART)
def step_high(row, first, last, q, dq, factor, tables):
    """Cells `first` to `last` above q=1, the first centred at q after the step. Moment sums after.

    Whole LANES are stepped: of what stands before the cells nothing changes.
    """
    skip = (first - last) % LANES
    s0 = s1 = s2 = 0.0
    for i in range(-skip, last - first, LANES):
        x, fade, ramp = take(row, HEADER + first + i), take(tables[0], LANES + i), take(tables[1], LANES + i)
        y = above(x * (fade * factor), TINY)
        give(row, HEADER + first + i, where_positive(fade, y, x))
        s0 += sum_of(y)
        y = y * ramp
        s1 += sum_of(y)
        s2 += sum_of(y * ramp)
    return _moments_at(s0, s1, s2, q, dq)


@nb.njit(**BARE)
def high_dwell(cells, q, v, dq, G, g3, dt):
    """Sum of int rho dt of the cells above q=1; needed for the work when g3 > 0."""
    total = 0.0
    for i in range(cells.size):
        total += relaxed_time(cells[i], 0.0, q + i * dq, v, dt, G, -g3)
    return total


@nb.njit(**BARE)
def some_above(cells, a):
    count = 0
    for i in range(cells.size):  # counts them all, as a search that stops would not vectorise
        count += 1 if cells[i] > a else 0
    return count > 0
