r"""Compiled kernels of the exact scheme: one step of a site's cells along a path of constant speed.

Whole cells within one region take the path of their centre. A cell cut at the start or at the end of the step, or swept
by a cut, falls into pieces at both cuts; a piece takes a linear profile limited by its neighbours, is carried from
two Gauss points, and is merged by length into what lies left and right of the new cut. All means are convex
combinations, so that they stay in [0, 1].
"""

from __future__ import annotations

import math

import numba as nb

from myobridge_plugins.cross_bridge.label_kernels import carry, decay, relaxed_time
from myobridge_plugins.cross_bridge.window_kernels import (
    FADED,
    FAST,
    FIRST,
    HEADER,
    LAST,
    LEFT0,
    LEFT1,
    Q0,
    Q1,
    Q2,
    RIGHT0,
    RIGHT1,
    START,
    copy_row,
    cut,
    move_window,
    values,
)

__all__ = ["step_sites"]

TINY = 1e-30  # means below are set to zero: they would become denormal and slow
_PAIR = 0.5773502691896258  # 1/sqrt(3), Gauss' rule with two points


@nb.njit(**FAST)
def _pieces(is_cut, theta, will_be_cut, theta_end):
    """Inner faces of a cell's pieces: at the old cut and at the new one."""
    if not is_cut:
        theta = theta_end if will_be_cut else 1.0
    if not will_be_cut:
        theta_end = theta
    return min(theta, theta_end), max(theta, theta_end)


@nb.njit(**FAST)
def _slope(before, value, after, distance, width):
    """Slope of a linear profile in a (sub-)cell of the given width that stays between its neighbours."""
    rise, fall = value - before, after - value
    if rise * fall <= 0.0:
        return 0.0
    steepest = min(abs(after - before) / distance, 2.0 * min(abs(rise), abs(fall)) / width)
    return math.copysign(steepest, rise)


@nb.njit(**FAST)
def _step_touched(row, flux, site, begin, end, pm, start, D, dt, f, a, g1, g2, g3, bins, old, theta, new, theta_end):
    """Cells begin..end-1, which a cut leaves, enters or crosses, piece by piece; their moments before and after.

    `pm` is the mean of the cell before the first one.
    """
    dq = 1.0 / bins
    d12 = dq * dq / 12.0
    b0 = b1 = b2 = a0 = a1 = a2 = 0.0
    left0 = right0 = left1 = right1 = 0.0
    for cell in range(begin, end):
        left, right, is_cut = values(row, cell, old, bins)
        will_be_cut = cell == new or cell == new + bins
        inner, outer = _pieces(is_cut, theta, will_be_cut, theta_end)
        centre = start + (cell + 0.5) * dq
        before = row[HEADER + cell]
        nx = row[HEADER + cell + 1] if HEADER + cell + 1 < row.size else 0.0
        if is_cut and 0.0 < theta < 1.0:
            slope_left = _slope(pm, left, right, 1.0 + 0.5 * theta, theta)
            slope_right = _slope(left, right, nx, 1.5 - 0.5 * theta, 1.0 - theta)
        else:
            slope_left = slope_right = _slope(pm, before, nx, 2.0, 1.0)
            left = right = before
            is_cut = False
        middle_left = 0.5 * theta if is_cut else 0.5
        middle_right = 0.5 * (1.0 + theta)
        pm = before
        sum_left = sum_right = work = detached = attached = 0.0
        for piece in range(3):
            low = 0.0 if piece == 0 else (inner if piece == 1 else outer)
            high = inner if piece == 0 else (outer if piece == 1 else 1.0)
            length = high - low
            if length <= 0.0:
                continue
            middle = 0.5 * (low + high)
            for node in range(2):
                x = middle + (node - 0.5) * _PAIR * length
                if not is_cut or middle < theta:
                    value = left + slope_left * (x - middle_left)
                else:
                    value = right + slope_right * (x - middle_right)
                delta = (x - 0.5) * dq
                value, w, d, t = carry(value, centre + delta, D, dt, delta, d12, f, a, g1, g2, g3)
                value = 0.5 * length * min(max(value, 0.0), 1.0)
                work += 0.5 * length * w
                detached += 0.5 * length * d
                attached += 0.5 * length * t
                if will_be_cut and middle > theta_end:
                    sum_right += value
                else:
                    sum_left += value
        after = min(sum_left + sum_right, 1.0)
        if will_be_cut:
            left = min(sum_left / theta_end, 1.0) if theta_end > 0.0 else after
            right = min(sum_right / (1.0 - theta_end), 1.0) if theta_end < 1.0 else after
            if cell == new:
                left0, right0 = left, right
            else:
                left1, right1 = left, right
        row[HEADER + cell] = after
        b0 += before
        b1 += before * centre
        b2 += before * (centre * centre + d12)
        centre += D
        a0 += after
        a1 += after * centre
        a2 += after * (centre * centre + d12)
        flux[0, site] += dq * attached
        flux[1, site] += dq * detached
        flux[2, site] += dq * work
    return b0, b1, b2, a0, a1, a2, left0, right0, left1, right1


