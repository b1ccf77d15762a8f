"""Compiled kernels of the window of cells: slide, moving the window, giving up its ends, copies of rows."""

from __future__ import annotations

import math

import numba as nb

from myobridge.cache_lines import LINE
from myobridge_plugins.cross_bridge.prefetch import fetch
from myobridge_plugins.cross_bridge.row_moves import clear_lines, copy_lines
from myobridge_plugins.cross_bridge.window_layout import (
    BARE,
    BARE_ENTRY,
    BLOCK,
    CELLS,
    FACE,
    FIRST,
    HEADER,
    LAST,
    PART,
    Q0,
    Q1,
    Q2,
    START,
    ZONE,
    cut_at,
)

__all__ = ["copy_row", "gather_moments", "move_window", "slide_sites", "take_row", "trim"]

AHEAD = 16  # sites whose first line is asked for while one is worked on: that takes no time, memory does
FADED = 1e-20  # means below are given up at the ends of the occupied range


@nb.njit(**PART)
def trim(row, cell, bins):
    """Give up faded cells at the ends of the occupied range, outside the zones' cuts; `cell` is cut by q=0."""
    first, last = int(row[FIRST]), int(row[LAST])
    cells = row[HEADER:]
    while first < cell - CELLS and cells[first] < FADED:
        cells[first] = 0.0
        first += 1
    while last > cell + bins + CELLS + 1 and cells[last - 1] < FADED:
        cells[last - 1] = 0.0
        last -= 1
    row[FIRST], row[LAST] = first, last


@nb.njit(**BARE)
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
    row[ZONE] += shift
    if first < last:
        row[FIRST], row[LAST] = first + shift, last + shift
    else:  # nothing is left: the occupied range is where heads can attach
        cell = math.floor(cut_at(row[START], bins))
        row[FIRST], row[LAST] = cell, cell + bins + 1
    if lost:  # summed anew, as differences could leave a negative rest
        s0 = s1 = s2 = 0.0
        for i in range(int(row[FIRST]), int(row[LAST])):
            m = row[START] + (i + 0.5) * dq
            s0 += cells[i]
            s1 += cells[i] * m
            s2 += cells[i] * m * m
        row[Q0], row[Q1], row[Q2] = dq * s0, dq * s1, dq * s2


@nb.njit(**PART)
def _lines(row):
    """Places of the lines that hold the occupied range, all within the row, which is whole lines."""
    return HEADER + int(row[FIRST]) // LINE * LINE, HEADER + (int(row[LAST]) + LINE - 1) // LINE * LINE


@nb.njit(**PART)
def copy_row(row, out):
    """State row into `out`; cells outside the occupied range are zero."""
    first, last = _lines(row)
    copy_lines(row, out, 0, HEADER)
    clear_lines(out, HEADER, first)
    copy_lines(row, out, first, last)
    clear_lines(out, last, row.size)


@nb.njit(**PART)
def take_row(row, image):
    """State row into `image`, which holds an earlier row: few cells have to be set to zero."""
    stale_first, stale_last = _lines(image)
    first, last = _lines(row)
    copy_lines(row, image, 0, HEADER)
    copy_lines(row, image, first, last)
    clear_lines(image, stale_first, min(stale_last, first))
    clear_lines(image, max(stale_first, last), stale_last)


@nb.njit(**BARE_ENTRY)
def slide_sites(sites, state, out, copy, gained, displacement, low, bins):
    """Carry the heads at the `sites` (first, last) by `displacement` [reach]. The zones follow in the next step.

    What the second moments gained is written into `gained` where it has entries.
    """
    for site in range(sites[0], sites[1]):
        fetch(state[min(site + AHEAD, sites[1] - 1)], 0, FACE)
        row = out[site]
        if copy:
            copy_row(state[site], row)
        D, before = displacement[site], row[Q2]
        if D != 0.0:
            q0, q1 = row[Q0], row[Q1]
            row[Q1] = q1 + D * q0
            row[Q2] += D * (2.0 * q1 + D * q0)
            row[START] += D
            row[ZONE] = math.floor(row[ZONE]) + 0.5
            move_window(row, low, bins)
        if gained.size > 0:
            gained[site] = row[Q2] - before


@nb.njit(**BARE_ENTRY)
def gather_moments(sites, state, found):
    """Moments at the `sites` (first, last), of which every one waits in a cache line of its own."""
    for site in range(sites[0], sites[1]):
        fetch(state[min(site + AHEAD, sites[1] - 1)], 0, FACE)
        row = state[site]
        found[site, 0], found[site, 1], found[site, 2] = row[Q0], row[Q1], row[Q2]
