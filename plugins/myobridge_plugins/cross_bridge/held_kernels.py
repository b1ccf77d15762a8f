r"""Compiled kernels of a step with the filament held: what `exact_kernels` does without a path, and faster.

No mean is above the attachable fraction, and no part crosses a cut: every one decays or relaxes at a constant rate.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge_plugins.cross_bridge.label_kernels import LITTLE, decay, decay_little
from myobridge_plugins.cross_bridge.prefetch import fetch
from myobridge_plugins.cross_bridge.range_kernels import TINY, step_high, step_low
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
    PARTS,
    Q0,
    Q1,
    Q2,
    START,
    ZONE,
    count_parts,
    cut_at,
)
from myobridge_plugins.cross_bridge.zone_kernels import ROOM

__all__ = ["react_site"]

# Places of the scratch array, see `zone_kernels`.
_WITHIN, _ABOVE, _SHARE0, _SHARE1 = 0, 16, 32, 48


@nb.njit(**PART)
def _hold_mid(cells, q, dq, c, F, dt, scratch):
    """Cells from the zone at q=0 to that at q=1, filament held, the first of the zone's centred at q.

    Those of the zone itself are stepped in vain, as long loops of even length vectorise. Sums of the others: moments
    after, second moment gained.
    """
    fade = scratch[ROOM:]
    if c * dt <= LITTLE:
        for i in range(cells.size):
            fade[i] = decay_little(-c * dt * (q + i * dq))
    else:
        for i in range(cells.size):
            fade[i] = decay(-c * dt * (q + i * dq))
    s0 = s1 = s2 = gained = 0.0
    for i in range(cells.size):
        between = i >= CELLS
        m = q + i * dq
        x = cells[i]
        z = F + (x - F) * fade[i]
        z = z if z > TINY else 0.0
        cells[i] = z
        x = z - x if between else 0.0
        z = z if between else 0.0
        y = z * m
        s0 += z
        s1 += y
        s2 += y * m
        gained += x * m * m
    return s0, s1, s2, gained


@nb.njit(**PART)
def _hold_zones(row, dt, c, F, factor, G, g3, bins, scratch):
    """Parts of both zones, filament held: moment sums after, and what (0, 1) gained: int q^2 d rho, int q^2 p dt."""
    dq = 1.0 / bins
    zone = int(row[ZONE])
    start = row[START] + zone * dq
    # Factors of the parts: in (0, 1), right of the cut in the zone at q=0 and left of it in the other; above q=1.
    if max(c, G) * dt * CELLS * dq <= LITTLE:  # products of a number for all and one near 1
        leap, far = decay(-c * dt), decay((g3 - G) * dt)
        for k in range(PARTS):
            p = start + 0.5 * (row[FACE + k - 1] + row[FACE + k]) * dq
            scratch[_WITHIN + k] = (1.0 if p > 0.0 else leap) * decay_little(-c * p * dt)
            scratch[_ABOVE + k] = far * decay_little(-G * p * dt)
    else:
        for k in range(PARTS):
            p = start + 0.5 * (row[FACE + k - 1] + row[FACE + k]) * dq
            scratch[_WITHIN + k] = decay(-c * (p if p > 0.0 else p + 1.0) * dt)
            scratch[_ABOVE + k] = decay((g3 - G * (p + 1.0)) * dt)
    a0 = a1 = a2 = gained = weighted = 0.0
    for k in range(PARTS):  # places that are not used have length 0
        left, right = row[FACE + k - 1], row[FACE + k]
        length = right - left
        p = start + 0.5 * (left + right) * dq
        m = start + (np.floor(left) + 0.5) * dq
        x0, x1 = row[PART0 + k], row[PART1 + k]
        inside = p > 0.0  # (0, 1) takes the right of the zone at q=0 and the left of that at q=1
        x_mid = x0 if inside else x1
        y_mid = F + (x_mid - F) * scratch[_WITHIN + k]
        y_out = x1 * scratch[_ABOVE + k] if inside else x0 * factor
        x0, x1 = (y_mid, y_out) if inside else (y_out, y_mid)
        x0, x1 = x0 if x0 > TINY else 0.0, x1 if x1 > TINY else 0.0
        row[PART0 + k], row[PART1 + k] = x0, x1
        x0, x1 = length * x0, length * x1
        scratch[_SHARE0 + k], scratch[_SHARE1 + k] = x0, x1
        y = x1 * (m + 1.0)
        a0 += x0 + x1
        a1 += x0 * m + y
        a2 += x0 * m * m + y * (m + 1.0)
        p_mid, m_mid = (p, m) if inside else (p + 1.0, m + 1.0)
        m_mid *= m_mid * length
        gained += m_mid * (y_mid - x_mid)
        weighted += m_mid * p_mid
    here = HEADER + zone
    left, mean0, mean1 = 0.0, 0.0, 0.0
    for k in range(
        count_parts(row)
    ):  # every part writes the sum so far into its cell: no branch that could be mistaken
        i = int(left)
        again = left > i
        left = row[FACE + k]
        mean0 = scratch[_SHARE0 + k] + (mean0 if again else 0.0)
        mean1 = scratch[_SHARE1 + k] + (mean1 if again else 0.0)
        row[here + i], row[here + bins + i] = min(mean0, 1.0), min(mean1, 1.0)
    return a0, a1, a2, gained, weighted * dt


@nb.njit(**BARE)
def react_site(row, flux, site, dt, f, a, g1, g2, g3, bins, factor, tables, scratch, after):
    """One site. The row `after` it comes from memory meanwhile, in portions: too many requests at once would wait."""
    dq = 1.0 / bins
    zone = int(row[ZONE])
    first, last = min(int(row[FIRST]), zone), max(int(row[LAST]), zone + bins + CELLS)
    cells = row[HEADER:]
    centre = row[START] + 0.5 * dq
    G = g1 + g3
    c = f + g1
    F = f * a / c if c > 0.0 else 0.0
    fetch(after, 0, HEADER)
    # Ranges are stepped in whole LANES, unless there are not so many cells below.
    b0 = b1 = b2 = 0.0
    if first < zone:
        at = max(zone - (zone - first + LANES - 1) // LANES * LANES, 0)
        b0, b1, b2 = step_low(row[HEADER + at : HEADER + zone], centre + at * dq, dq, factor, tables[1, LANES:])
    fetch(after, HEADER + first, HEADER + zone + bins)
    u0, u1, u2, gained = _hold_mid(cells[zone : zone + bins], centre + zone * dq, dq, c, F, dt, scratch)
    at = zone + bins + CELLS
    q = centre + at * dq
    fetch(after, HEADER + zone + bins, HEADER + (at + last) // 2)
    a0 = a1 = a2 = 0.0
    if at < last:
        a0, a1, a2 = step_high(row, at, last, q, dq, decay((g3 - G * q) * dt), tables, scratch)
    fetch(after, HEADER + (at + last) // 2, HEADER + last)
    v0, v1, v2, gained_parts, weighted = _hold_zones(row, dt, c, F, factor, G, g3, bins, scratch)
    # Within (0, 1), rho' = c q (F - rho), so that the detached energy follows from the change and from int q dt.
    k = bins - float(CELLS)
    p = centre + (zone + CELLS) * dq + 0.5 * dq * (k - 1.0)
    weighted += k * p * (p * p + 0.25 * dq * dq * (k * k - 1.0)) * dt
    gained += gained_parts
    attached = 0.5 * dq * (gained + (g1 * (F * weighted - gained / c) if c > 0.0 else 0.0))
    before = row[Q2]
    row[Q0] = dq * (factor * b0 + u0 + a0 + v0)
    row[Q1] = dq * (factor * b1 + u1 + a1 + v1)
    row[Q2] = dq * (factor * b2 + u2 + a2 + v2)
    flux[0, site] += attached
    flux[1, site] += attached - 0.5 * (row[Q2] - before)
    row[FIRST], row[LAST] = first, last
    trim(row, math.floor(cut_at(row[START], bins)), bins)
