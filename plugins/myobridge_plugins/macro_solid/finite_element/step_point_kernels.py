r"""Stress of a whole step at a point, the discrete gradient of everything that stores energy [1]_.

.. math:: \bar P = F_m S, \qquad F_m = \tfrac12 (F_0 + F_1), \qquad D = \tfrac12 (C_1 - C_0), \qquad
          \bar P : (F_1 - F_0) = S : D

.. math:: S = \tfrac12 \sum_{\pm} S_{mat}(C_\pm) + \alpha D + p\,G + \frac{2 T}{\lambda_0 + \lambda_1} N \otimes N
              + \frac{\eta}{\Delta t} D

* Material: two Gauss points on the straight way from C_0 to C_1, :math:`C_\pm = \tfrac12(C_0 + C_1) \pm D / \sqrt 3`.
  An objective law depends on `C` alone, so it is asked at the upper triangular `U` with :math:`U^T U = C`. What the
  rule leaves is put right along D [1]_: :math:`\alpha\,D : D = W(F_1) - W(F_0) - S : D`. What is below the round-off of
  W is left alone (so are all small D where the law is smooth: it leaves :math:`|D|^5 / 4320` of its modulus; one whose
  tangent jumps leaves :math:`|D|^2`), and beyond it alpha is only as sure as that round-off over :math:`|D|` is small.
* Pressure: :math:`G = 2\,(\mathrm{cof}\,C_m + \tfrac13 \mathrm{cof}\,D) / (J_0 + J_1)`, and :math:`G : D = J_1 - J_0`.
* Fibre: T at the mean stretch, and :math:`S : D = T (\lambda_1 - \lambda_0)`.

`S` is symmetric, which keeps the angular momentum.

Rows of `kept`, what a point keeps for its tangent: 0-8 F_m, 9-14 D, 15-20 G, 21-26 the material's S without alpha,
27 D : D, 28 alpha, 29 J_0, 30 J_1, 31 lambda_0, 32 lambda_1, 33-38 S, 39 the size of what cancels in alpha D.

References
----------
.. [1] O. Gonzalez, Comput. Methods Appl. Mech. Engrg. 190 (2000) 1763-1783.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER
from myobridge_plugins.macro_solid.finite_element.symmetric_lanes import (
    cofactor_symmetric,
    combination,
    dyad,
    load_symmetric,
    product_symmetric,
    scalar_product,
    second_stress,
    square,
    store_symmetric,
    strain_change,
    upper_factor,
)
from myobridge_plugins.material.lane_tensors import (
    cofactor,
    determinant,
    direction,
    gradient,
    store_stress,
    sum_of,
    times,
)

__all__ = ["KEPT", "correct", "mean_stress", "step_states", "step_stress"]

_L = LANES
_CHANGE, _VOLUME, _PASSIVE, _STRESS = 9 * _L, 15 * _L, 21 * _L, 33 * _L
# Rows of `kept`.
KEPT = 40
# D : D below which nothing is corrected, and what counts as round-off of W.
_TINY = 1e-10
_ROUND_OFF = 32.0 * float(np.finfo(float).eps)
_GAUSS = 1.0 / math.sqrt(3.0)


@njit(**INNER)
def step_states(n, start, end, first, second, kept):
    """F_1, and the material's states at both Gauss points.

    `start` has F_0 in rows 0-8 and N in 9-11, `end` the change of F, which becomes F_1.
    """
    changes, volumes = kept[_CHANGE:], kept[_VOLUME:]
    for lane in range(n):
        f0, d = gradient(start, lane), gradient(end, lane)
        fm = sum_of(f0, times(0.5, d))
        change, c0 = strain_change(fm, d), square(f0)
        store_stress(end, lane, sum_of(f0, d))
        store_stress(kept, lane, fm)
        store_symmetric(changes, lane, change)
        store_stress(first, lane, upper_factor(combination(1.0, c0, 1.0 - _GAUSS, change)))
        store_stress(second, lane, upper_factor(combination(1.0, c0, 1.0 + _GAUSS, change)))
    for lane in range(n):
        f0, f1, along = gradient(start, lane), gradient(end, lane), dyad(direction(start, lane))
        change, c0 = load_symmetric(changes, lane), square(f0)
        j0, j1 = determinant(f0, cofactor(f0)), determinant(f1, cofactor(f1))
        over, squared = 2.0 / (j0 + j1), scalar_product(along, c0)
        mean = cofactor_symmetric(combination(1.0, c0, 1.0, change))
        store_symmetric(volumes, lane, combination(over, mean, over / 3.0, cofactor_symmetric(change)))
        kept[27 * _L + lane] = scalar_product(change, change)
        kept[29 * _L + lane] = j0
        kept[30 * _L + lane] = j1
        kept[31 * _L + lane] = math.sqrt(squared)
        kept[32 * _L + lane] = math.sqrt(squared + 2.0 * scalar_product(along, change))


@njit(**INNER)
def mean_stress(n, first, second, first_stress, last_stress, kept):
    """The material's S, mean of both Gauss points; returns whether a change is large enough to ask for energies."""
    passive = kept[_PASSIVE:]
    largest = 0.0
    for lane in range(n):
        one = second_stress(gradient(first, lane), gradient(first_stress, lane))
        other = second_stress(gradient(second, lane), gradient(last_stress, lane))
        store_symmetric(passive, lane, combination(0.5, one, 0.5, other))
        kept[28 * _L + lane] = 0.0
        kept[39 * _L + lane] = 0.0
    for lane in range(n):
        largest = max(largest, kept[27 * _L + lane])
    return largest > _TINY


@njit(**INNER)
def correct(n, modulus, before, after, kept):
    """alpha, from the energies at both ends."""
    changes, passive = kept[_CHANGE:], kept[_PASSIVE:]
    for lane in range(n):
        size, scale = kept[27 * _L + lane], modulus + abs(before[lane])
        gap = after[lane] - before[lane] - scalar_product(load_symmetric(passive, lane), load_symmetric(changes, lane))
        sure = min(2.0 * max(abs(gap) - _ROUND_OFF * scale, 0.0), abs(gap))
        if size < _TINY:
            sure = 0.0
        kept[28 * _L + lane] = math.copysign(sure, gap) / size if sure > 0.0 else 0.0
        kept[39 * _L + lane] = scale / math.sqrt(size) if sure > 0.0 else 0.0


@njit(**INNER)
def step_stress(n, drag, start, kept, out):
    """The whole S in rows 33-38 of `kept`, and F_m S in rows 0-8 of `out`; p and T are rows 12 and 13 of `start`."""
    changes, volumes, passive, stresses = kept[_CHANGE:], kept[_VOLUME:], kept[_PASSIVE:], kept[_STRESS:]
    for lane in range(n):
        pull = 2.0 * start[13 * _L + lane] / (kept[31 * _L + lane] + kept[32 * _L + lane])
        change = load_symmetric(changes, lane)
        stress = combination(1.0, load_symmetric(passive, lane), kept[28 * _L + lane] + drag, change)
        stress = combination(1.0, stress, start[12 * _L + lane], load_symmetric(volumes, lane))
        stress = combination(1.0, stress, pull, dyad(direction(start, lane)))
        store_symmetric(stresses, lane, stress)
        store_stress(out, lane, product_symmetric(gradient(kept, lane), stress))
