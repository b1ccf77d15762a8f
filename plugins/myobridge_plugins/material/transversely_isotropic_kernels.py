r"""Compiled Mooney-Rivlin law with stiffening fibres.

Constants: c10, c01 [Pa], d = 2 (c10 + 2 c01) [Pa], b [Pa] and the exponent of the fibres; b = 0 leaves them out.
"""

from __future__ import annotations

import math

from myobridge.compiled import LANES, material_function
from myobridge_plugins.material.lane_invariants import (
    both_stresses,
    both_tangents,
    fibre_stress,
    fibre_tangent,
    isotropic_stress,
    isotropic_tangent,
    right_cauchy_green,
    second_invariant,
    trace,
)
from myobridge_plugins.material.lane_tensors import (
    cofactor,
    determinant,
    direction,
    gradient,
    in_lane,
    inner,
    keep,
    kept,
    store_stress,
    store_tangent,
    times_vector,
)

__all__ = ["energy", "stress", "tangent"]


@in_lane
def _store_power(n, state, out, b, exponent):
    """Leave lambda^exponent in row 0 of `out`: the power needs a call, which a vector loop must not contain."""
    if b == 0.0:
        for lane in range(n):
            keep(out, lane, 1.0)
    else:
        for lane in range(n):
            m = times_vector(gradient(state, lane), direction(state, lane))
            keep(out, lane, max(inner(m, m), 1.0) ** (0.5 * exponent))


@in_lane
def _fibre_slopes(m, power, b, exponent):
    """W4 and W44; both zero at stretches below 1."""
    i4 = inner(m, m)
    s = 0.5 * b / i4 if i4 > 1.0 else 0.0
    return s * (power - 1.0), s * ((0.5 * exponent - 1.0) * power + 1.0) / i4


@material_function
def energy(n, state, out, constants):
    """W in row 0."""
    c10, c01, d, b, exponent = constants[0], constants[1], constants[2], constants[3], constants[4]
    for lane in range(n):
        f = gradient(state, lane)
        c, m = right_cauchy_green(f), times_vector(f, direction(state, lane))
        w = c10 * (trace(c) - 3.0) + c01 * (second_invariant(c) - 3.0) - d * math.log(determinant(f, cofactor(f)))
        i4 = inner(m, m)
        if b and i4 > 1.0:
            w += b / exponent * (i4 ** (0.5 * exponent) - 1.0) - 0.5 * b * math.log(i4)
        out[lane] = w


@material_function
def stress(n, state, out, constants):
    """P."""
    c10, c01, d, b, exponent = constants[0], constants[1], constants[2], constants[3], constants[4]
    n = min(n, LANES)  # tells the compiler that no index can overflow
    _store_power(n, state, out, b, exponent)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m = cofactor(f), right_cauchy_green(f), times_vector(f, fibre)
        w4, _ = _fibre_slopes(m, kept(out, lane), b, exponent)
        p = isotropic_stress(f, h, c, c10, c01, -d / determinant(f, h))
        store_stress(out, lane, both_stresses(p, fibre_stress(m, fibre, w4)))


@material_function
def tangent(n, state, out, constants):
    """P and A."""
    c10, c01, d, b, exponent = constants[0], constants[1], constants[2], constants[3], constants[4]
    n = min(n, LANES)
    _store_power(n, state, out, b, exponent)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m = cofactor(f), right_cauchy_green(f), times_vector(f, fibre)
        w4, w44 = _fibre_slopes(m, kept(out, lane), b, exponent)
        J = determinant(f, h)
        p = both_stresses(isotropic_stress(f, h, c, c10, c01, -d / J), fibre_stress(m, fibre, w4))
        a = isotropic_tangent(f, h, c, c10, c01, -d / J, 0.0, 0.0, 0.0, d / (J * J))
        store_tangent(out, lane, p, both_tangents(a, fibre_tangent(m, fibre, w4, w44)))
