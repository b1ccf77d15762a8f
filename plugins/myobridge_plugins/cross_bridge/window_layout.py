r"""Layout of a state row of the exact scheme: a window of cells that rides with the filament, and a header before it.

Cell `i` spans :math:`q \in s + [i, i+1]\,\Delta q` and stores the mean of :math:`\rho` in it; :math:`s` moves with
the filament, so a slide is one addition. The positions q=0 and q=1, where the rates jump, cut one cell each, at the
same fraction of its width (a reach is a whole number of cells). Around each cut lies a *zone* of a few cells that are
divided further: at the cut, and at faces that the cut left behind where it turned or stopped. Both zones have the same
faces. Those across which the means differ least are given up when there are too many.

Moments count a cell at its centre, divided or not, :math:`Q_k = \sum \bar\rho\,\Delta q\,(1, m, m^2)`: then a slide
shifts them exactly, :math:`Q_1 + x Q_0`, :math:`Q_2 + 2 x Q_1 + x^2 Q_0`.
"""

from __future__ import annotations

import numba as nb
import numpy as np

from myobridge.cache_lines import LINE, rows_on_lines
from myobridge.compiled import FASTMATH
from myobridge.interfaces import Array

# Columns of a state row before its cells. What a slide changes is in the first cache line.
START, Q0, Q1, Q2 = 0, 1, 2, 3  # q of the left face of cell 0; moments
FIRST, LAST = 4, 5  # cells that may hold heads: FIRST <= i < LAST; all others are zero
# First cell of the zone at q=0 (that at q=1 begins a reach later). A slide leaves the zones behind and says so by half
# a cell more; the next step catches up.
ZONE = 6
LEFT = 7  # 0, the left face of a zone's first part
FACE = LEFT + 1  # right faces of the parts, in cells from the zone's beginning; CELLS in places that are not used
LANES = 16  # numbers of a vector, see `row_vectors`
PARTS = LANES  # most parts of a zone: vectors take all places, used or not
PART0 = FACE + PARTS  # means of the parts of the zone at q=0
PART1 = PART0 + PARTS  # and at q=1
HEADER = PART1 + PARTS  # seven cache lines
CELLS = 6  # cells of a zone
BLOCK = 16  # cells by which the window moves at a time

# Compiled kernels are cached beside their file. The cache does not see edits of other files: whoever edits a kernel
# that another file imports, or these numbers, deletes `__pycache__/*.nb?` here. (An installation renews all files.)
# They hold no lock, so that sites can be shared out among threads.
FAST = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": FASTMATH}
# No counts of references: every view of an array would cost two atomic operations, a third of the time of a step. Such
# kernels cannot allocate arrays.
BARE_ENTRY = {**FAST, "_nrt": False}
# Of what only kernels call: without the entry for Python, which takes a sixth of the time of compiling.
BARE = {**BARE_ENTRY, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# Of what is called once a site: as part of its caller, as every array takes seven arguments.
PART = {**BARE, "forceinline": True}


def cells_of(low: float, high: float, bins: int) -> int:
    """Cells of a window from `low` to `high` with room to move; rows are whole cache lines."""
    wanted = round((high - low) * bins) + BLOCK
    return wanted + (-wanted) % LINE


def empty_window(n_sites: int, n_cells: int, low: float, bins: int) -> Array:
    """State without heads whose window begins at or just below `low`, shape (n_sites, HEADER + n_cells)."""
    state = rows_on_lines((n_sites, HEADER + n_cells))
    state[...] = 0.0
    origin = round(-low * bins)
    state[:, START] = -origin / bins
    state[:, FIRST], state[:, LAST] = origin, origin + bins + 1
    state[:, ZONE] = origin - CELLS // 2
    state[:, FACE:PART0] = np.minimum(np.arange(PARTS) + 1, CELLS)
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
def count_parts(row):
    """Parts of a zone."""
    n = 1.0  # counted in floating point: then the loop is one of vectors
    for k in range(PARTS):
        n += 1.0 if row[FACE + k] < CELLS else 0.0
    return int(n)
