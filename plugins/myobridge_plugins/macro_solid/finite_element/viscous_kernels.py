r"""Loop over batches of elements that adds the viscous stress and its derivatives (Kelvin and Voigt).

.. math:: S = \eta\,\dot E, \qquad \dot E = \mathrm{sym}(F^T \dot F), \qquad P = F S

.. math:: \frac{\partial P_{iJ}}{\partial \dot F_{kL}}
          = \frac{\eta}{2} \bigl((F F^T)_{ik} \delta_{JL} + F_{iL} F_{kJ}\bigr), \qquad
          \frac{\partial P_{iJ}}{\partial F_{kL}}\Big|_{\dot E} = \delta_{ik} S_{JL}

Both are symmetric. The rest of the second one, by which the rate of strain changes at a given velocity, is not.

Its arguments are those of `assembly_kernels`. A module of its own: a body without viscosity does not compile it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.contraction_kernels import add_force, add_stiffness
from myobridge_plugins.macro_solid.finite_element.element_kernels import (
    deformation,
    gather,
    shape_gradients,
    volume_and_inverse,
)
from myobridge_plugins.macro_solid.finite_element.kernel_types import CELLS, INDEX, PLACES, TABLE, VECTOR
from myobridge_plugins.macro_solid.finite_element.lane_vectors import aligned, load, store
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER, OPTIONS, raise_peak
from myobridge_plugins.macro_solid.finite_element.scatter_kernels import scatter_stiffness
from myobridge_plugins.macro_solid.finite_element.symmetric_lanes import (
    combination,
    product_symmetric,
    store_symmetric,
    strain_change,
)
from myobridge_plugins.material.lane_tensors import gradient, store_stress

__all__ = ["add_viscous"]

_L = LANES
# Pair of the indices J and L in a symmetric tensor.
_PAIR = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


@njit(**INNER)
def _stress(n, viscosity, state, moving, stress, out):
    """S, and P in rows 0-8 of `out`."""
    for lane in range(n):
        f, rate = gradient(state, lane), gradient(moving, lane)
        change = strain_change(f, rate)
        s = combination(viscosity, change, 0.0, change)
        store_symmetric(stress, lane, s)
        store_stress(out, lane, product_symmetric(f, s))


@njit(**INNER)
def _tangents(n, viscosity, state, stress, out, turned):
    """Derivative by the rate in rows 9-53 of `out`, and by F at a given rate of strain in those of `turned`."""
    entry = 9 * _L
    for r in range(9):
        i, J = r // 3, r % 3
        for c in range(r, 9):
            k, L = c // 3, c % 3
            for lane in range(n):
                value = state[(3 * i + L) * _L + lane] * state[(3 * k + J) * _L + lane]
                if J == L:
                    for M in range(3):
                        value += state[(3 * i + M) * _L + lane] * state[(3 * k + M) * _L + lane]
                out[entry + lane] = 0.5 * viscosity * value
                turned[entry + lane] = stress[_PAIR[J, L] * _L + lane] if i == k else 0.0
            entry += _L


@njit(
    types.void(
        *(types.intp, types.intp, types.intp, types.boolean, types.boolean),
        *CELLS,
        *(TABLE, VECTOR, VECTOR, types.float64),
        *(INDEX, INDEX, PLACES),
        *(VECTOR, VECTOR, VECTOR, VECTOR),
    ),
    **OPTIONS,
)
def add_viscous(
    first: Any,
    last: Any,
    dimension: Any,
    affine: Any,
    with_tangent: Any,
    sizes: Any,
    starts: Any,
    nodes: Any,
    corners: Any,
    fibre: Any,
    weights: Any,
    slopes: Any,
    map_slopes: Any,
    blocks: Any,
    displacement: Any,
    velocity: Any,
    viscosity: Any,
    lengths: Any,
    rows: Any,
    places: Any,
    force: Any,
    stiffness_data: Any,
    damping_data: Any,
    largest: Any,
):
    """Add force, stiffness at a given rate of strain, and damping of the blocks from `first` to before `last`.

    `largest` (n_blocks,) gets the largest stress [Pa] of each block.
    """
    n_nodes, n_q = nodes.shape[1], weights.shape[0]
    n_pairs = n_nodes * (n_nodes + 1) // 2
    local, speed, gradients = aligned(3 * n_nodes), aligned(3 * n_nodes), aligned(3 * n_nodes)
    local_force = aligned(3 * n_nodes)
    inverse, volume, at, peak = aligned(9), aligned(1), aligned(1), aligned(1)
    state, moving, stress = aligned(9), aligned(9), aligned(6)
    out, turned, half = aligned(54), aligned(54), aligned(27)
    n_kept = 9 * n_pairs if with_tangent else 0
    local_stiffness, local_damping = aligned(n_kept), aligned(n_kept)
    for block in range(first, last):
        top = 0.0
        for batch in range(blocks[block, 0], blocks[block, 1]):
            n = sizes[batch]
            touched = nodes[batch]
            gather(dimension, n_nodes, touched, displacement, local)
            gather(dimension, n_nodes, touched, velocity, speed)
            local_force[:] = 0.0
            peak[:] = 0.0
            local_stiffness[:] = 0.0
            local_damping[:] = 0.0
            for q in range(n_q):
                if q == 0 or not affine:
                    volume_and_inverse(dimension, map_slopes[q], corners[batch], inverse, volume)
                shape_gradients(n_nodes, slopes[q], inverse, gradients)
                deformation(1.0, n_nodes, local, gradients, state)
                deformation(0.0, n_nodes, speed, gradients, moving)
                _stress(n, viscosity, state, moving, stress, out)
                store(at, 0, weights[q] * load(volume, 0))
                raise_peak(out, peak)
                add_force(n_nodes, at, gradients, out, local_force)
                if with_tangent:
                    _tangents(n, viscosity, state, stress, out, turned)
                    add_stiffness(n_nodes, at, gradients, turned, half, local_stiffness)
                    add_stiffness(n_nodes, at, gradients, out, half, local_damping)
            for lane in range(n):
                top = max(top, peak[lane])
                for a in range(n_nodes):
                    for i in range(dimension):
                        force[dimension * touched[a, lane] + i] += local_force[(3 * a + i) * _L + lane]
            if with_tangent:
                scatter_stiffness(
                    n, dimension, n_nodes, touched, lengths, rows, places[batch], local_stiffness, stiffness_data
                )
                scatter_stiffness(
                    n, dimension, n_nodes, touched, lengths, rows, places[batch], local_damping, damping_data
                )
        largest[block] = top
