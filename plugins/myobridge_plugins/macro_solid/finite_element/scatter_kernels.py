r"""What the elements of one batch add to the rows of sparse matrices.

.. math:: K_{(ai)(bk)} \mathrel{+}= k_{aibk}, \qquad K_{(bk)(ai)} \mathrel{+}= k_{aibk}, \qquad
          B_{k(ai)} \mathrel{+}= b_{kai}

Rows of local numbers are those of `contraction_kernels`. Places in memory are unsigned: numba lets negative ones count
from the end, and asking every one for its sign costs a third of the time.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER, OPTIONS
from myobridge_plugins.macro_solid.finite_element.triples import add_three

__all__ = ["scatter_gradient", "scatter_stiffness", "scatter_whole_stiffness"]

_U = np.uint64
_ROW = tuple(_U(row * LANES) for row in range(9))
_ONE, _BLOCK = _U(1), _U(9 * LANES)


@njit(**INNER)
def scatter_stiffness(n, dimension, n_nodes, nodes, lengths, rows, places, local, data):
    """Add the blocks of all pairs a <= b, and their transposes, to the rows of the free numbers.

    Lanes are the outermost loop: the rows of a node stay in the cache for all its pairs.
    """
    for lane in range(n):
        at = _U(lane)
        for a in range(n_nodes):
            first = nodes[a, lane]
            length = lengths[first]
            for b in range(a, n_nodes):
                second = nodes[b, lane]
                across = lengths[second]
                here, there = places[a * n_nodes + b, lane], places[b * n_nodes + a, lane]
                if length > 0 and across > 0:
                    k00, k01 = local[at], local[at + _ROW[1]]
                    k10, k11 = local[at + _ROW[3]], local[at + _ROW[4]]
                    k02, k12 = local[at + _ROW[2]], local[at + _ROW[5]]
                    k20, k21, k22 = local[at + _ROW[6]], local[at + _ROW[7]], local[at + _ROW[8]]
                    start = _U(rows[dimension * first] + here)
                    _add(data, start, _U(length), dimension, k00, k01, k02, k10, k11, k12, k20, k21, k22)
                    if a != b:
                        start = _U(rows[dimension * second] + there)
                        _add(data, start, _U(across), dimension, k00, k10, k20, k01, k11, k21, k02, k12, k22)
                else:
                    _add_free(data, rows, dimension, first, second, here, local, at, _ROW[3], _ROW[1])
                    if a != b:
                        _add_free(data, rows, dimension, second, first, there, local, at, _ROW[1], _ROW[3])
                at = at + _BLOCK


@njit(**INNER)
def scatter_whole_stiffness(n, dimension, n_nodes, nodes, lengths, rows, places, local, data):
    """Add the blocks of all pairs, a and b in either order, where the stiffness is not symmetric."""
    for lane in range(n):
        at = _U(lane)
        for a in range(n_nodes):
            first = nodes[a, lane]
            length = lengths[first]
            for b in range(n_nodes):
                second = nodes[b, lane]
                here = places[a * n_nodes + b, lane]
                if length > 0 and lengths[second] > 0:
                    k00, k01 = local[at], local[at + _ROW[1]]
                    k10, k11 = local[at + _ROW[3]], local[at + _ROW[4]]
                    k02, k12 = local[at + _ROW[2]], local[at + _ROW[5]]
                    k20, k21, k22 = local[at + _ROW[6]], local[at + _ROW[7]], local[at + _ROW[8]]
                    start = _U(rows[dimension * first] + here)
                    _add(data, start, _U(length), dimension, k00, k01, k02, k10, k11, k12, k20, k21, k22)
                else:
                    _add_free(data, rows, dimension, first, second, here, local, at, _ROW[3], _ROW[1])
                at = at + _BLOCK


@njit(inline="always", **OPTIONS)
def _add(data, at, length, dimension, k00, k01, k02, k10, k11, k12, k20, k21, k22):
    """Add a block to `dimension` rows of the given length."""
    down = at + length
    if dimension == 3:
        add_three(data, at, k00, k01, k02)
        add_three(data, down, k10, k11, k12)
        add_three(data, down + length, k20, k21, k22)
    else:
        data[at] += k00
        data[at + _ONE] += k01
        data[down] += k10
        data[down + _ONE] += k11


@njit(**INNER)
def _add_free(data, rows, dimension, first, second, place, local, at, down, across):
    """Add those numbers of a block whose row and column are free."""
    for i in range(dimension):
        entry = rows[dimension * first + i]
        if entry >= 0:
            entry += place
            for k in range(dimension):
                if rows[dimension * second + k] >= 0:
                    data[entry] += local[at + _U(i) * down + _U(k) * across]
                    entry += 1


@njit(**INNER)
def scatter_gradient(
    n, dimension, n_nodes, n_multipliers, nodes, multipliers, lengths, rows, gradient_rows, places, local, data
):
    """Add the gradient of every free constraint to its row."""
    for lane in range(n):
        for k in range(n_multipliers):
            start = gradient_rows[multipliers[k, lane]]
            if start < 0:
                continue
            for a in range(n_nodes):
                pair = k * n_nodes + a
                at = _U(3 * pair * LANES + lane)
                here = _U(start + places[pair, lane])
                if dimension == 3 and lengths[nodes[a, lane]] > 0:
                    add_three(data, here, local[at], local[at + _ROW[1]], local[at + _ROW[2]])
                else:
                    for i in range(dimension):
                        if rows[dimension * nodes[a, lane] + i] >= 0:
                            data[here] += local[at + _U(i) * _ROW[1]]
                            here = here + _ONE
