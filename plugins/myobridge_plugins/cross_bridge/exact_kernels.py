r"""Compiled kernels of the exact scheme: one step of a site's cells along a path of constant speed.

Whole cells outside the zones lie within one region for the whole path (longer paths are composed of shorter ones) and
take the path of their centre. Within a zone, the new cut divides one more part; every part is carried from two Gauss
points of a linear profile, as it may cross a cut on its way. All means are convex combinations, so that they stay in
[0, 1].

A part counts for the moments, and for all energies, as that fraction of its cell, at the cell's centre.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge_plugins.cross_bridge.held_kernels import react_site, room_between
from myobridge_plugins.cross_bridge.label_kernels import carry
from myobridge_plugins.cross_bridge.prefetch import fetch
from myobridge_plugins.cross_bridge.range_kernels import (
    high_dwell,
    some_above,
    step_crowded,
    step_high,
    step_low,
    step_mid,
    tabulate,
)
from myobridge_plugins.cross_bridge.row_moves import arrive, copy_lines, stream_lines
from myobridge_plugins.cross_bridge.window_kernels import move_window, take_row, trim
from myobridge_plugins.cross_bridge.window_layout import (
    BARE,
    CELLS,
    FACE,
    FAST,
    FIRST,
    HEADER,
    LANES,
    LAST,
    PART0,
    PART1,
    Q0,
    Q1,
    Q2,
    START,
    ZONE,
    count_parts,
    cut_at,
)
from myobridge_plugins.cross_bridge.zone_kernels import ROOM, divide, enter_zone, hold_cut, part_slope, thin_out

__all__ = ["step_sites"]

_PAIR = 0.28867513459481287  # half of 1/sqrt(3), Gauss' rule with two points


@nb.njit(**BARE)
def _step_parts(row, flux, site, first_part, first_cell, D, dt, f, a, g1, g2, g3, bins):
    """Parts of one zone, each carried along the path; moment sums of its cells before and after."""
    dq = 1.0 / bins
    b0 = b1 = b2 = a0 = a1 = a2 = work = detached = attached = 0.0
    n, k = count_parts(row), 0
    before, gap, face = row[HEADER + first_cell - 1], 1.0, 0.0  # mean and length of the part to the left, and its end
    for cell in range(CELLS):
        at = HEADER + first_cell + cell
        centre = row[START] + (first_cell + cell + 0.5) * dq
        mean = 0.0
        while k < n and row[FACE + k] <= cell + 1:
            length = row[FACE + k] - face
            middle = 0.5 * (row[FACE + k] + face) - cell - 0.5
            face = row[FACE + k]
            old, new = row[first_part + k], 0.0
            whole = k + 1 == n  # the neighbour to the right is a cell outside the zone
            after = row[HEADER + first_cell + CELLS] if whole else row[first_part + k + 1]
            slope = part_slope(old, before, after, length, gap, 1.0 if whole else row[FACE + k + 1] - face)
            before, gap = old, length
            for node in (-_PAIR, _PAIR):
                delta = (middle + node * length) * dq
                value, w, d, t = carry(old + slope * node * length, centre + delta, D, dt, delta, f, a, g1, g2, g3)
                new += 0.5 * min(max(value, 0.0), 1.0)
                work += 0.5 * length * w
                detached += 0.5 * length * d
                attached += 0.5 * length * t
            row[first_part + k] = new
            mean += length * new
            k += 1
        mean = min(mean, 1.0)
        b0 += row[at]
        b1 += row[at] * centre
        b2 += row[at] * centre * centre
        row[at] = mean
        centre += D
        a0 += mean
        a1 += mean * centre
        a2 += mean * centre * centre
    flux[0, site] += dq * attached
    flux[1, site] += dq * detached
    flux[2, site] += dq * work
    return b0, b1, b2, a0, a1, a2


@nb.njit(**BARE)
def _step_site(row, flux, site, D, dt, f, a, g1, g2, g3, bins, scratch, tables, spare, whole_dt):
    """One site along a path that ends at most CELLS - 1 cells away; fluxes in h-units are added.

    `tables` are those of `tabulate` for a step `whole_dt`; `spare` takes those for another.
    """
    dq = 1.0 / bins
    start = row[START]
    v = D / dt
    old, new = cut_at(start, bins), cut_at(start + D, bins)
    enter_zone(row, math.floor(new), math.floor(old), bins, scratch)
    zone = int(row[ZONE])
    divide(row, new - zone, bins)
    first, last = min(int(row[FIRST]), zone), max(int(row[LAST]), zone + bins + CELLS)
    cells = row[HEADER:]
    centre = start + 0.5 * dq
    n0, _, n2, m0, m1, m2 = _step_parts(row, flux, site, PART0, zone, D, dt, f, a, g1, g2, g3, bins)
    t0, t1, t2, u0, u1, u2 = _step_parts(row, flux, site, PART1, zone + bins, D, dt, f, a, g1, g2, g3, bins)
    n0 += t0
    n2 += t2
    m0 += u0
    m1 += u1
    m2 += u2
    # Between the zones.
    middle = cells[zone + CELLS : zone + bins]
    q = centre + (zone + CELLS) * dq
    if a >= 1.0 or not some_above(middle, a):
        c = f + g1
        F = f * a / c if c > 0.0 else 0.0
        t0, t1, t2, u0, u1, u2 = step_mid(middle, q, D, dq, c, F, dt)
        work = 0.0
        if c > 0.0:
            # Sums of p and p^3 over the cells, p the centre of the path.
            k = float(middle.size)
            p = q + 0.5 * D + 0.5 * dq * (k - 1.0)
            sum1 = k * p
            sum3 = sum1 * (p * p + 0.25 * dq * dq * (k * k - 1.0))
            if D != 0.0:
                work = dq * v * (F * dt * sum1 + (t0 - u0) / c)
            reaction = 0.5 * dq * (u2 - t2) - work
            detached = g1 * (F * 0.5 * dq * dt * (sum3 + 0.25 * D * D * sum1) - reaction / c)
            flux[1, site] += detached
            flux[0, site] += reaction + detached
        elif D != 0.0:
            work = 0.5 * D * dq * (t1 + u1)
        flux[2, site] += work
    else:
        t0, t1, t2, u0, u1, u2 = step_crowded(middle, flux, site, q, D, dq, dt, f, a, g1, g2, g3)
    n0 += t0
    n2 += t2
    m0 += u0
    m1 += u1
    m2 += u2
    # Below.
    factor = math.exp(-g2 * dt)
    if whole_dt != dt:
        tables = spare
        tabulate(tables, row.size - HEADER, (g1 + g3) * dq * dt)
    at = max(zone - (zone - first + LANES - 1) // LANES * LANES, 0)
    below = row[HEADER + at : HEADER + zone]
    b0, b1, b2 = step_low(below, centre + at * dq, dq, factor, tables[1, LANES:])
    a0 = factor * b0
    a1 = factor * (b1 + D * b0)
    a2 = factor * (b2 + D * (2.0 * b1 + D * b0))
    work = 0.0
    if D != 0.0:
        work = dq * v * (b1 - a1 + v * (b0 - a0) / g2) / g2 if g2 > 0.0 else dq * D * (b1 + 0.5 * D * b0)
    flux[2, site] += work
    flux[1, site] += work - 0.5 * dq * (a2 - b2)
    # Above: what was there before is the rest of the known moments.
    above = cells[zone + bins + CELLS : last]
    q = centre + (zone + bins + CELLS) * dq
    G = g1 + g3
    dwell = high_dwell(above, q, v, dq, G, g3, dt) if g3 > 0.0 and D != 0.0 else 0.0
    factor = math.exp((g3 - G * (q + 0.5 * D)) * dt)
    t0, t1, t2 = step_high(row, zone + bins + CELLS, last, q + D, dq, factor, tables)
    if above.size > 0:
        h0, h2 = row[Q0] * bins - b0 - n0, row[Q2] * bins - b2 - n2
        work = 0.0
        if D != 0.0:
            work = dq * v * (h0 - t0 + g3 * dwell) / G if G > 0.0 else dq * D * (t1 - 0.5 * D * t0)
        flux[2, site] += work
        flux[1, site] += work - 0.5 * dq * (t2 - h2)
    row[START] = start + D
    row[Q0] = dq * (a0 + m0 + t0)
    row[Q1] = dq * (a1 + m1 + t1)
    row[Q2] = dq * (a2 + m2 + t2)
    row[FIRST], row[LAST] = first, last
    thin_out(row, new - zone)
    trim(row, math.floor(new), bins)


@nb.njit(**BARE)
def _crowded(row, a, bins):
    """Whether a mean in (0, 1) or in the zones is above the attachable fraction."""
    zone, count = int(row[ZONE]), count_parts(row)
    if some_above(row[PART0 : PART0 + count], a) or some_above(row[PART1 : PART1 + count], a):
        return True
    return some_above(row[HEADER + zone + CELLS : HEADER + zone + bins], a)


@nb.njit(inline="always", **BARE)
def _step_here(row, flux, site, D, dt, f, a, low, bins, rates, factor, work, after):
    """One site in place, while the row `after` it comes from memory."""
    scratch, tables, spare, table, _ = work
    _, g1, g2, g3 = rates
    hold_cut(row, bins, scratch)
    if D == 0.0 and (a >= 1.0 or not _crowded(row, a, bins)):
        react_site(row, flux, site, dt, f, a, g1, g2, g3, bins, factor, tables, table, after)
        return
    fetch(after, 0, HEADER)
    fetch(after, HEADER + int(row[FIRST]), HEADER + int(row[LAST]))
    parts = max(math.ceil(abs(D) * bins / (CELLS - 1.0)), 1)
    for _ in range(parts):
        _step_site(row, flux, site, D / parts, dt / parts, f, a, g1, g2, g3, bins, scratch, tables, spare, dt)
        flux[3, site] -= 0.5 * row[Q2]
        move_window(row, low, bins)
        flux[3, site] += 0.5 * row[Q2]


@nb.njit(**BARE)
def _each_site(
    sites, state, out, past, flux, displacement, dt, activation, overlap, by_rate, rates, low, bins, scale, work
):
    first, last = sites
    images = work[4]
    copy = images.shape[0] > 0
    ahead = 2 if copy else 1
    factor = math.exp(-rates[2] * dt)
    if copy:
        take_row(state[first], images[0])
    for site in range(first, last):
        for j in range(4):
            flux[j, site] = 0.0
        r = activation[site]
        o = overlap[site] if overlap.size > 1 else overlap[0]
        f = r * rates[0] if by_rate else rates[0]
        a = o if by_rate else r * o
        D = displacement[site] if displacement.size > 1 else displacement[0]
        row = images[(site - first) % 2] if copy else out[site]
        if copy:  # the next one, as numbers that have just been written cannot be read at once in other groups
            take_row(state[min(site + 1, last - 1)], images[(site + 1 - first) % 2])
        _step_here(row, flux, site, D, dt, f, a, low, bins, rates, factor, work, state[min(site + ahead, last - 1)])
        if past:
            stream_lines(row, out[site], 0, row.size)
        elif copy:
            copy_lines(row, out[site], 0, row.size)
        for j in range(4):
            flux[j, site] *= scale
    if past:
        arrive()


@nb.njit(**FAST)
def step_sites(
    sites, state, out, images, past, flux, displacement, dt, activation, overlap, by_rate, rates, low, bins, scale
):
    """Whole path at the `sites` (first, last): `state` (n, m) to `out`; fluxes (4, n) in units of p_max.

    `images` holds two rows of zeros, none where `out` is `state`; `past` tells whether results go past the caches: then
    rows of `out` and `images` have to be whole cache lines. `displacement` and `overlap` have one entry or one a site.
    """
    size = state.shape[1] - HEADER
    spare = np.empty((2, LANES + size))
    if state.shape[0] < 8:  # tables of the whole window are not worth while
        size = 0
        for site in range(state.shape[0]):
            cut = cut_at(state[site, START], bins)  # the zone, which a slide left behind, will be within CELLS of it
            size = max(size, int(max(state[site, LAST] - cut, cut - state[site, FIRST])))
        size = min(size + 2 * (LANES + CELLS), state.shape[1] - HEADER)
    tables = np.empty((2, LANES + size))
    tabulate(tables, size, (rates[1] + rates[3]) * dt / bins)
    scratch, table = np.empty(ROOM), np.empty(room_between(bins))
    table[-1] = -1.0  # stands for no rate yet
    _each_site(
        sites, state, out, past, flux, displacement, dt, activation, overlap, by_rate, rates, low, bins, scale,
        (scratch, tables, spare, table, images),
    )  # fmt: skip
