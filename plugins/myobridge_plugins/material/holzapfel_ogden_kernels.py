r"""Compiled law of Holzapfel and Ogden for one family of fibres.

Constants: a [Pa], b, a_f [Pa], b_f.
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
    keep_too,
    kept,
    kept_too,
    store_stress,
    store_tangent,
    times_vector,
)

__all__ = ["energy", "stress", "tangent"]


@in_lane
def _store_exponentials(n, state, out, a, b, af, bf):
    """Leave W1 and the fibres' modulus in rows 0 and 1: exp is a call, which a vector loop must not contain."""
    for lane in range(n):
        f = gradient(state, lane)
        m = times_vector(f, direction(state, lane))
        x = inner(m, m) - 1.0
        keep(out, lane, 0.5 * a * math.exp(b * (trace(right_cauchy_green(f)) - 3.0)))
        keep_too(out, lane, af * math.exp(bf * x * x) if x > 0.0 else 0.0)


@material_function
def energy(n, state, out, constants):
    """W in row 0."""
    a, b, af, bf = constants[0], constants[1], constants[2], constants[3]
    for lane in range(n):
        f = gradient(state, lane)
        m = times_vector(f, direction(state, lane))
        x = max(inner(m, m) - 1.0, 0.0)
        matrix = 0.5 * a / b * math.expm1(b * (trace(right_cauchy_green(f)) - 3.0))
        out[lane] = matrix - a * math.log(determinant(f, cofactor(f))) + 0.5 * af / bf * math.expm1(bf * x * x)


@material_function
def stress(n, state, out, constants):
    """P."""
    a, b, af, bf = constants[0], constants[1], constants[2], constants[3]
    n = min(n, LANES)  # tells the compiler that no index can overflow
    _store_exponentials(n, state, out, a, b, af, bf)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m = cofactor(f), right_cauchy_green(f), times_vector(f, fibre)
        w1, modulus = kept(out, lane), kept_too(out, lane)
        w4 = modulus * (inner(m, m) - 1.0)
        p = isotropic_stress(f, h, c, w1, 0.0, -a / determinant(f, h))
        store_stress(out, lane, both_stresses(p, fibre_stress(m, fibre, w4)))


@material_function
def tangent(n, state, out, constants):
    """P and A."""
    a, b, af, bf = constants[0], constants[1], constants[2], constants[3]
    n = min(n, LANES)
    _store_exponentials(n, state, out, a, b, af, bf)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m = cofactor(f), right_cauchy_green(f), times_vector(f, fibre)
        J, x = determinant(f, h), inner(m, m) - 1.0
        w1, modulus = kept(out, lane), kept_too(out, lane)
        w4, w44 = modulus * x, modulus * (1.0 + 2.0 * bf * x * x)
        p = both_stresses(isotropic_stress(f, h, c, w1, 0.0, -a / J), fibre_stress(m, fibre, w4))
        matrix = isotropic_tangent(f, h, c, w1, 0.0, -a / J, b * w1, 0.0, 0.0, a / (J * J))
        store_tangent(out, lane, p, both_tangents(matrix, fibre_tangent(m, fibre, w4, w44)))
