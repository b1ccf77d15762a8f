r"""Compiled kernels of a window of cells that rides with the filament: layout of a state row, slide, moving the window.

Cell `i` spans :math:`q \in s + [i, i+1]\,\Delta q` and stores the mean of :math:`\rho` in it; :math:`s` moves with
the filament, so a slide is one addition. The positions q=0 and q=1, where the rates jump, cut one cell each, at the
same fraction of its width (a reach is a whole number of cells). Around each cut lies a *zone* of a few cells that are
divided further: at the cut, and at faces that the cut left behind where it turned or stopped. Both zones have the same
faces. Those across which the means differ least are given up when there are too many.

Moments count a cell at its centre, divided or not, :math:`Q_k = \sum \bar\rho\,\Delta q\,(1, m, m^2)`: then a slide
shifts them exactly, :math:`Q_1 + x Q_0`, :math:`Q_2 + 2 x Q_1 + x^2 Q_0`.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge.interfaces import Array

# Columns of a state row before its cells.
START, Q0, Q1, Q2 = 0, 1, 2, 3  # q of the left face of cell 0; moments
FIRST, LAST = 4, 5  # cells that may hold heads: FIRST <= i < LAST; all others are zero
ZONE, COUNT = 6, 7  # first cell of the zone at q=0 (that at q=1 begins a reach later); parts of a zone
MADE = 8  # START for which the zones hold the cut; a slide leaves it behind, the next step catches up
FACE = 9  # faces of the zone's parts, in cells from its beginning, COUNT + 1 of them
PARTS = 16  # most parts of a zone; long loops take all places, used or not, so that they vectorise
PART0 = FACE + PARTS + 1  # means of the parts of the zone at q=0
PART1 = PART0 + PARTS  # and at q=1
HEADER = 80  # ten cache lines; the last LANES columns are zero
LANES = 16  # cells are stepped by so many: the rest of a vector loop is slow
CELLS = 6  # cells of a zone
BLOCK = 16  # cells by which the window moves at a time
FADED = 1e-20  # means below are given up at the ends of the occupied range
NEAR = 1e-7  # a face nearer to another than this part of a cell is the same
ALIKE = 1e-7  # difference of neighbouring means, weighed by their lengths, below which their face is given up

# Compiled kernels are cached beside their file. The cache does not see edits of other files: whoever edits a kernel
# that another file imports, or these numbers, deletes `__pycache__/*.nb?` here. (An installation renews all files.)
# They hold no lock, so that sites can be shared out among threads.
FAST = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "arcp", "nsz"}}
# No counts of references: every view of an array would cost two atomic operations, a third of the time of a step. Such
# kernels cannot allocate arrays.
BARE_ENTRY = {**FAST, "_nrt": False}
# Of what only kernels call: without the entry for Python, which takes a sixth of the time of compiling.
BARE = {**BARE_ENTRY, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def empty_window(n_sites: int, n_cells: int, low: float, bins: int) -> Array:
    """State without heads whose window begins at or just below `low`, shape (n_sites, HEADER + n_cells)."""
    state = np.zeros((n_sites, HEADER + n_cells))
    origin = round(-low * bins)
    state[:, START] = state[:, MADE] = -origin / bins
    state[:, FIRST], state[:, LAST] = origin, origin + bins + 1
    state[:, ZONE], state[:, COUNT] = origin - CELLS // 2, CELLS
    state[:, FACE : FACE + CELLS + 1] = np.arange(CELLS + 1)
    return state


def fill_window(state: Array, rho: float, bins: int) -> None:
    """Fill (0, 1) of an empty window with the mean `rho`, in place."""
    zone, half = int(state[0, ZONE]), CELLS // 2
    state[:, HEADER + zone + half : HEADER + zone + half + bins] = rho
    state[:, PART0 + half : PART0 + CELLS] = rho
    state[:, PART1 : PART1 + half] = rho
    state[:, Q0], state[:, Q1] = rho, 0.5 * rho
    state[:, Q2] = rho * (1.0 / 3.0 - 1.0 / (12.0 * bins**2))


@nb.njit(**BARE)
def cut_at(start, bins):
    """Where q=0 cuts, in cells from the window's start."""
    return -start * bins


@nb.njit(**BARE)
def enter_zone(row, cell, other, bins, scratch):
    """Move the zones so that they contain `cell`, and `other` if it is near; divided cells that stay remain so."""
    zone = int(row[ZONE])
    if zone <= cell < zone + CELLS:
        return
    place = (cell + other) // 2 - CELLS // 2 if abs(cell - other) < CELLS else cell - CELLS // 2
    place = min(max(place, cell - CELLS + 1), cell)
    count, k = int(row[COUNT]), 0
    n = 0
    for i in range(CELLS):
        old = place + i - zone
        if 0 <= old < CELLS:
            while row[FACE + k] < old:
                k += 1
            while k < count and row[FACE + k] < old + 1:
                scratch[0, n] = row[FACE + k] - old + i
                scratch[1, n], scratch[2, n] = row[PART0 + k], row[PART1 + k]
                n += 1
                k += 1
        else:
            scratch[0, n] = i
            scratch[1, n], scratch[2, n] = row[HEADER + place + i], row[HEADER + place + i + bins]
            n += 1
    for k in range(n):
        row[FACE + k], row[PART0 + k], row[PART1 + k] = scratch[0, k], scratch[1, k], scratch[2, k]
    row[FACE + n] = CELLS
    row[ZONE], row[COUNT] = place, n


