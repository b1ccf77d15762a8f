r"""Tangent of the stress of a whole step at a point: derivative by the deformation gradient at its end, on lanes.

.. math:: \frac{\partial \bar P_{iJ}}{\partial F_{1,kL}} = \tfrac12 \delta_{ik} S_{JL}
          + F_{m,iI}\,M_{IJKL}\,F_{1,kK}, \qquad M = \frac{\partial S}{\partial E_1}

.. math:: M = \tfrac12 \sum_\pm t_\pm \mathbb{C}(C_\pm) + D \otimes \frac{S(C_1) - S_g - 2 \alpha D
          - D : \tfrac12 \sum_\pm t_\pm \mathbb{C}}{D : D} + \bigl(\alpha + \tfrac{\eta}{\Delta t}\bigr)\,1
          + p\,\frac{\partial G}{\partial E_1} + \frac{\partial S_{act}}{\partial E_1}

with :math:`t_\pm = \tfrac12 (1 \pm 1/\sqrt 3)` and the material's moduli pulled back from `U`,
:math:`\mathbb{C}_{IJKL} = U^{-1}_{Ii} U^{-1}_{Kk} (A_{iJkL} - \delta_{ik} S_{JL})`. `M` is not symmetric.

Pairs of indices stand in the order 00, 11, 22, 12, 02, 01; row ``6 a + b`` of `moduli` has M of the pairs a and b. Row
``9 (3 i + J) + 3 k + L`` of `whole` has the tangent. `kept` is that of `step_point_kernels`.
"""

from __future__ import annotations

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
    second_stress,
    square,
    store_symmetric,
    strain_change,
)
from myobridge_plugins.material.lane_tensors import cofactor, direction, gradient, store_stress, times

__all__ = ["add_correction_moduli", "add_moduli", "add_other_moduli", "gradients_of_volume", "whole_tangent"]

