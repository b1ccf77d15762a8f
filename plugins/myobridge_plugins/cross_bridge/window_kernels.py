r"""Compiled kernels of a window of cells that rides with the filament: layout of a state row, slide, moving the window.

Cell `i` spans :math:`q \in s + [i, i+1]\,\Delta q` and stores the mean of :math:`\rho` in it; :math:`s` moves with the
filament, so a slide is one addition. The positions q=0 and q=1, where the rates jump, cut one cell each, at the same
fraction :math:`\theta` of its width (a reach is a whole number of cells); such a cell has a mean left and a mean right
of its cut, and its own mean is :math:`\theta L + (1-\theta) R`.

Moments count a cell at its centre, :math:`Q_k = \sum \bar\rho\,\Delta q\,(1, m, m^2 + \Delta q^2/12)`, cut or not:
then a slide shifts them exactly, :math:`Q_1 + x Q_0`, :math:`Q_2 + 2 x Q_1 + x^2 Q_0`.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge.interfaces import Array

__all__ = [
    "BLOCK",
    "FADED",
    "FAST",
    "FIRST",
    "HEADER",
    "LAST",
    "LEFT0",
    "LEFT1",
    "Q0",
    "Q1",
    "Q2",
    "RIGHT0",
    "RIGHT1",
    "START",
    "copy_row",
    "cut",
    "empty_window",
    "move_window",
    "slide_sites",
    "values",
]

# Columns of a state row before its cells.
START, Q0, Q1, Q2 = 0, 1, 2, 3  # q of the left face of cell 0; moments
LEFT0, RIGHT0, LEFT1, RIGHT1 = 4, 5, 6, 7  # means beside the cut at q=0 and at q=1
FIRST, LAST = 8, 9  # cells that may hold heads: FIRST <= i < LAST; all others are zero
HEADER = 16  # two cache lines
BLOCK = 16  # cells by which the window moves at a time
FADED = 1e-20  # means below are given up at the ends of the occupied range

FAST = {"cache": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "arcp", "nsz"}}


def empty_window(n_sites: int, n_cells: int, low: float, bins: int) -> Array:
    """State without heads whose window begins at or just below `low`, shape (n_sites, HEADER + n_cells)."""
    state = np.zeros((n_sites, HEADER + n_cells))
    origin = round(-low * bins)
    state[:, START], state[:, FIRST], state[:, LAST] = -origin / bins, origin, origin + bins + 1
    return state


@nb.njit(**FAST)
def cut(start, bins):
    """Cell that q=0 cuts, and at which fraction of it."""
    x = -start * bins
    cell = math.floor(x)
    return int(cell), x - cell


@nb.njit(**FAST)
def values(row, cell, start_cell, bins):
    """Means left and right of the cut inside `cell`, and whether it is cut."""
    if cell == start_cell:
        return row[LEFT0], row[RIGHT0], True
    if cell == start_cell + bins:
        return row[LEFT1], row[RIGHT1], True
    mean = row[HEADER + cell]
    return mean, mean, False


@nb.njit(**FAST)
def move_window(row, low, bins):
    """Move the cells by whole blocks so that the window begins at most a block below `low`; what leaves is lost."""
    start = row[START]
    dq = 1.0 / bins
    blocks = math.ceil((start - low) * bins / BLOCK - 1e-9)
    if blocks == 0:
        return
    shift = int(blocks) * BLOCK  # cells move to higher places when the window's start falls
    cells = row[HEADER:]
    n = cells.size
    first, last = int(row[FIRST]), int(row[LAST])
    d12 = dq * dq / 12.0
    lost = False
    for i in range(first, last):
        if (i + shift < 0 or i + shift >= n) and cells[i] > 0.0:
            cells[i] = 0.0
            lost = True
    first, last = min(max(first, -shift, 0), n), max(min(last, n - shift, n), 0)
    if shift > 0:
        for i in range(last - 1, first - 1, -1):
            x = cells[i]
            cells[i] = 0.0
            cells[i + shift] = x
    else:
        for i in range(first, last):
            x = cells[i]
            cells[i] = 0.0
            cells[i + shift] = x
    row[START] = start - shift * dq
    if first < last:
        row[FIRST], row[LAST] = first + shift, last + shift
    else:  # nothing is left: the occupied range is where heads can attach
        cell, _ = cut(row[START], bins)
        row[FIRST], row[LAST] = cell, cell + bins + 1
    if lost:  # summed anew, as differences could leave a negative rest
        s0 = s1 = s2 = 0.0
        for i in range(int(row[FIRST]), int(row[LAST])):
            m = row[START] + (i + 0.5) * dq
            s0 += cells[i]
            s1 += cells[i] * m
            s2 += cells[i] * (m * m + d12)
        row[Q0], row[Q1], row[Q2] = dq * s0, dq * s1, dq * s2


@nb.njit(**FAST)
def copy_row(row, out):
    """State row into `out`; cells outside the occupied range are zero."""
    first, last = int(row[FIRST]), int(row[LAST])
    out[:HEADER] = row[:HEADER]
    out[HEADER : HEADER + first] = 0.0
    out[HEADER + first : HEADER + last] = row[HEADER + first : HEADER + last]
    out[HEADER + last :] = 0.0


@nb.njit(**FAST)
def _recut(row, cell, old, theta, theta_end, bins):
    """Means left and right of the new cut at `theta_end` of a cell that was cut at `theta`, if at all."""
    left, right, is_cut = values(row, cell, old, bins)
    if is_cut and theta_end < theta:
        right = (left * (theta - theta_end) + right * (1.0 - theta)) / (1.0 - theta_end)
    elif is_cut and theta_end > theta:
        left = (left * theta + right * (theta_end - theta)) / theta_end
    return min(left, 1.0), min(right, 1.0)


@nb.njit(**FAST)
def slide_sites(state, out, copy, displacement, low, bins):
    """Carry the heads of all sites by `displacement` [reach]: `state` to `out`."""
    for site in range(state.shape[0]):
        row = out[site]
        if copy:
            copy_row(state[site], row)
        D = displacement[site]
        if D == 0.0:
            continue
        q0, q1 = row[Q0], row[Q1]
        row[Q1] = q1 + D * q0
        row[Q2] += D * (2.0 * q1 + D * q0)
        before = row[START]
        old, theta = cut(before, bins)
        row[START] = before + D
        move_window(row, low, bins)
        old += round((before + D - row[START]) * bins)
        new, theta_end = cut(row[START], bins)
        l0, r0 = _recut(row, new, old, theta, theta_end, bins)
        l1, r1 = _recut(row, new + bins, old, theta, theta_end, bins)
        row[LEFT0], row[RIGHT0], row[LEFT1], row[RIGHT1] = l0, r0, l1, r1
        row[FIRST], row[LAST] = min(int(row[FIRST]), new), max(int(row[LAST]), new + bins + 1)