@nb.njit(**BARE)
def part_slope(row, first_part, first_cell, k, before, width_before):
    """Slope of a linear profile within part `k` that stays between the means of its neighbours.

    `before` and `width_before` are those of the part to the left.
    """
    width = row[FACE + k + 1] - row[FACE + k]
    if k + 1 < row[COUNT]:
        after, width_after = row[first_part + k + 1], row[FACE + k + 2] - row[FACE + k + 1]
    else:
        after, width_after = row[HEADER + first_cell + CELLS], 1.0
    rise, fall = row[first_part + k] - before, after - row[first_part + k]
    if rise * fall <= 0.0:
        return 0.0
    mean = abs(after - before) / (width + 0.5 * (width_before + width_after))
    return math.copysign(min(mean, 2.0 * min(abs(rise), abs(fall)) / width), rise)


@nb.njit(**BARE)
def divide(row, y, bins):
    """Add a face at `y` cells from the zone's beginning; `thin_out` left room for it."""
    n = int(row[COUNT])
    faces = row[FACE + 1 : PART0]
    k = 0
    for j in range(PARTS):
        k += 1 if (j + 1 < n) & (faces[j] <= y) else 0
    if y - row[FACE + k] < NEAR or row[FACE + k + 1] - y < NEAR:
        return
    width_before = row[FACE + k] - row[FACE + k - 1] if k > 0 else 1.0
    place, left, right = int(row[ZONE]), y - row[FACE + k], row[FACE + k + 1] - y
    slopes = (
        part_slope(row, PART0, place, k, row[PART0 + k - 1] if k > 0 else row[HEADER + place - 1], width_before),
        part_slope(
            row, PART1, place + bins, k, row[PART1 + k - 1] if k > 0 else row[HEADER + place + bins - 1], width_before
        ),
    )
    for j in range(n, k, -1):
        row[FACE + j + 1] = row[FACE + j]
        row[PART0 + j], row[PART1 + j] = row[PART0 + j - 1], row[PART1 + j - 1]
    for part, slope in ((PART0 + k, slopes[0]), (PART1 + k, slopes[1])):
        mean = row[part]
        row[part] = min(max(mean - 0.5 * slope * right, 0.0), 1.0)
        row[part + 1] = min(max(mean + 0.5 * slope * left, 0.0), 1.0)
    row[FACE + k + 1] = y
    row[COUNT] = n + 1


@nb.njit(inline="always", **BARE)
def _loss(row, k, n, y):
    """What giving up face `k` of a zone with `n` parts costs: difference of the means, weighed by their lengths."""
    face, before, after = row[FACE + k], row[FACE + k - 1], row[FACE + k + 1]
    left, right = face - before, after - face
    jump = abs(row[PART0 + k] - row[PART0 + k - 1]) + abs(row[PART1 + k] - row[PART1 + k - 1])
    # The first has no part before it: what stands there does not matter.
    kept = (k < 1) | (k >= n) | (face == np.floor(face)) | (abs(face - y) < 2.0 * NEAR)
    return math.inf if kept else jump * left * right / (left + right)


@nb.njit(**BARE)
def thin_out(row, y):
    """Give up faces across which the means are alike, and others until there is room; not the cut at `y`."""
    while True:
        n, alike = int(row[COUNT]), 0
        for k in range(PARTS):
            alike += 1 if _loss(row, k, n, y) < ALIKE else 0
        if alike == 0 and n < PARTS:
            return
        best, least = 0, math.inf
        for k in range(1, n):
            loss = _loss(row, k, n, y)
            if loss < least:
                best, least = k, loss
        if best == 0:
            return
        left, right = row[FACE + best] - row[FACE + best - 1], row[FACE + best + 1] - row[FACE + best]
        for part in (PART0 + best, PART1 + best):
            mean = (left * row[part - 1] + right * row[part]) / (left + right)
            row[part - 1] = min(mean, 1.0)
        for k in range(best, n - 1):
            row[FACE + k] = row[FACE + k + 1]
            row[PART0 + k], row[PART1 + k] = row[PART0 + k + 1], row[PART1 + k + 1]
        row[FACE + n - 1] = row[FACE + n]
        row[COUNT] = n - 1
        if alike <= 1:  # what this has made alike can wait
            return


@nb.njit(**BARE)
def hold_cut(row, bins, scratch):
    """Bring the zones to the cut, which slides may have moved; parts that it left behind are kept for its return."""
    if row[MADE] == row[START]:
        return
    y = cut_at(row[START], bins)
    enter_zone(row, math.floor(y), int(row[ZONE]) + CELLS // 2, bins, scratch)
    divide(row, y - row[ZONE], bins)
    thin_out(row, y - row[ZONE])
    row[MADE] = row[START]


@nb.njit(**BARE)
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
    row[MADE] -= shift * dq
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


@nb.njit(**BARE)
def copy_row(row, out):
    """State row into `out`; cells outside the occupied range are zero."""
    first, last = int(row[FIRST]), int(row[LAST])
    for i in range(HEADER):
        out[i] = row[i]
    for i in range(HEADER, HEADER + first):
        out[i] = 0.0
    for i in range(HEADER + first, HEADER + last):
        out[i] = row[i]
    for i in range(HEADER + last, row.size):
        out[i] = 0.0


@nb.njit(**BARE_ENTRY)
def slide_sites(state, out, copy, displacement, low, bins):
    """Carry the heads of all sites by `displacement` [reach]: `state` to `out`. The zones follow in the next step."""
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
        row[START] += D
        move_window(row, low, bins)