_L = LANES
# First place of dP[i, J] / dF[k, L] in what a material writes, by 3 i + J and 3 k + L.
_PLACE = np.array([[(9 + min(r, c) * (17 - min(r, c)) // 2 + max(r, c)) * _L for c in range(9)] for r in range(9)])
# Pair of the indices I and J.
_PAIR = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


@njit(**INNER)
def add_moduli(n, weight, state, out, half, moduli):
    """Add `weight` times the moduli of a material whose tangent at the upper triangular F of `state` is in `out`.

    `half` is scratch of 63 rows. The back substitution leaves out what follows by symmetry.
    """
    stress, over = half[54 * _L :], half[60 * _L :]
    for lane in range(n):
        u = gradient(state, lane)
        store_symmetric(stress, lane, second_stress(u, gradient(out, lane)))
        over[lane] = 1.0 / u[0]
        over[_L + lane] = 1.0 / u[4]
        over[2 * _L + lane] = 1.0 / u[8]
    for J in range(3):
        for K in range(J, 3):
            here = stress[_PAIR[J, K] * _L :]
            for i in range(3):
                entry = out[_PLACE[3 * i + J, 3 * i + K] :]
                for lane in range(n):
                    entry[lane] -= here[lane]
    for c in range(9):
        a00, a10, a20 = out[_PLACE[0, c] :], out[_PLACE[3, c] :], out[_PLACE[6, c] :]
        a11, a21, a22 = out[_PLACE[4, c] :], out[_PLACE[7, c] :], out[_PLACE[8, c] :]
        found = half[c * _L :]
        for lane in range(n):
            i0, i1, i2 = over[lane], over[_L + lane], over[2 * _L + lane]
            u01, u02, u12 = state[_L + lane], state[2 * _L + lane], state[5 * _L + lane]
            x20, x21 = i2 * a20[lane], i2 * a21[lane]
            x10 = i1 * (a10[lane] - u12 * x20)
            found[lane] = i0 * (a00[lane] - u01 * x10 - u02 * x20)
            found[9 * _L + lane] = i1 * (a11[lane] - u12 * x21)
            found[18 * _L + lane] = i2 * a22[lane]
            found[27 * _L + lane] = x21
            found[36 * _L + lane] = x20
            found[45 * _L + lane] = x10
    for pair in range(6):
        x, m = half[9 * pair * _L :], moduli[6 * pair * _L :]
        for lane in range(n):
            i0, i1, i2 = over[lane], over[_L + lane], over[2 * _L + lane]
            u01, u02, u12 = state[_L + lane], state[2 * _L + lane], state[5 * _L + lane]
            y20, y21 = i2 * x[6 * _L + lane], i2 * x[7 * _L + lane]
            y10 = i1 * (x[3 * _L + lane] - u12 * y20)
            m[lane] += weight * i0 * (x[lane] - u01 * y10 - u02 * y20)
            m[_L + lane] += weight * i1 * (x[4 * _L + lane] - u12 * y21)
            m[2 * _L + lane] += weight * i2 * x[8 * _L + lane]
            m[3 * _L + lane] += weight * y21
            m[4 * _L + lane] += weight * y20
            m[5 * _L + lane] += weight * y10


@njit(**INNER)
def add_correction_moduli(n, end, out, half, kept, moduli):
    """Add the derivative of the correction along D; `end` has F_1, and `out` the material's stress there.

    The moduli must be those of the material alone. `half` is scratch of 6 rows.
    """
    changes, passive = kept[9 * _L :], kept[21 * _L :]
    for lane in range(n):
        inverse = times(1.0 / kept[30 * _L + lane], cofactor(gradient(end, lane)))  # transposed
        stress = strain_change(inverse, gradient(out, lane))
        gap = combination(1.0, stress, -1.0, load_symmetric(passive, lane))
        store_symmetric(half, lane, combination(1.0, gap, -2.0 * kept[28 * _L + lane], load_symmetric(changes, lane)))
    for b in range(6):
        column, row = moduli[b * _L :], half[b * _L :]
        for lane in range(n):
            d = load_symmetric(changes, lane)
            row[lane] -= d[0] * column[lane] + d[1] * column[6 * _L + lane] + d[2] * column[12 * _L + lane]
            row[lane] -= 2.0 * (
                d[3] * column[18 * _L + lane] + d[4] * column[24 * _L + lane] + d[5] * column[30 * _L + lane]
            )
            row[lane] = row[lane] / kept[27 * _L + lane] if kept[28 * _L + lane] != 0.0 else 0.0
    for a in range(6):
        change, row = changes[a * _L :], moduli[6 * a * _L :]
        for lane in range(n):
            row[lane] += change[lane] * half[lane]
            row[_L + lane] += change[lane] * half[_L + lane]
            row[2 * _L + lane] += change[lane] * half[2 * _L + lane]
            row[3 * _L + lane] += change[lane] * half[3 * _L + lane]
            row[4 * _L + lane] += change[lane] * half[4 * _L + lane]
            row[5 * _L + lane] += change[lane] * half[5 * _L + lane]


@njit(**INNER)
def add_other_moduli(n, drag, start, end, half, kept, moduli):
    """Add what pressure, fibre, viscosity and the correction's own size give.

    `start` has p, T and dT / d lambda_1 in rows 12-14, `end` F_1; `half` is scratch of 24 rows.
    """
    changes, volumes, normals, slopes = kept[9 * _L :], kept[15 * _L :], half[6 * _L :], half[12 * _L :]
    bent = half[18 * _L :]
    for lane in range(n):
        f0, f1, change = gradient(start, lane), gradient(end, lane), load_symmetric(changes, lane)
        j0, j1 = kept[29 * _L + lane], kept[30 * _L + lane]
        l0, l1 = kept[31 * _L + lane], kept[32 * _L + lane]
        p, size = start[12 * _L + lane], kept[28 * _L + lane] + drag
        # Derivative of the cofactor, at C_m + D / 3 = C_0 + 4 D / 3.
        over = 2.0 * p / (j0 + j1)
        store_symmetric(bent, lane, combination(over, square(f0), 4.0 / 3.0 * over, change))
        store_symmetric(slopes, lane, combination(-p / (j1 * (j0 + j1)), cofactor_symmetric(square(f1)), 0.0, change))
        along = dyad(direction(start, lane))
        pull = 2.0 / (l0 + l1) * (start[14 * _L + lane] - start[13 * _L + lane] / (l0 + l1)) / l1
        store_symmetric(normals, lane, along)
        store_symmetric(half, lane, combination(pull, along, 0.0, change))
        h0, h1, h2, h3, h4, h5 = load_symmetric(bent, lane)
        moduli[0 * _L + lane] += size
        moduli[1 * _L + lane] += h2
        moduli[2 * _L + lane] += h1
        moduli[3 * _L + lane] -= h3
        moduli[6 * _L + lane] += h2
        moduli[7 * _L + lane] += size
        moduli[8 * _L + lane] += h0
        moduli[10 * _L + lane] -= h4
        moduli[12 * _L + lane] += h1
        moduli[13 * _L + lane] += h0
        moduli[14 * _L + lane] += size
        moduli[17 * _L + lane] -= h5
        moduli[18 * _L + lane] -= h3
        moduli[21 * _L + lane] += 0.5 * (size - h0)
        moduli[22 * _L + lane] += 0.5 * h5
        moduli[23 * _L + lane] += 0.5 * h4
        moduli[25 * _L + lane] -= h4
        moduli[27 * _L + lane] += 0.5 * h5
        moduli[28 * _L + lane] += 0.5 * (size - h1)
        moduli[29 * _L + lane] += 0.5 * h3
        moduli[32 * _L + lane] -= h5
        moduli[33 * _L + lane] += 0.5 * h4
        moduli[34 * _L + lane] += 0.5 * h3
        moduli[35 * _L + lane] += 0.5 * (size - h2)
    for a in range(6):
        pulled, normal, volume, row = half[a * _L :], normals, volumes[a * _L :], moduli[6 * a * _L :]
        for lane in range(n):
            x, y = pulled[lane], volume[lane]
            row[lane] += x * normal[lane] + y * slopes[lane]
            row[_L + lane] += x * normal[_L + lane] + y * slopes[_L + lane]
            row[2 * _L + lane] += x * normal[2 * _L + lane] + y * slopes[2 * _L + lane]
            row[3 * _L + lane] += x * normal[3 * _L + lane] + y * slopes[3 * _L + lane]
            row[4 * _L + lane] += x * normal[4 * _L + lane] + y * slopes[4 * _L + lane]
            row[5 * _L + lane] += x * normal[5 * _L + lane] + y * slopes[5 * _L + lane]


@njit(**INNER)
def whole_tangent(n, end, kept, moduli, half, whole):
    """The tangent in the 81 rows of `whole`; `half` is scratch of 54 rows."""
    stress = kept[33 * _L :]
    for i in range(3):
        f0, f1, f2 = kept[3 * i * _L :], kept[(3 * i + 1) * _L :], kept[(3 * i + 2) * _L :]
        for J in range(3):
            m0, m1, m2 = (
                moduli[6 * _PAIR[0, J] * _L :],
                moduli[6 * _PAIR[1, J] * _L :],
                moduli[6 * _PAIR[2, J] * _L :],
            )
            x = half[6 * (3 * i + J) * _L :]
            for b in range(6):
                r = b * _L
                for lane in range(n):
                    x[r + lane] = f0[lane] * m0[r + lane] + f1[lane] * m1[r + lane] + f2[lane] * m2[r + lane]
    for iJ in range(9):
        x = half[6 * iJ * _L :]
        for k in range(3):
            f0, f1, f2 = end[3 * k * _L :], end[(3 * k + 1) * _L :], end[(3 * k + 2) * _L :]
            found = whole[(9 * iJ + 3 * k) * _L :]
            for lane in range(n):
                a, b, c = f0[lane], f1[lane], f2[lane]
                x3, x4, x5 = x[3 * _L + lane], x[4 * _L + lane], x[5 * _L + lane]
                found[lane] = a * x[lane] + b * x5 + c * x4
                found[_L + lane] = a * x5 + b * x[_L + lane] + c * x3
                found[2 * _L + lane] = a * x4 + b * x3 + c * x[2 * _L + lane]
    for i in range(3):
        for J in range(3):
            for K in range(3):
                entry, s = whole[(9 * (3 * i + J) + 3 * i + K) * _L :], stress[_PAIR[J, K] * _L :]
                for lane in range(n):
                    entry[lane] += 0.5 * s[lane]


@njit(**INNER)
def gradients_of_volume(n, end, kept, found):
    """d J / d F at the end in rows 0-8, and the one that acts over the step, F_m G, in rows 9-17."""
    volumes, acting = kept[15 * _L :], found[9 * _L :]
    for lane in range(n):
        store_stress(found, lane, cofactor(gradient(end, lane)))
        store_stress(acting, lane, product_symmetric(gradient(kept, lane), load_symmetric(volumes, lane)))
