"""Loop over batches of elements that writes stretch, its rate and J at every point.

Its arguments are those of `assembly_kernels`.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit, types

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.element_kernels import (
    deformation,
    gather,
    shape_gradients,
    volume_and_inverse,
)
from myobridge_plugins.macro_solid.finite_element.kernel_types import CELLS, VECTOR
from myobridge_plugins.macro_solid.finite_element.lane_vectors import aligned
from myobridge_plugins.macro_solid.finite_element.point_kernels import OPTIONS

__all__ = ["kinematics"]

_L = LANES


@njit(
    types.void(types.intp, types.intp, types.intp, types.boolean, types.boolean, *CELLS, *(VECTOR,) * 5),
    **OPTIONS,
)
def kinematics(
    first: Any,
    last: Any,
    dimension: Any,
    affine: Any,
    with_rate: Any,
    sizes: Any,
    starts: Any,
    nodes: Any,
    corners: Any,
    fibre: Any,
    weights: Any,
    slopes: Any,
    map_slopes: Any,
    displacement: Any,
    velocity: Any,
    stretch: Any,
    rate: Any,
    jacobian: Any,
):
    """Fibre stretch [-], its rate [1/s] where `with_rate`, and J = det F [-] at the points of a range of batches."""
    n_nodes, n_q = nodes.shape[1], weights.shape[0]
    local, moving, gradients = aligned(3 * n_nodes), aligned(3 * n_nodes), aligned(3 * n_nodes)
    inverse, volume, state, change = aligned(9), aligned(1), aligned(9), aligned(9)
    change[:] = 0.0
    for batch in range(first, last):
        n = sizes[batch]
        gather(dimension, n_nodes, nodes[batch], displacement, local)
        if with_rate:
            gather(dimension, n_nodes, nodes[batch], velocity, moving)
        for q in range(n_q):
            if q == 0 or not affine:
                volume_and_inverse(dimension, map_slopes[q], corners[batch], inverse, volume)
            shape_gradients(n_nodes, slopes[q], inverse, gradients)
            deformation(1.0, n_nodes, local, gradients, state)
            if with_rate:
                deformation(0.0, n_nodes, moving, gradients, change)
            point = starts[batch] + q * n
            for lane in range(n):
                square, power = 0.0, 0.0
                for i in range(3):
                    m, r = 0.0, 0.0
                    for J in range(3):
                        m += state[(3 * i + J) * _L + lane] * fibre[J, point + lane]
                        r += change[(3 * i + J) * _L + lane] * fibre[J, point + lane]
                    square += m * m
                    power += m * r
                stretch[point + lane] = math.sqrt(square)
                if with_rate:
                    rate[point + lane] = power / stretch[point + lane]
                f = state[lane:]
                jacobian[point + lane] = (
                    f[0] * (f[4 * _L] * f[8 * _L] - f[5 * _L] * f[7 * _L])
                    + f[_L] * (f[5 * _L] * f[6 * _L] - f[3 * _L] * f[8 * _L])
                    + f[2 * _L] * (f[3 * _L] * f[7 * _L] - f[4 * _L] * f[6 * _L])
                )
