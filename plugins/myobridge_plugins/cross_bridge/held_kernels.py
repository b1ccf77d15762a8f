r"""Compiled kernels of a step with the filament held: what `exact_kernels` does without a path, and faster.

No mean is above the attachable fraction, and no part crosses a cut: every one decays or relaxes at a constant rate.
"""

from __future__ import annotations

import math

import numba as nb

from myobridge_plugins.cross_bridge.label_kernels import LITTLE, decay, decay_above, decay_little
from myobridge_plugins.cross_bridge.prefetch import fetch
from myobridge_plugins.cross_bridge.range_kernels import TINY, step_high, step_low
from myobridge_plugins.cross_bridge.row_vectors import (
    above,
    at_least,
    floor_of,
    give,
    sum_of,
    sum_where,
    take,
    where_positive,
)
from myobridge_plugins.cross_bridge.window_kernels import trim
from myobridge_plugins.cross_bridge.window_layout import (
    BARE,
    CELLS,
    FACE,
    FIRST,
    HEADER,
    LANES,
    LAST,
    PART,
    PART0,
    PART1,
    Q0,
    Q1,
    Q2,
    START,
    ZONE,
    cut_at,
)

__all__ = ["react_site", "room_between"]


@nb.njit(**BARE)
def room_between(bins):
    """Size of the table of `_tabulate`."""
    return 3 * _places(bins) + 3


@nb.njit(**PART)
def _places(bins):
    """Cells between the zones and some before them: whole vectors."""
    return (bins - CELLS + LANES - 1) // LANES * LANES


@nb.njit(**BARE)
def _tabulate(table, bins, c, G, g3, dt):
    """What sites of the same rates share: of the cells between the zones, see `_hold_mid`, and factors of the zones.

    Numbers of the cells, counted from the first between the zones; 1 for these, 0 for those before; what they fade by
    more than the first. Factors at q=1; the rate for which all this stands.
    """
    n = _places(bins)
    for i in range(n):
        number = float(i - n + bins - CELLS)
        table[i] = number
        table[n + i] = 1.0 if number >= 0.0 else 0.0
        table[2 * n + i] = decay(-c * dt / bins * max(number, 0.0))
    table[3 * n], table[3 * n + 1], table[3 * n + 2] = decay(-c * dt), decay((g3 - G) * dt), c


@nb.njit(**PART)
def _hold_mid(row, end, n, q, dq, F, first, table):
    """Cells between the zones, filament held, before place `end`; the first is centred at q and fades by `first`.

    Whole vectors are stepped: of what stands before the cells nothing changes. Sums: moments after, second moment
    gained.
    """
    s0 = s1 = s2 = gained = 0.0
    for i in range(0, n, LANES):
        x, between = take(row, end - n + i), take(table, n + i)
        m = take(table, i) * dq + q
        z = above((x - F) * (take(table, 2 * n + i) * first) + F, TINY)
        give(row, end - n + i, where_positive(between, z, x))
        mass = between * m
        s0 += sum_of(between * z)
        s1 += sum_of(mass * z)
        mass = mass * m
        s2 += sum_of(mass * z)
        gained += sum_of(mass * (z - x))
    return s0, s1, s2, gained


