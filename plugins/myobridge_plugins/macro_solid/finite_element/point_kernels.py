r"""What the solid adds to the material at a point: pressure of the constraint and tension of the fibres.

.. math:: P \mathrel{+}= p\,\mathrm{cof} F + \frac{T}{\lambda}\,m \otimes N, \qquad m = F N, \quad \lambda = |m|

.. math:: A \mathrel{+}= p\,\frac{\partial\,\mathrm{cof} F}{\partial F}
          + \frac{T}{\lambda}\,1 \otimes N \otimes N
          + \frac{K - T/\lambda}{\lambda^2}\,(m \otimes N) \otimes (m \otimes N)

`state` is that of a material, rows 0-8 F and 9-11 N, with p, T and K in rows 12-14.

Straight-line code on lanes: rows of `LANES` numbers, ``row * LANES + lane``. Loops over the indices would be shorter,
and slower: only a loop whose body has no loop becomes vector instructions.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from myobridge.compiled import LANES

__all__ = ["INNER", "OPTIONS", "add_stress", "add_tangent"]

# Sums may be reordered and contracted, so that lanes become vectors; infinities and NaN keep their meaning.
OPTIONS: Any = {
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "arcp", "nsz"},
    "cache": True,
    "nogil": True,
}
# Of what only kernels call: without the entry for Python, which takes a sixth of the time of compiling.
INNER: Any = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

_L = LANES


@njit(**INNER)
def add_stress(n, state, extra, out):
    """Add both stresses to rows 0-8 of `out`; `extra` gets the cofactor (rows 0-8), J, m (10-12) and the stretch."""
    for lane in range(n):
        f00 = state[0 * _L + lane]
        f01 = state[1 * _L + lane]
        f02 = state[2 * _L + lane]
        f10 = state[3 * _L + lane]
        f11 = state[4 * _L + lane]
        f12 = state[5 * _L + lane]
        f20 = state[6 * _L + lane]
        f21 = state[7 * _L + lane]
        f22 = state[8 * _L + lane]
        n0 = state[9 * _L + lane]
        n1 = state[10 * _L + lane]
        n2 = state[11 * _L + lane]
        c00 = f11 * f22 - f12 * f21
        c01 = f12 * f20 - f10 * f22
        c02 = f10 * f21 - f11 * f20
        c10 = f21 * f02 - f22 * f01
        c11 = f22 * f00 - f20 * f02
        c12 = f20 * f01 - f21 * f00
        c20 = f01 * f12 - f02 * f11
        c21 = f02 * f10 - f00 * f12
        c22 = f00 * f11 - f01 * f10
        m0 = f00 * n0 + f01 * n1 + f02 * n2
        m1 = f10 * n0 + f11 * n1 + f12 * n2
        m2 = f20 * n0 + f21 * n1 + f22 * n2
        stretch = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
        p = state[12 * _L + lane]
        fibre = state[13 * _L + lane] / stretch
        extra[0 * _L + lane] = c00
        extra[1 * _L + lane] = c01
        extra[2 * _L + lane] = c02
        extra[3 * _L + lane] = c10
        extra[4 * _L + lane] = c11
        extra[5 * _L + lane] = c12
        extra[6 * _L + lane] = c20
        extra[7 * _L + lane] = c21
        extra[8 * _L + lane] = c22
        extra[9 * _L + lane] = f00 * c00 + f01 * c01 + f02 * c02
        extra[10 * _L + lane] = m0
        extra[11 * _L + lane] = m1
        extra[12 * _L + lane] = m2
        extra[13 * _L + lane] = stretch
        out[0 * _L + lane] += p * c00 + fibre * m0 * n0
        out[1 * _L + lane] += p * c01 + fibre * m0 * n1
        out[2 * _L + lane] += p * c02 + fibre * m0 * n2
        out[3 * _L + lane] += p * c10 + fibre * m1 * n0
        out[4 * _L + lane] += p * c11 + fibre * m1 * n1
        out[5 * _L + lane] += p * c12 + fibre * m1 * n2
        out[6 * _L + lane] += p * c20 + fibre * m2 * n0
        out[7 * _L + lane] += p * c21 + fibre * m2 * n1
        out[8 * _L + lane] += p * c22 + fibre * m2 * n2


@njit(**INNER)
def add_tangent(n, state, extra, out):
    """Add both tangents to rows 9-53 of `out`, the upper triangle; `extra` is what `add_stress` left there."""
    for lane in range(n):
        f00 = state[0 * _L + lane]
        f01 = state[1 * _L + lane]
        f02 = state[2 * _L + lane]
        f10 = state[3 * _L + lane]
        f11 = state[4 * _L + lane]
        f12 = state[5 * _L + lane]
        f20 = state[6 * _L + lane]
        f21 = state[7 * _L + lane]
        f22 = state[8 * _L + lane]
        p = state[12 * _L + lane]
        stretch = extra[13 * _L + lane]
        fibre = state[13 * _L + lane] / stretch
        slope = (state[14 * _L + lane] - fibre) / (stretch * stretch)
        n0 = state[9 * _L + lane]
        n1 = state[10 * _L + lane]
        n2 = state[11 * _L + lane]
        b0 = extra[10 * _L + lane] * n0
        b1 = extra[10 * _L + lane] * n1
        b2 = extra[10 * _L + lane] * n2
        b3 = extra[11 * _L + lane] * n0
        b4 = extra[11 * _L + lane] * n1
        b5 = extra[11 * _L + lane] * n2
        b6 = extra[12 * _L + lane] * n0
        b7 = extra[12 * _L + lane] * n1
        b8 = extra[12 * _L + lane] * n2
        d00 = fibre * n0 * n0
        d01 = fibre * n0 * n1
        d02 = fibre * n0 * n2
        d11 = fibre * n1 * n1
        d12 = fibre * n1 * n2
        d22 = fibre * n2 * n2
        out[9 * _L + lane] += slope * b0 * b0 + d00
        out[10 * _L + lane] += slope * b0 * b1 + d01
        out[11 * _L + lane] += slope * b0 * b2 + d02
        out[12 * _L + lane] += slope * b0 * b3
        out[13 * _L + lane] += slope * b0 * b4 + p * f22
        out[14 * _L + lane] += slope * b0 * b5 - p * f21
        out[15 * _L + lane] += slope * b0 * b6
        out[16 * _L + lane] += slope * b0 * b7 - p * f12
        out[17 * _L + lane] += slope * b0 * b8 + p * f11
        out[18 * _L + lane] += slope * b1 * b1 + d11
        out[19 * _L + lane] += slope * b1 * b2 + d12
        out[20 * _L + lane] += slope * b1 * b3 - p * f22
        out[21 * _L + lane] += slope * b1 * b4
        out[22 * _L + lane] += slope * b1 * b5 + p * f20
        out[23 * _L + lane] += slope * b1 * b6 + p * f12
        out[24 * _L + lane] += slope * b1 * b7
        out[25 * _L + lane] += slope * b1 * b8 - p * f10
        out[26 * _L + lane] += slope * b2 * b2 + d22
        out[27 * _L + lane] += slope * b2 * b3 + p * f21
        out[28 * _L + lane] += slope * b2 * b4 - p * f20
        out[29 * _L + lane] += slope * b2 * b5
        out[30 * _L + lane] += slope * b2 * b6 - p * f11
        out[31 * _L + lane] += slope * b2 * b7 + p * f10
        out[32 * _L + lane] += slope * b2 * b8
        out[33 * _L + lane] += slope * b3 * b3 + d00
        out[34 * _L + lane] += slope * b3 * b4 + d01
        out[35 * _L + lane] += slope * b3 * b5 + d02
        out[36 * _L + lane] += slope * b3 * b6
        out[37 * _L + lane] += slope * b3 * b7 + p * f02
        out[38 * _L + lane] += slope * b3 * b8 - p * f01
        out[39 * _L + lane] += slope * b4 * b4 + d11
        out[40 * _L + lane] += slope * b4 * b5 + d12
        out[41 * _L + lane] += slope * b4 * b6 - p * f02
        out[42 * _L + lane] += slope * b4 * b7
        out[43 * _L + lane] += slope * b4 * b8 + p * f00
        out[44 * _L + lane] += slope * b5 * b5 + d22
        out[45 * _L + lane] += slope * b5 * b6 + p * f01
        out[46 * _L + lane] += slope * b5 * b7 - p * f00
        out[47 * _L + lane] += slope * b5 * b8
        out[48 * _L + lane] += slope * b6 * b6 + d00
        out[49 * _L + lane] += slope * b6 * b7 + d01
        out[50 * _L + lane] += slope * b6 * b8 + d02
        out[51 * _L + lane] += slope * b7 * b7 + d11
        out[52 * _L + lane] += slope * b7 * b8 + d12
        out[53 * _L + lane] += slope * b8 * b8 + d22
