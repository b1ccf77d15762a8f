r"""What the solid adds to the material at a point: pressure of the constraint and tension of the fibres.

.. math:: P \mathrel{+}= p\,\mathrm{cof} F + \frac{T}{\lambda}\,m \otimes N, \qquad m = F N, \quad \lambda = |m|

.. math:: A \mathrel{+}= p\,\frac{\partial\,\mathrm{cof} F}{\partial F}
          + \frac{T}{\lambda}\,1 \otimes N \otimes N
          + \frac{K - T/\lambda}{\lambda^2}\,(m \otimes N) \otimes (m \otimes N)

`state` is that of a material, rows 0-8 F and 9-11 N, with p, T and K in rows 12-14.

Straight-line code on lanes: rows of `LANES` numbers, ``row * LANES + lane``.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from myobridge.compiled import FASTMATH
from myobridge_plugins.macro_solid.finite_element.lane_vectors import (
    absolute,
    add_to,
    larger,
    load,
    square_root,
    store,
)

__all__ = ["INNER", "OPTIONS", "add_stress", "add_tangent", "raise_peak"]

OPTIONS: Any = {
    "error_model": "numpy",
    "fastmath": FASTMATH,
    "cache": True,
    "nogil": True,
}
# Of what only kernels call: without the entry for Python, which takes a sixth of the time of compiling.
INNER: Any = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@njit(**INNER)
def add_stress(state, extra, out):
    """Add both stresses to rows 0-8 of `out`; `extra` gets the cofactor (rows 0-8), J, m (10-12) and the stretch."""
    f00 = load(state, 0)
    f01 = load(state, 1)
    f02 = load(state, 2)
    f10 = load(state, 3)
    f11 = load(state, 4)
    f12 = load(state, 5)
    f20 = load(state, 6)
    f21 = load(state, 7)
    f22 = load(state, 8)
    n0 = load(state, 9)
    n1 = load(state, 10)
    n2 = load(state, 11)
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
    stretch = square_root(m0 * m0 + m1 * m1 + m2 * m2)
    p = load(state, 12)
    fibre = load(state, 13) / stretch
    store(extra, 0, c00)
    store(extra, 1, c01)
    store(extra, 2, c02)
    store(extra, 3, c10)
    store(extra, 4, c11)
    store(extra, 5, c12)
    store(extra, 6, c20)
    store(extra, 7, c21)
    store(extra, 8, c22)
    store(extra, 9, f00 * c00 + f01 * c01 + f02 * c02)
    store(extra, 10, m0)
    store(extra, 11, m1)
    store(extra, 12, m2)
    store(extra, 13, stretch)
    add_to(out, 0, p * c00 + fibre * m0 * n0)
    add_to(out, 1, p * c01 + fibre * m0 * n1)
    add_to(out, 2, p * c02 + fibre * m0 * n2)
    add_to(out, 3, p * c10 + fibre * m1 * n0)
    add_to(out, 4, p * c11 + fibre * m1 * n1)
    add_to(out, 5, p * c12 + fibre * m1 * n2)
    add_to(out, 6, p * c20 + fibre * m2 * n0)
    add_to(out, 7, p * c21 + fibre * m2 * n1)
    add_to(out, 8, p * c22 + fibre * m2 * n2)


@njit(**INNER)
def add_tangent(state, extra, out):
    """Add both tangents to rows 9-53 of `out`, the upper triangle; `extra` is what `add_stress` left there."""
    f00 = load(state, 0)
    f01 = load(state, 1)
    f02 = load(state, 2)
    f10 = load(state, 3)
    f11 = load(state, 4)
    f12 = load(state, 5)
    f20 = load(state, 6)
    f21 = load(state, 7)
    f22 = load(state, 8)
    p = load(state, 12)
    stretch = load(extra, 13)
    fibre = load(state, 13) / stretch
    slope = (load(state, 14) - fibre) / (stretch * stretch)
    n0 = load(state, 9)
    n1 = load(state, 10)
    n2 = load(state, 11)
    b0 = load(extra, 10) * n0
    b1 = load(extra, 10) * n1
    b2 = load(extra, 10) * n2
    b3 = load(extra, 11) * n0
    b4 = load(extra, 11) * n1
    b5 = load(extra, 11) * n2
    b6 = load(extra, 12) * n0
    b7 = load(extra, 12) * n1
    b8 = load(extra, 12) * n2
    d00 = fibre * n0 * n0
    d01 = fibre * n0 * n1
    d02 = fibre * n0 * n2
    d11 = fibre * n1 * n1
    d12 = fibre * n1 * n2
    d22 = fibre * n2 * n2
    add_to(out, 9, slope * b0 * b0 + d00)
    add_to(out, 10, slope * b0 * b1 + d01)
    add_to(out, 11, slope * b0 * b2 + d02)
    add_to(out, 12, slope * b0 * b3)
    add_to(out, 13, slope * b0 * b4 + p * f22)
    add_to(out, 14, slope * b0 * b5 - p * f21)
    add_to(out, 15, slope * b0 * b6)
    add_to(out, 16, slope * b0 * b7 - p * f12)
    add_to(out, 17, slope * b0 * b8 + p * f11)
    add_to(out, 18, slope * b1 * b1 + d11)
    add_to(out, 19, slope * b1 * b2 + d12)
    add_to(out, 20, slope * b1 * b3 - p * f22)
    add_to(out, 21, slope * b1 * b4)
    add_to(out, 22, slope * b1 * b5 + p * f20)
    add_to(out, 23, slope * b1 * b6 + p * f12)
    add_to(out, 24, slope * b1 * b7)
    add_to(out, 25, slope * b1 * b8 - p * f10)
    add_to(out, 26, slope * b2 * b2 + d22)
    add_to(out, 27, slope * b2 * b3 + p * f21)
    add_to(out, 28, slope * b2 * b4 - p * f20)
    add_to(out, 29, slope * b2 * b5)
    add_to(out, 30, slope * b2 * b6 - p * f11)
    add_to(out, 31, slope * b2 * b7 + p * f10)
    add_to(out, 32, slope * b2 * b8)
    add_to(out, 33, slope * b3 * b3 + d00)
    add_to(out, 34, slope * b3 * b4 + d01)
    add_to(out, 35, slope * b3 * b5 + d02)
    add_to(out, 36, slope * b3 * b6)
    add_to(out, 37, slope * b3 * b7 + p * f02)
    add_to(out, 38, slope * b3 * b8 - p * f01)
    add_to(out, 39, slope * b4 * b4 + d11)
    add_to(out, 40, slope * b4 * b5 + d12)
    add_to(out, 41, slope * b4 * b6 - p * f02)
    add_to(out, 42, slope * b4 * b7)
    add_to(out, 43, slope * b4 * b8 + p * f00)
    add_to(out, 44, slope * b5 * b5 + d22)
    add_to(out, 45, slope * b5 * b6 + p * f01)
    add_to(out, 46, slope * b5 * b7 - p * f00)
    add_to(out, 47, slope * b5 * b8)
    add_to(out, 48, slope * b6 * b6 + d00)
    add_to(out, 49, slope * b6 * b7 + d01)
    add_to(out, 50, slope * b6 * b8 + d02)
    add_to(out, 51, slope * b7 * b7 + d11)
    add_to(out, 52, slope * b7 * b8 + d12)
    add_to(out, 53, slope * b8 * b8 + d22)


@njit(**INNER)
def raise_peak(stress, peak):
    """Raise the row `peak` to the largest entry of rows 0-8."""
    top = load(peak, 0)
    for row in range(9):
        top = larger(absolute(load(stress, row)), top)
    store(peak, 0, top)