@nb.njit(**FAST)
def _step_low(cells, q, dq, factor):
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
def _step_high(cells, q, D, dq, G, g3, dt):
    """Cells above q=1, the first centred at q before the step. Moment sums after."""
    s0 = s1 = s2 = 0.0
    for i in range(cells.size):
        m = q + i * dq
        x = cells[i] * decay((g3 - G * (m + 0.5 * D)) * dt)
        x = x if x > TINY else 0.0
        cells[i] = x
        m += D
        y = x * m
        s0 += x
        s1 += y
        s2 += y * m
    return s0, s1, s2


@nb.njit(**FAST)
def _step_mid(cells, q, D, dq, c, F, dt):
    """Cells within (0, 1), none above the attachable fraction. Moment sums before and after."""
    b0 = b1 = b2 = a0 = a1 = a2 = 0.0
    for i in range(cells.size):
        m = q + i * dq
        x = cells[i]
        y = x * m
        b0 += x
        b1 += y
        b2 += y * m
        x = F + (x - F) * decay(-c * (m + 0.5 * D) * dt)
        x = x if x > TINY else 0.0
        cells[i] = x
        m += D
        y = x * m
        a0 += x
        a1 += y
        a2 += y * m
    return b0, b1, b2, a0, a1, a2


@nb.njit(**FAST)
def _high_dwell(cells, q, v, dq, G, g3, dt):
    """Sum of int rho dt of the cells above q=1; needed for the work when g3 > 0."""
    total = 0.0
    for i in range(cells.size):
        total += relaxed_time(cells[i], 0.0, q + i * dq, v, dt, G, -g3)
    return total


@nb.njit(**FAST)
def _highest(cells):
    top = 0.0
    for i in range(cells.size):
        top = max(top, cells[i])
    return top


