r"""Compiled Mooney-Rivlin law in all its forms, one source for them.

.. math:: W = c_{10}\,(s I_1 - 3) + c_{01}\,(s^2 I_2 - 3) - d \ln J, \qquad s = J^{-2 e / 3}

Constants: c10, c01 [Pa], d [Pa], and e, which is 1 in the isochoric form and 0 in the others.
"""

from __future__ import annotations

import math

from myobridge.compiled import LANES, material_function
from myobridge_plugins.material.lane_invariants import (
    isotropic_stress,
    isotropic_tangent,
    right_cauchy_green,
    second_invariant,
    trace,
)
from myobridge_plugins.material.lane_tensors import (
    cofactor,
    determinant,
    gradient,
    in_lane,
    keep,
    kept,
    store_stress,
    store_tangent,
)

__all__ = ["energy", "slopes", "store_scale", "stress", "tangent"]


@in_lane
def store_scale(n, state, out, e):
    """Leave s in row 0 of `out`: the power needs a call, which the vector loop after it must not contain."""
    if e == 0.0:
        for lane in range(n):
            keep(out, lane, 1.0)
    else:
        for lane in range(n):
            f = gradient(state, lane)
            keep(out, lane, determinant(f, cofactor(f)) ** (-2.0 / 3.0 * e))


@in_lane
def slopes(c, J, s, c10, c01, d, e):
    """W1, W2 and W3 at scale s, and what the isochoric form adds to its second derivatives."""
    w1, w2 = s * c10, s * s * c01
    g = -2.0 / 3.0 * e
    a, b = w1 * trace(c), w2 * second_invariant(c)
    w3 = (g * (a + 2.0 * b) - d) / J
    w33 = (g * (g - 1.0) * a + 2.0 * g * (2.0 * g - 1.0) * b + d) / (J * J)
    return w1, w2, w3, g * w1 / J, 2.0 * g * w2 / J, w33


@material_function
def energy(n, state, out, constants):
    """W in row 0."""
    c10, c01, d, e = constants[0], constants[1], constants[2], constants[3]
    n = min(n, LANES)
    store_scale(n, state, out, e)
    for lane in range(n):
        f = gradient(state, lane)
        c, J, s = right_cauchy_green(f), determinant(f, cofactor(f)), kept(out, lane)
        out[lane] = (
            c10 * (s * trace(c) - 3.0) + c01 * (s * s * second_invariant(c) - 3.0) - (d * math.log(J) if d else 0.0)
        )


@material_function
def stress(n, state, out, constants):
    """P."""
    c10, c01, d, e = constants[0], constants[1], constants[2], constants[3]
    n = min(n, LANES)  # tells the compiler that no index can overflow
    store_scale(n, state, out, e)
    for lane in range(n):
        f = gradient(state, lane)
        h, c = cofactor(f), right_cauchy_green(f)
        w1, w2, w3, _, _, _ = slopes(c, determinant(f, h), kept(out, lane), c10, c01, d, e)
        store_stress(out, lane, isotropic_stress(f, h, c, w1, w2, w3))


@material_function
def tangent(n, state, out, constants):
    """P and A."""
    c10, c01, d, e = constants[0], constants[1], constants[2], constants[3]
    n = min(n, LANES)
    store_scale(n, state, out, e)
    for lane in range(n):
        f = gradient(state, lane)
        h, c = cofactor(f), right_cauchy_green(f)
        w1, w2, w3, w13, w23, w33 = slopes(c, determinant(f, h), kept(out, lane), c10, c01, d, e)
        p = isotropic_stress(f, h, c, w1, w2, w3)
        store_tangent(out, lane, p, isotropic_tangent(f, h, c, w1, w2, w3, 0.0, w13, w23, w33))
