r"""Contraction of stress and tangent with the gradients of the shape functions, on lanes.

.. math:: R_{ai} = \int P_{iJ} G_{aJ}, \qquad K_{aibk} = \int G_{aJ}\,A_{iJkL}\,G_{bL}, \qquad
          B_{kai} = \int \psi_k\,\mathrm{cof} F_{iJ}\,G_{aJ}

Rows of `LANES` numbers. Node `a` has its gradient in rows ``3 a + J``; the pair of nodes (a, b), a <= b, has its block
in rows ``9 pair + 3 i + k``. The first step of K, :math:`w\,G_{aJ} A_{iJkL}`, is kept in 27 rows for all `b`.
"""

from __future__ import annotations

from numba import njit

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER

__all__ = ["add_constraint", "add_force", "add_stiffness", "add_whole_stiffness"]

_L = LANES


@njit(**INNER)
def add_force(n, n_nodes, volume, slopes, stress, force):
    """Add ``P G`` of every node to rows ``3 a + i`` of `force`."""
    for a in range(n_nodes):
        g = slopes[3 * a * _L : (3 * a + 3) * _L]
        f = force[3 * a * _L : (3 * a + 3) * _L]
        for lane in range(n):
            x = volume[lane] * g[lane]
            y = volume[lane] * g[_L + lane]
            z = volume[lane] * g[2 * _L + lane]
            f[0 * _L + lane] += x * stress[0 * _L + lane] + y * stress[1 * _L + lane] + z * stress[2 * _L + lane]
            f[1 * _L + lane] += x * stress[3 * _L + lane] + y * stress[4 * _L + lane] + z * stress[5 * _L + lane]
            f[2 * _L + lane] += x * stress[6 * _L + lane] + y * stress[7 * _L + lane] + z * stress[8 * _L + lane]


@njit(**INNER)
def add_constraint(n, n_nodes, n_multipliers, volume, slopes, shapes, extra, half, gradient):
    """Add ``psi cof F G`` to rows ``3 (k n_nodes + a) + i`` of `gradient`; `half` is scratch of 3 rows."""
    for a in range(n_nodes):
        g = slopes[3 * a * _L : (3 * a + 3) * _L]
        for lane in range(n):
            x = volume[lane] * g[lane]
            y = volume[lane] * g[_L + lane]
            z = volume[lane] * g[2 * _L + lane]
            half[0 * _L + lane] = x * extra[0 * _L + lane] + y * extra[1 * _L + lane] + z * extra[2 * _L + lane]
            half[1 * _L + lane] = x * extra[3 * _L + lane] + y * extra[4 * _L + lane] + z * extra[5 * _L + lane]
            half[2 * _L + lane] = x * extra[6 * _L + lane] + y * extra[7 * _L + lane] + z * extra[8 * _L + lane]
        for k in range(n_multipliers):
            psi = shapes[k]
            row = 3 * (k * n_nodes + a) * _L
            b = gradient[row : row + 3 * _L]
            for lane in range(n):
                b[0 * _L + lane] += psi * half[0 * _L + lane]
                b[1 * _L + lane] += psi * half[1 * _L + lane]
                b[2 * _L + lane] += psi * half[2 * _L + lane]


