r"""Compiled law of Guccione, as a function of the invariants.

.. math:: Q = b_t\,E : E + k_4\,E_{ff}^2 + k_5\,|E N|^2, \qquad
          k_4 = b_f + b_t - 2 b_{fs}, \qquad k_5 = 2 (b_{fs} - b_t)

with :math:`4 E : E = I_1^2 - 2 I_2 - 2 I_1 + 3`, :math:`2 E_{ff} = I_4 - 1`, :math:`4 |E N|^2 = I_5 - 2 I_4 + 1`. Since
W depends on Q alone, :math:`A = P \otimes P / k + k\,\partial^2 Q / \partial F^2` with :math:`k = C e^Q / 2`.

Constants: C [Pa], b_f, b_t, b_fs.
"""

from __future__ import annotations

import math

from myobridge.compiled import LANES, material_function
from myobridge_plugins.material.lane_invariants import (
    both_stresses,
    both_tangents,
    fibre_stress,
    fibre_tangent,
    fifth_stress,
    fifth_tangent,
    isotropic_stress,
    isotropic_tangent,
    product_tangent,
    right_cauchy_green,
    trace,
)
from myobridge_plugins.material.lane_tensors import (
    cofactor,
    direction,
    gradient,
    identity,
    in_lane,
    inner,
    keep,
    kept,
    store_stress,
    store_tangent,
    sum_of,
    times,
    times_vector,
)

__all__ = ["energy", "stress", "tangent"]


@in_lane
def _exponent(f, fibre, bf, bt, bfs):
    """Q, from the strain itself, which keeps its digits near rest."""
    e = times(0.5, sum_of(right_cauchy_green(f), identity(-1.0)))
    v = times_vector(e, fibre)
    axial = inner(v, fibre)
    square = inner(e[0:3], e[0:3]) + inner(e[3:6], e[3:6]) + inner(e[6:9], e[6:9])
    return bt * square + (bf + bt - 2.0 * bfs) * axial * axial + 2.0 * (bfs - bt) * inner(v, v)


@in_lane
def _store_modulus(n, state, out, constants):
    """Leave k in row 0 of `out`: exp is a call, which the vector loop after it must not contain."""
    for lane in range(n):
        q = _exponent(gradient(state, lane), direction(state, lane), constants[1], constants[2], constants[3])
        keep(out, lane, 0.5 * constants[0] * math.exp(q))


@in_lane
def _stress(f, h, c, m, fibre, k, k4, k5, bt):
    w4 = k * (0.5 * k4 * (inner(m, m) - 1.0) - 0.5 * k5)
    matrix = isotropic_stress(f, h, c, 0.5 * k * bt * (trace(c) - 1.0), -0.5 * k * bt, 0.0)
    return both_stresses(matrix, both_stresses(fibre_stress(m, fibre, w4), fifth_stress(f, m, fibre, 0.25 * k * k5)))


@material_function
def energy(n, state, out, constants):
    """W in row 0."""
    for lane in range(n):
        q = _exponent(gradient(state, lane), direction(state, lane), constants[1], constants[2], constants[3])
        out[lane] = 0.5 * constants[0] * math.expm1(q)


@material_function
def stress(n, state, out, constants):
    """P."""
    bf, bt, bfs = constants[1], constants[2], constants[3]
    n = min(n, LANES)  # tells the compiler that no index can overflow
    _store_modulus(n, state, out, constants)
    k4, k5 = bf + bt - 2.0 * bfs, 2.0 * (bfs - bt)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m = cofactor(f), right_cauchy_green(f), times_vector(f, fibre)
        store_stress(out, lane, _stress(f, h, c, m, fibre, kept(out, lane), k4, k5, bt))


@material_function
def tangent(n, state, out, constants):
    """P and A."""
    bf, bt, bfs = constants[1], constants[2], constants[3]
    n = min(n, LANES)
    _store_modulus(n, state, out, constants)
    k4, k5 = bf + bt - 2.0 * bfs, 2.0 * (bfs - bt)
    for lane in range(n):
        f, fibre = gradient(state, lane), direction(state, lane)
        h, c, m, k = cofactor(f), right_cauchy_green(f), times_vector(f, fibre), kept(out, lane)
        p = _stress(f, h, c, m, fibre, k, k4, k5, bt)
        w1, w2 = 0.5 * k * bt * (trace(c) - 1.0), -0.5 * k * bt
        w4, w5 = k * (0.5 * k4 * (inner(m, m) - 1.0) - 0.5 * k5), 0.25 * k * k5
        matrix = isotropic_tangent(f, h, c, w1, w2, 0.0, 0.5 * k * bt, 0.0, 0.0, 0.0)
        axial = both_tangents(fibre_tangent(m, fibre, w4, 0.5 * k * k4), fifth_tangent(f, m, fibre, w5))
        store_tangent(out, lane, p, both_tangents(product_tangent(p, 1.0 / k), both_tangents(matrix, axial)))