@nb.njit(**PART)
def _hold_zones(row, dt, c, F, factor, G, g3, leap, far, bins):
    """Parts of both zones, filament held: moment sums after, and what (0, 1) gained: int q^2 d rho, int q^2 p dt.

    `leap` and `far` are the factors of (0, 1) and of what is above, both at q=1.
    """
    dq = 1.0 / bins
    zone = int(row[ZONE])
    start = row[START] + zone * dq
    left, right = take(row, FACE - 1), take(row, FACE)
    length = right - left  # 0 in places that are not used
    p = (left + right) * (0.5 * dq) + start
    # Factors of the parts: in (0, 1), right of the cut in the zone at q=0 and left of it in the other; above q=1.
    if max(c, G) * dt * CELLS * dq <= LITTLE:  # products of a number for all and one near 1
        near = decay_little(p * (-c * dt))
        within = where_positive(p, near, near * leap)
        beyond = decay_little(p * (-G * dt)) * far
    else:
        within = decay_above(at_least(where_positive(p, p, p + 1.0) * (-c * dt), -40.0))
        beyond = decay_above(at_least(p * (-G * dt) + (g3 - G) * dt, -40.0))
    x0, x1 = take(row, PART0), take(row, PART1)
    # (0, 1) takes the right of the zone at q=0 and the left of that at q=1.
    before = where_positive(p, x0, x1)
    after = (before - F) * within + F
    outside = above(where_positive(p, x1 * beyond, x0 * factor), TINY)
    inside = above(after, TINY)
    x0, x1 = where_positive(p, inside, outside), where_positive(p, outside, inside)
    give(row, PART0, x0)
    give(row, PART1, x1)
    cell = floor_of(left)
    x0, x1 = length * x0, length * x1
    here = HEADER + zone
    for i in range(CELLS):
        row[here + i] = min(sum_where(x0, cell, float(i)), 1.0)
        row[here + bins + i] = min(sum_where(x1, cell, float(i)), 1.0)
    m0 = (cell + 0.5) * dq + start
    m1 = m0 + 1.0
    y0, y1 = x0 * m0, x1 * m1
    s0, s1, s2 = sum_of(x0 + x1), sum_of(y0 + y1), sum_of(y0 * m0 + y1 * m1)
    middle = where_positive(p, m0, m1)
    share = middle * middle * length
    return s0, s1, s2, sum_of(share * (after - before)), sum_of(share * where_positive(p, p, p + 1.0)) * dt


@nb.njit(**PART)
def react_site(row, flux, site, dt, f, a, g1, g2, g3, bins, factor, tables, table, after):
    """One site. The row `after` it comes from memory meanwhile, in portions: too many requests at once would wait."""
    dq = 1.0 / bins
    zone = int(row[ZONE])
    first, last = min(int(row[FIRST]), zone), max(int(row[LAST]), zone + bins + CELLS)
    centre = row[START] + 0.5 * dq
    G = g1 + g3
    c = f + g1
    attaching = f / c if c > 0.0 else 0.0
    F = attaching * a
    fetch(after, 0, HEADER)
    n = _places(bins)
    if table[3 * n + 2] != c:
        _tabulate(table, bins, c, G, g3, dt)
    # All that takes long in a row is begun first.
    q = centre + (zone + CELLS) * dq
    if max(c, G) * dt * (q + 1.0) <= LITTLE:
        first_mid, first_high = decay_little(-c * dt * q), decay_little((g3 - G * (q + 1.0)) * dt)
    else:
        first_mid, first_high = decay(-c * dt * q), decay((g3 - G * (q + 1.0)) * dt)
    # Ranges are stepped in whole LANES, unless there are not so many cells below.
    b0 = b1 = b2 = 0.0
    if first < zone:
        at = max(zone - (zone - first + LANES - 1) // LANES * LANES, 0)
        b0, b1, b2 = step_low(row[HEADER + at : HEADER + zone], centre + at * dq, dq, factor, tables[1, LANES:])
    fetch(after, HEADER + first, HEADER + zone + bins)
    end = HEADER + zone + bins
    u0, u1, u2, gained = _hold_mid(row, end, n, q, dq, F, first_mid, table)
    at = zone + bins + CELLS
    fetch(after, HEADER + zone + bins, HEADER + (at + last) // 2)
    a0 = a1 = a2 = 0.0
    if at < last:
        a0, a1, a2 = step_high(row, at, last, q + 1.0, dq, first_high, tables)
    fetch(after, HEADER + (at + last) // 2, HEADER + last)
    v0, v1, v2, gained_parts, weighted = _hold_zones(row, dt, c, F, factor, G, g3, table[3 * n], table[3 * n + 1], bins)
    # Within (0, 1), rho' = c q (F - rho), so that the attached energy follows from the change and from int q dt.
    k = bins - float(CELLS)
    p = q + 0.5 * dq * (k - 1.0)
    weighted += k * p * (p * p + 0.25 * dq * dq * (k * k - 1.0)) * dt
    gained += gained_parts
    attached = 0.5 * dq * (attaching * gained + g1 * F * weighted)
    before = row[Q2]
    row[Q0] = dq * (factor * b0 + u0 + a0 + v0)
    row[Q1] = dq * (factor * b1 + u1 + a1 + v1)
    row[Q2] = dq * (factor * b2 + u2 + a2 + v2)
    flux[0, site] += attached
    flux[1, site] += attached - 0.5 * (row[Q2] - before)
    row[FIRST], row[LAST] = first, last
    trim(row, math.floor(cut_at(row[START], bins)), bins)