@njit(**INNER)
def add_stiffness(n, n_nodes, volume, slopes, tangent, half, stiffness):
    """Add ``G A G`` of every pair of nodes a <= b to the blocks of `stiffness`; `half` is scratch of 27 rows."""
    pair = 0
    for a in range(n_nodes):
        g = slopes[3 * a * _L : (3 * a + 3) * _L]
        for lane in range(n):
            x = volume[lane] * g[lane]
            y = volume[lane] * g[_L + lane]
            z = volume[lane] * g[2 * _L + lane]
            half[0 * _L + lane] = x * tangent[9 * _L + lane] + y * tangent[10 * _L + lane] + z * tangent[11 * _L + lane]
            half[1 * _L + lane] = (
                x * tangent[10 * _L + lane] + y * tangent[18 * _L + lane] + z * tangent[19 * _L + lane]
            )
            half[2 * _L + lane] = (
                x * tangent[11 * _L + lane] + y * tangent[19 * _L + lane] + z * tangent[26 * _L + lane]
            )
            half[3 * _L + lane] = (
                x * tangent[12 * _L + lane] + y * tangent[20 * _L + lane] + z * tangent[27 * _L + lane]
            )
            half[4 * _L + lane] = (
                x * tangent[13 * _L + lane] + y * tangent[21 * _L + lane] + z * tangent[28 * _L + lane]
            )
            half[5 * _L + lane] = (
                x * tangent[14 * _L + lane] + y * tangent[22 * _L + lane] + z * tangent[29 * _L + lane]
            )
            half[6 * _L + lane] = (
                x * tangent[15 * _L + lane] + y * tangent[23 * _L + lane] + z * tangent[30 * _L + lane]
            )
            half[7 * _L + lane] = (
                x * tangent[16 * _L + lane] + y * tangent[24 * _L + lane] + z * tangent[31 * _L + lane]
            )
            half[8 * _L + lane] = (
                x * tangent[17 * _L + lane] + y * tangent[25 * _L + lane] + z * tangent[32 * _L + lane]
            )
            half[9 * _L + lane] = (
                x * tangent[12 * _L + lane] + y * tangent[13 * _L + lane] + z * tangent[14 * _L + lane]
            )
            half[10 * _L + lane] = (
                x * tangent[20 * _L + lane] + y * tangent[21 * _L + lane] + z * tangent[22 * _L + lane]
            )
            half[11 * _L + lane] = (
                x * tangent[27 * _L + lane] + y * tangent[28 * _L + lane] + z * tangent[29 * _L + lane]
            )
            half[12 * _L + lane] = (
                x * tangent[33 * _L + lane] + y * tangent[34 * _L + lane] + z * tangent[35 * _L + lane]
            )
            half[13 * _L + lane] = (
                x * tangent[34 * _L + lane] + y * tangent[39 * _L + lane] + z * tangent[40 * _L + lane]
            )
            half[14 * _L + lane] = (
                x * tangent[35 * _L + lane] + y * tangent[40 * _L + lane] + z * tangent[44 * _L + lane]
            )
            half[15 * _L + lane] = (
                x * tangent[36 * _L + lane] + y * tangent[41 * _L + lane] + z * tangent[45 * _L + lane]
            )
            half[16 * _L + lane] = (
                x * tangent[37 * _L + lane] + y * tangent[42 * _L + lane] + z * tangent[46 * _L + lane]
            )
            half[17 * _L + lane] = (
                x * tangent[38 * _L + lane] + y * tangent[43 * _L + lane] + z * tangent[47 * _L + lane]
            )
            half[18 * _L + lane] = (
                x * tangent[15 * _L + lane] + y * tangent[16 * _L + lane] + z * tangent[17 * _L + lane]
            )
            half[19 * _L + lane] = (
                x * tangent[23 * _L + lane] + y * tangent[24 * _L + lane] + z * tangent[25 * _L + lane]
            )
            half[20 * _L + lane] = (
                x * tangent[30 * _L + lane] + y * tangent[31 * _L + lane] + z * tangent[32 * _L + lane]
            )
            half[21 * _L + lane] = (
                x * tangent[36 * _L + lane] + y * tangent[37 * _L + lane] + z * tangent[38 * _L + lane]
            )
            half[22 * _L + lane] = (
                x * tangent[41 * _L + lane] + y * tangent[42 * _L + lane] + z * tangent[43 * _L + lane]
            )
            half[23 * _L + lane] = (
                x * tangent[45 * _L + lane] + y * tangent[46 * _L + lane] + z * tangent[47 * _L + lane]
            )
            half[24 * _L + lane] = (
                x * tangent[48 * _L + lane] + y * tangent[49 * _L + lane] + z * tangent[50 * _L + lane]
            )
            half[25 * _L + lane] = (
                x * tangent[49 * _L + lane] + y * tangent[51 * _L + lane] + z * tangent[52 * _L + lane]
            )
            half[26 * _L + lane] = (
                x * tangent[50 * _L + lane] + y * tangent[52 * _L + lane] + z * tangent[53 * _L + lane]
            )
        for b in range(a, n_nodes):
            h = slopes[3 * b * _L : (3 * b + 3) * _L]
            block = stiffness[9 * pair * _L : (9 * pair + 9) * _L]
            for lane in range(n):
                x = h[lane]
                y = h[_L + lane]
                z = h[2 * _L + lane]
                k00 = x * half[0 * _L + lane] + y * half[1 * _L + lane] + z * half[2 * _L + lane]
                k01 = x * half[3 * _L + lane] + y * half[4 * _L + lane] + z * half[5 * _L + lane]
                k02 = x * half[6 * _L + lane] + y * half[7 * _L + lane] + z * half[8 * _L + lane]
                k10 = x * half[9 * _L + lane] + y * half[10 * _L + lane] + z * half[11 * _L + lane]
                k11 = x * half[12 * _L + lane] + y * half[13 * _L + lane] + z * half[14 * _L + lane]
                k12 = x * half[15 * _L + lane] + y * half[16 * _L + lane] + z * half[17 * _L + lane]
                k20 = x * half[18 * _L + lane] + y * half[19 * _L + lane] + z * half[20 * _L + lane]
                k21 = x * half[21 * _L + lane] + y * half[22 * _L + lane] + z * half[23 * _L + lane]
                k22 = x * half[24 * _L + lane] + y * half[25 * _L + lane] + z * half[26 * _L + lane]
                block[0 * _L + lane] += k00
                block[1 * _L + lane] += k01
                block[2 * _L + lane] += k02
                block[3 * _L + lane] += k10
                block[4 * _L + lane] += k11
                block[5 * _L + lane] += k12
                block[6 * _L + lane] += k20
                block[7 * _L + lane] += k21
                block[8 * _L + lane] += k22
            pair += 1