@nb.njit(**FAST)
def _step_site(row, flux, site, D, dt, f, a, g1, g2, g3, bins):
    """One site along a path of constant speed that stays inside the window; fluxes in h-units are added."""
    dq = 1.0 / bins
    d12 = dq * dq / 12.0
    start = row[START]
    v = D / dt
    old, theta = cut(start, bins)
    new, theta_end = cut(start + D, bins)
    lo, hi = min(old, new), max(old, new)
    first, last = min(int(row[FIRST]), lo), max(int(row[LAST]), hi + bins + 1)
    cells = row[HEADER:]
    centre = start + 0.5 * dq
    # Cells that a cut touches come first: they look at their neighbours' old means. Then those between the cuts.
    pm0 = cells[lo - 1] if lo > 0 else 0.0
    pm1 = cells[lo + bins - 1]
    if hi < lo + bins:
        n0, n1, n2, m0, m1, m2, left0, right0, _, _ = _step_touched(
            row, flux, site, lo, hi + 1, pm0, start, D, dt, f, a, g1, g2, g3, bins, old, theta, new, theta_end
        )
        t0, t1, t2, u0, u1, u2, _, _, left1, right1 = _step_touched(
            row,
            flux,
            site,
            lo + bins,
            hi + bins + 1,
            pm1,
            start,
            D,
            dt,
            f,
            a,
            g1,
            g2,
            g3,
            bins,
            old,
            theta,
            new,
            theta_end,
        )
        n0 += t0
        n1 += t1
        n2 += t2
        m0 += u0
        m1 += u1
        m2 += u2
        middle = cells[hi + 1 : lo + bins]
        if a >= 1.0 or _highest(middle) <= a:
            c = f + g1
            F = f * a / c if c > 0.0 else 0.0
            q = centre + (hi + 1) * dq
            t0, t1, t2, u0, u1, u2 = _step_mid(middle, q, D, dq, c, F, dt)
            k = float(middle.size)
            # Sums of p and p^3 over the cells, p the centre of the path.
            p = q + 0.5 * D + 0.5 * dq * (k - 1.0)
            sum1 = k * p
            sum3 = sum1 * (p * p + 0.25 * dq * dq * (k * k - 1.0))
            work = 0.0
            if D != 0.0:
                work = dq * v * (F * dt * sum1 + (t0 - u0) / c) if c > 0.0 else 0.5 * D * dq * (t1 + u1)
            flux[2, site] += work
            if c > 0.0:
                reaction = 0.5 * dq * (u2 - t2 + d12 * (u0 - t0)) - work
                wp = 0.5 * dq * dt * (sum3 + sum1 * (0.25 * D * D + d12))
                detached = g1 * (F * wp - reaction / c)
                flux[1, site] += detached
                flux[0, site] += reaction + detached
            # Moments of touched cells carry d12 already, those of whole ranges do not yet.
            t2 += d12 * t0
            u2 += d12 * u0
        else:
            t0, t1, t2, u0, u1, u2, _, _, _, _ = _step_touched(
                row,
                flux,
                site,
                hi + 1,
                lo + bins,
                cells[hi],
                start,
                D,
                dt,
                f,
                a,
                g1,
                g2,
                g3,
                bins,
                old,
                theta,
                new,
                theta_end,
            )
        n0 += t0
        n1 += t1
        n2 += t2
        m0 += u0
        m1 += u1
        m2 += u2
    else:
        n0, n1, n2, m0, m1, m2, left0, right0, left1, right1 = _step_touched(
            row, flux, site, lo, hi + bins + 1, pm0, start, D, dt, f, a, g1, g2, g3, bins, old, theta, new, theta_end
        )
    # Cells below.
    factor = math.exp(-g2 * dt)
    b0, b1, b2 = _step_low(cells[first:lo], centre + first * dq, dq, factor)
    a0 = factor * b0
    a1 = factor * (b1 + D * b0)
    a2 = factor * (b2 + D * (2.0 * b1 + D * b0))
    work = 0.0
    if D != 0.0:
        work = dq * v * (b1 - a1 + v * (b0 - a0) / g2) / g2 if g2 > 0.0 else dq * D * (b1 + 0.5 * D * b0)
    flux[2, site] += work
    flux[1, site] += work - 0.5 * dq * (a2 - b2 + d12 * (a0 - b0))
    # Cells above: what they held before is the rest of the known moments.
    above = cells[hi + bins + 1 : last]
    q = centre + (hi + bins + 1) * dq
    h0 = row[Q0] * bins - b0 - n0
    h2 = row[Q2] * bins - b2 - d12 * b0 - n2
    dwell = _high_dwell(above, q, v, dq, g1 + g3, g3, dt) if g3 > 0.0 and D != 0.0 else 0.0
    t0, t1, t2 = _step_high(above, q, D, dq, g1 + g3, g3, dt)
    work = 0.0
    if D != 0.0 and above.size > 0:
        G = g1 + g3
        work = dq * v * (h0 - t0 + g3 * dwell) / G if G > 0.0 else dq * D * (t1 - 0.5 * D * t0)
    if above.size > 0:
        flux[2, site] += work
        flux[1, site] += work - 0.5 * dq * (t2 + d12 * t0 - h2)
    row[START] = start + D
    row[Q0] = dq * (a0 + m0 + t0)
    row[Q1] = dq * (a1 + m1 + t1)
    row[Q2] = dq * (a2 + d12 * a0 + m2 + t2 + d12 * t0)
    row[LEFT0], row[RIGHT0], row[LEFT1], row[RIGHT1] = left0, right0, left1, right1
    while first < new and cells[first] < FADED:
        cells[first] = 0.0
        first += 1
    while last > new + bins + 1 and cells[last - 1] < FADED:
        cells[last - 1] = 0.0
        last -= 1
    row[FIRST], row[LAST] = first, last


@nb.njit(**FAST)
def step_sites(state, out, copy, flux, displacement, dt, activation, overlap, by_rate, rates, low, reach, bins, scale):
    """Whole path at all sites: `state` (n, m) to `out`; fluxes (4, n), zero on entry, in units of p_max.

    `displacement` and `overlap` have one entry or one a site; `reach` is the longest displacement for which the
    window holds the heads of a whole path: longer paths are composed.
    """
    f1, g1, g2, g3 = rates
    for site in range(state.shape[0]):
        row = out[site]
        if copy:
            copy_row(state[site], row)
        r = activation[site]
        o = overlap[site] if overlap.size > 1 else overlap[0]
        f = r * f1 if by_rate else f1
        a = o if by_rate else r * o
        D = displacement[site] if displacement.size > 1 else displacement[0]
        parts = max(math.ceil(abs(D) / reach), 1)
        for _ in range(parts):
            _step_site(row, flux, site, D / parts, dt / parts, f, a, g1, g2, g3, bins)
            flux[3, site] -= 0.5 * row[Q2]
            move_window(row, low, bins)
            flux[3, site] += 0.5 * row[Q2]
        for j in range(4):
            flux[j, site] *= scale
