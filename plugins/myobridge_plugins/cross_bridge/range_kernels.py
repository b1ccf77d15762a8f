"""Compiled kernels of whole cells in a row, all in the same region for the whole path; they vectorise."""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge_plugins.cross_bridge.label_kernels import carry, decay, relaxed_time
from myobridge_plugins.cross_bridge.window_kernels import FAST

__all__ = ["fading", "high_dwell", "highest", "step_crowded", "step_high", "step_low", "step_mid"]

TINY = 1e-30  # means below are set to zero: they would become denormal and slow


@nb.njit(**FAST)
def fading(size, rate):
    """Table exp(-rate i): the cells above q=1 fade by it, times one factor for all, as their places are equidistant."""
    table = np.empty(size)
    for i in range(size):
        table[i] = decay(-rate * i)
    return table


@nb.njit(**FAST)
def step_low(cells, q, dq, factor):
    """Cells below q=0, the first centred at q: all decay by one factor. Moment sums before."""
    s0 = s1 = s2 = 0.0
    for i in range(cells.size):
        x = cells[i]
        m = q + i * dq
        y = x * m
        s0 += x
        s1 += y
        s2 += y * m
        x *= factor
        cells[i] = x if x > TINY else 0.0
    return s0, s1, s2


@nb.njit(**FAST)
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


@nb.njit(**FAST)
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


@nb.njit(**FAST)
def step_high(cells, q, dq, factor, table):
    """Cells above q=1, the first centred at q after the step. Moment sums after."""
    s0 = s1 = s2 = 0.0
    for i in range(cells.size):
        x = cells[i] * (factor * table[i])
        x = x if x > TINY else 0.0
        cells[i] = x
        m = q + i * dq
        y = x * m
        s0 += x
        s1 += y
        s2 += y * m
    return s0, s1, s2


@nb.njit(**FAST)
def high_dwell(cells, q, v, dq, G, g3, dt):
    """Sum of int rho dt of the cells above q=1; needed for the work when g3 > 0."""
    total = 0.0
    for i in range(cells.size):
        total += relaxed_time(cells[i], 0.0, q + i * dq, v, dt, G, -g3)
    return total


@nb.njit(**FAST)
def highest(cells):
    top = 0.0
    for i in range(cells.size):
        top = max(top, cells[i])
    return top
