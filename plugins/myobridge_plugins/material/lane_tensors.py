r"""Tensors of one lane: a 3 x 3 tensor is a tuple of 9, row by row; a vector is a tuple of 3.

All is straight-line code without branches, compiled into the body of the loop over the lanes that calls it, so that
the loop becomes vector instructions.
"""

from __future__ import annotations

import numba
import numpy as np

from myobridge.compiled import INLINED, LANES

__all__ = [
    "cofactor",
    "determinant",
    "direction",
    "gradient",
    "identity",
    "in_lane",
    "inner",
    "keep",
    "keep_too",
    "kept",
    "kept_too",
    "outer",
    "product",
    "store_stress",
    "store_tangent",
    "sum_of",
    "times",
    "times_vector",
    "transposed",
    "twist",
]

in_lane = numba.njit(**INLINED)


# First place of each row. Unsigned, because numba lets negative places count from the end, and asking for the sign of
# so many keeps the loop from becoming vector instructions.
_ROW = tuple(np.uint64(row * LANES) for row in range(54))


@in_lane
def gradient(state, lane):
    """Deformation gradient F of a lane."""
    at = np.uint64(lane)
    return (
        state[at],
        state[_ROW[1] + at],
        state[_ROW[2] + at],
        state[_ROW[3] + at],
        state[_ROW[4] + at],
        state[_ROW[5] + at],
        state[_ROW[6] + at],
        state[_ROW[7] + at],
        state[_ROW[8] + at],
    )


@in_lane
def direction(state, lane):
    """Fibre direction N of a lane."""
    at = np.uint64(lane)
    return state[_ROW[9] + at], state[_ROW[10] + at], state[_ROW[11] + at]


@in_lane
def keep(out, lane, value):
    """Leave a number in row 0 of `out` for a later loop."""
    out[np.uint64(lane)] = value


@in_lane
def kept(out, lane):
    """What an earlier loop left by `keep`."""
    return out[np.uint64(lane)]


@in_lane
def keep_too(out, lane, value):
    """Leave a second number, in row 1."""
    out[_ROW[1] + np.uint64(lane)] = value


@in_lane
def kept_too(out, lane):
    """What an earlier loop left by `keep_too`."""
    return out[_ROW[1] + np.uint64(lane)]


@in_lane
def cofactor(f):
    """J F^-T, the derivative of J."""
    return (
        f[4] * f[8] - f[5] * f[7],
        f[5] * f[6] - f[3] * f[8],
        f[3] * f[7] - f[4] * f[6],
        f[2] * f[7] - f[1] * f[8],
        f[0] * f[8] - f[2] * f[6],
        f[1] * f[6] - f[0] * f[7],
        f[1] * f[5] - f[2] * f[4],
        f[2] * f[3] - f[0] * f[5],
        f[0] * f[4] - f[1] * f[3],
    )


@in_lane
def determinant(f, h):
    """J, given the cofactor h."""
    return f[0] * h[0] + f[1] * h[1] + f[2] * h[2]


@in_lane
def inner(a, b):
    """Scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@in_lane
def outer(a, b):
    """a[J] b[L]."""
    return (
        a[0] * b[0],
        a[0] * b[1],
        a[0] * b[2],
        a[1] * b[0],
        a[1] * b[1],
        a[1] * b[2],
        a[2] * b[0],
        a[2] * b[1],
        a[2] * b[2],
    )


@in_lane
def sum_of(a, b):
    """a + b."""
    return (
        a[0] + b[0],
        a[1] + b[1],
        a[2] + b[2],
        a[3] + b[3],
        a[4] + b[4],
        a[5] + b[5],
        a[6] + b[6],
        a[7] + b[7],
        a[8] + b[8],
    )


@in_lane
def times(s, a):
    """s a."""
    return s * a[0], s * a[1], s * a[2], s * a[3], s * a[4], s * a[5], s * a[6], s * a[7], s * a[8]


@in_lane
def identity(s):
    """s I."""
    return s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s


@in_lane
def product(a, b):
    """Matrix product a b."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@in_lane
def transposed(a):
    """Transpose."""
    return a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]


@in_lane
def times_vector(a, v):
    """a v."""
    return inner(a[0:3], v), inner(a[3:6], v), inner(a[6:9], v)


@in_lane
def twist(v):
    """Alternating tensor times v: entry (J, L) is eps[J, L, M] v[M]."""
    return 0.0, v[2], -v[1], -v[2], 0.0, v[0], v[1], -v[0], 0.0


@in_lane
def store_stress(out, lane, p):
    """Write P."""
    at = np.uint64(lane)
    out[at] = p[0]
    out[_ROW[1] + at] = p[1]
    out[_ROW[2] + at] = p[2]
    out[_ROW[3] + at] = p[3]
    out[_ROW[4] + at] = p[4]
    out[_ROW[5] + at] = p[5]
    out[_ROW[6] + at] = p[6]
    out[_ROW[7] + at] = p[7]
    out[_ROW[8] + at] = p[8]


@in_lane
def store_tangent(out, lane, p, a):
    """Write P and the upper triangle of A."""
    store_stress(out, lane, p)
    at = np.uint64(lane)
    a00, a01, a02, a11, a12, a22 = a
    out[_ROW[9] + at] = a00[0]
    out[_ROW[10] + at] = a00[1]
    out[_ROW[11] + at] = a00[2]
    out[_ROW[12] + at] = a01[0]
    out[_ROW[13] + at] = a01[1]
    out[_ROW[14] + at] = a01[2]
    out[_ROW[15] + at] = a02[0]
    out[_ROW[16] + at] = a02[1]
    out[_ROW[17] + at] = a02[2]
    out[_ROW[18] + at] = a00[4]
    out[_ROW[19] + at] = a00[5]
    out[_ROW[20] + at] = a01[3]
    out[_ROW[21] + at] = a01[4]
    out[_ROW[22] + at] = a01[5]
    out[_ROW[23] + at] = a02[3]
    out[_ROW[24] + at] = a02[4]
    out[_ROW[25] + at] = a02[5]
    out[_ROW[26] + at] = a00[8]
    out[_ROW[27] + at] = a01[6]
    out[_ROW[28] + at] = a01[7]
    out[_ROW[29] + at] = a01[8]
    out[_ROW[30] + at] = a02[6]
    out[_ROW[31] + at] = a02[7]
    out[_ROW[32] + at] = a02[8]
    out[_ROW[33] + at] = a11[0]
    out[_ROW[34] + at] = a11[1]
    out[_ROW[35] + at] = a11[2]
    out[_ROW[36] + at] = a12[0]
    out[_ROW[37] + at] = a12[1]
    out[_ROW[38] + at] = a12[2]
    out[_ROW[39] + at] = a11[4]
    out[_ROW[40] + at] = a11[5]
    out[_ROW[41] + at] = a12[3]
    out[_ROW[42] + at] = a12[4]
    out[_ROW[43] + at] = a12[5]
    out[_ROW[44] + at] = a11[8]
    out[_ROW[45] + at] = a12[6]
    out[_ROW[46] + at] = a12[7]
    out[_ROW[47] + at] = a12[8]
    out[_ROW[48] + at] = a22[0]
    out[_ROW[49] + at] = a22[1]
    out[_ROW[50] + at] = a22[2]
    out[_ROW[51] + at] = a22[4]
    out[_ROW[52] + at] = a22[5]
    out[_ROW[53] + at] = a22[8]