@njit(**INNER)
def add_whole_stiffness(n, n_nodes, volume, slopes, whole, half, stiffness):
    """Add ``G A G`` of every pair of nodes where A has no symmetry: all 81 entries in, all pairs ``a n_nodes + b`` out.

    Row ``9 (3 i + J) + 3 k + L`` of `whole` has A; `half` is scratch of 27 rows.
    """
    for a in range(n_nodes):
        g = slopes[3 * a * _L : (3 * a + 3) * _L]
        for i in range(3):
            for c in range(9):
                row = (27 * i + c) * _L
                first, second, third = whole[row : row + _L], whole[row + 9 * _L :], whole[row + 18 * _L :]
                found = half[(9 * i + c) * _L : (9 * i + c + 1) * _L]
                for lane in range(n):
                    sum_ = g[lane] * first[lane] + g[_L + lane] * second[lane] + g[2 * _L + lane] * third[lane]
                    found[lane] = volume[lane] * sum_
        for b in range(n_nodes):
            h = slopes[3 * b * _L : (3 * b + 3) * _L]
            pair = a * n_nodes + b
            for i in range(3):
                block = stiffness[(9 * pair + 3 * i) * _L : (9 * pair + 3 * i + 3) * _L]
                rows = half[9 * i * _L : (9 * i + 9) * _L]
                for lane in range(n):
                    x = h[lane]
                    y = h[_L + lane]
                    z = h[2 * _L + lane]
                    k0 = x * rows[0 * _L + lane] + y * rows[1 * _L + lane] + z * rows[2 * _L + lane]
                    k1 = x * rows[3 * _L + lane] + y * rows[4 * _L + lane] + z * rows[5 * _L + lane]
                    k2 = x * rows[6 * _L + lane] + y * rows[7 * _L + lane] + z * rows[8 * _L + lane]
                    block[0 * _L + lane] += k0
                    block[1 * _L + lane] += k1
                    block[2 * _L + lane] += k2
