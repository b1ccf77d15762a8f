r"""Chebyshev's polynomial smoother on blocks of three by three, compiled.

.. math:: p_{k+1} = s\,D^{-1}(b - A x_k) + t\,p_k, \qquad x_{k+1} = x_k + p_{k+1}

`D` holds the diagonal blocks. The matrix is in single precision, half the memory that a pass must read, which is what
it takes its time for; vectors and sums are double, so that what a cycle does is linear to round-off. Rows are written
each by itself: the answer does not depend on the number of threads.
"""

from __future__ import annotations

from typing import Any

import numba as nb

from myobridge.compiled import FASTMATH

__all__ = ["descend", "residual", "start"]

_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": FASTMATH,
}


@nb.njit(**_OPTIONS)
def _row(starts, columns, blocks, right, x, row):
    """``right - A x`` of one row of blocks."""
    r0, r1, r2 = right[3 * row], right[3 * row + 1], right[3 * row + 2]
    for j in range(starts[row], starts[row + 1]):
        at = 3 * columns[j]
        a, b, c = x[at], x[at + 1], x[at + 2]
        r0 -= blocks[j, 0, 0] * a + blocks[j, 0, 1] * b + blocks[j, 0, 2] * c
        r1 -= blocks[j, 1, 0] * a + blocks[j, 1, 1] * b + blocks[j, 1, 2] * c
        r2 -= blocks[j, 2, 0] * a + blocks[j, 2, 1] * b + blocks[j, 2, 2] * c
    return r0, r1, r2


@nb.njit(**_OPTIONS)
def residual(starts, columns, blocks, right, x, out, first, last):
    """``out = right - A x`` in the rows of blocks [first, last)."""
    for row in range(first, last):
        out[3 * row], out[3 * row + 1], out[3 * row + 2] = _row(starts, columns, blocks, right, x, row)


@nb.njit(**_OPTIONS)
def start(inverse, right, share, step, out, first, last):
    """First step from zero: ``step = out = share D^-1 right``."""
    for row in range(first, last):
        for i in range(3):
            value = 0.0
            for k in range(3):
                value += inverse[row, i, k] * right[3 * row + k]
            step[3 * row + i] = share * value
            out[3 * row + i] = share * value


@nb.njit(**_OPTIONS)
def descend(starts, columns, blocks, inverse, right, x, share, kept, step, out, first, last):
    """``step = share D^-1 (right - A x) + kept step; out = x + step`` in the rows of blocks [first, last)."""
    for row in range(first, last):
        a, b, c = _row(starts, columns, blocks, right, x, row)
        for i in range(3):
            at = 3 * row + i
            value = inverse[row, i, 0] * a + inverse[row, i, 1] * b + inverse[row, i, 2] * c
            value = share * value + kept * step[at]
            step[at] = value
            out[at] = x[at] + value
