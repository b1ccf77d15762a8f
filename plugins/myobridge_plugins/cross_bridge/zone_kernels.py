"""Compiled kernels of the zones of divided cells at q=0 and q=1: they follow the cut, gain faces and give them up."""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from myobridge_plugins.cross_bridge.row_moves import close_gap, make_room
from myobridge_plugins.cross_bridge.window_layout import (
    BARE,
    CELLS,
    FACE,
    HEADER,
    PART,
    PART0,
    PART1,
    PARTS,
    START,
    ZONE,
    count_parts,
    cut_at,
)

__all__ = ["ROOM", "divide", "enter_zone", "hold_cut", "part_slope", "thin_out"]

NEAR = 1e-7  # a face nearer to another than this part of a cell is the same
ALIKE = 1e-7  # difference of neighbouring means, weighed by their lengths, below which their face is given up
# Places of the scratch array, at fixed distances: of arrays of their own the compiler would not know that they are
# apart, and check it before every loop.
_FACE, _PART0, _PART1 = 0, 32, 64
ROOM = 128


@nb.njit(**BARE)
def enter_zone(row, cell, other, bins, scratch):
    """Move the zones so that they contain `cell`, and `other` if it is near; divided cells that stay remain so."""
    zone = int(row[ZONE])
    if zone <= cell < zone + CELLS:
        return
    place = (cell + other) // 2 - CELLS // 2 if abs(cell - other) < CELLS else cell - CELLS // 2
    place = min(max(place, cell - CELLS + 1), cell)
    count, k, n = count_parts(row), 0, 0
    for i in range(CELLS):
        old = place + i - zone
        if 0 <= old < CELLS:
            while row[FACE + k] <= old:
                k += 1
            while k < count and row[FACE + k] <= old + 1:
                scratch[_FACE + n] = row[FACE + k] - old + i
                scratch[_PART0 + n], scratch[_PART1 + n] = row[PART0 + k], row[PART1 + k]
                n += 1
                k += 1
        else:
            scratch[_FACE + n] = i + 1
            scratch[_PART0 + n], scratch[_PART1 + n] = row[HEADER + place + i], row[HEADER + place + i + bins]
            n += 1
    for k in range(PARTS):
        used = k < n
        row[FACE + k] = scratch[_FACE + k] if used else float(CELLS)
        row[PART0 + k] = scratch[_PART0 + k] if used else 0.0
        row[PART1 + k] = scratch[_PART1 + k] if used else 0.0
    row[ZONE] = place


@nb.njit(**BARE)
def part_slope(mean, before, after, width, width_before, width_after):
    """Slope of a linear profile within a part that stays between the means of its neighbours."""
    rise, fall = mean - before, after - mean
    if rise * fall <= 0.0:
        return 0.0
    slope = abs(after - before) / (width + 0.5 * (width_before + width_after))
    return math.copysign(min(slope, 2.0 * min(abs(rise), abs(fall)) / width), rise)


@nb.njit(**PART)
def divide(row, y, bins):
    """Add a face at `y` cells from the zone's beginning; `thin_out` left room for it."""
    k = 0
    for j in range(PARTS):
        k += 1 if row[FACE + j] <= y else 0
    start, end = row[FACE + k - 1], row[FACE + k]
    left, right = y - start, end - y
    if left < NEAR or right < NEAR:
        return
    # The neighbours of the part, whole cells outside the zone.
    before = row[FACE + k - 2] if k > 0 else -1.0
    after = row[FACE + k + 1] if end < CELLS else CELLS + 1.0
    width, width_before, width_after = end - start, start - before, after - end
    place = HEADER + int(row[ZONE])
    mean0, mean1 = row[PART0 + k], row[PART1 + k]
    slope0 = part_slope(
        mean0,
        row[PART0 + k - 1] if k > 0 else row[place - 1],
        row[PART0 + k + 1] if end < CELLS else row[place + CELLS],
        width, width_before, width_after,
    )  # fmt: skip
    slope1 = part_slope(
        mean1,
        row[PART1 + k - 1] if k > 0 else row[place + bins - 1],
        row[PART1 + k + 1] if end < CELLS else row[place + bins + CELLS],
        width, width_before, width_after,
    )  # fmt: skip
    make_room(row, FACE, k)
    make_room(row, PART0, k)
    make_room(row, PART1, k)
    row[FACE + k] = y
    row[PART0 + k] = min(max(mean0 - 0.5 * slope0 * right, 0.0), 1.0)
    row[PART0 + k + 1] = min(max(mean0 + 0.5 * slope0 * left, 0.0), 1.0)
    row[PART1 + k] = min(max(mean1 - 0.5 * slope1 * right, 0.0), 1.0)
    row[PART1 + k + 1] = min(max(mean1 + 0.5 * slope1 * left, 0.0), 1.0)


@nb.njit(**PART)
def _cheapest(row, y):
    """Face that costs least to give up, in the last four bits below its cost as an integer; how many are alike.

    The cost is the difference of the means, weighed by their lengths. Positive numbers are in the order of their bits.
    """
    least, alike = np.int64(0x7FFFFFFFFFFFFFFF), 0
    for j in range(PARTS):
        face, before, after = row[FACE + j], row[FACE + j - 1], row[FACE + j + 1]
        left, right = face - before, after - face
        jump = abs(row[PART0 + j + 1] - row[PART0 + j]) + abs(row[PART1 + j + 1] - row[PART1 + j])
        # Faces of whole cells stay: also that after the last part, so that what stands behind it does not matter.
        kept = (face == np.floor(face)) | (abs(face - y) < 2.0 * NEAR)
        loss = math.inf if kept else jump * left * right / (left + right)
        alike += 1 if loss < ALIKE else 0
        least = min(least, (np.float64(loss).view(np.int64) & ~np.int64(15)) | np.int64(j))
    return least, alike


@nb.njit(**PART)
def thin_out(row, y):
    """Give up faces across which the means are alike, and others until there is room; not the cut at `y`."""
    while True:
        least, alike = _cheapest(row, y)
        if (alike == 0 and row[FACE + PARTS - 2] == CELLS) or least >= 0x7FF0000000000000:
            return
        k = int(least & 15)
        left, right = row[FACE + k] - row[FACE + k - 1], row[FACE + k + 1] - row[FACE + k]
        mean0 = (left * row[PART0 + k] + right * row[PART0 + k + 1]) / (left + right)
        mean1 = (left * row[PART1 + k] + right * row[PART1 + k + 1]) / (left + right)
        close_gap(row, FACE, k)
        close_gap(row, PART0, k)
        close_gap(row, PART1, k)
        row[PART0 + k], row[PART1 + k] = min(mean0, 1.0), min(mean1, 1.0)
        row[FACE + PARTS - 1] = CELLS
        row[PART0 + PARTS - 1] = row[PART1 + PARTS - 1] = 0.0
        if alike <= 1:  # what this has made alike can wait
            return


@nb.njit(**PART)
def hold_cut(row, bins, scratch):
    """Bring the zones to the cut, which slides may have moved; parts that it left behind are kept for its return."""
    zone = math.floor(row[ZONE])
    if row[ZONE] == zone:
        return
    row[ZONE] = zone
    y = cut_at(row[START], bins)
    enter_zone(row, math.floor(y), int(row[ZONE]) + CELLS // 2, bins, scratch)
    divide(row, y - row[ZONE], bins)
    thin_out(row, y - row[ZONE])
