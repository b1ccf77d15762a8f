"""Loop over batches of elements: residual and tangent into vectors and sparse rows.

Blocks of consecutive batches may run in parallel, colour by colour: blocks of one colour share no node, so the order of
every sum is fixed and the answer does not depend on the number of threads.

Arguments that the loops share:

* ``dimension``, ``affine``: 2 or 3; whether the Jacobian is constant in a cell.
* ``sizes`` (n_batches,), ``starts`` (n_batches,): cells of a batch, and number of its first point; a batch numbers its
  points quadrature point by quadrature point, cell by cell.
* ``nodes`` (n_batches, n_nodes, LANES), ``multipliers`` (n_batches, n_multipliers, LANES): what a cell touches.
* ``corners`` (n_batches, 3 * n_corners * LANES): positions. ``fibre`` (3, n_points): reference directions.
* ``weights`` (n_q,), ``slopes`` (n_q, n_nodes, 3), ``map_slopes`` (n_q, n_corners, 3), ``shapes`` (n_q, n_multipliers):
  the reference cell at its quadrature points, displacement, geometry and multiplier.
* ``blocks`` (n_blocks, 2): batches of a block; blocks are sorted by colour.
"""

from __future__ import annotations

from typing import Any

from numba import njit, types

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.contraction_kernels import (
    add_constraint,
    add_dilation,
    add_force,
    add_stiffness,
)
from myobridge_plugins.macro_solid.finite_element.element_kernels import (
    deformation,
    gather,
    gather_scalars,
    shape_gradients,
    volume_and_inverse,
)
from myobridge_plugins.macro_solid.finite_element.kernel_types import (
    CELLS,
    INDEX,
    LAW,
    MATRIX,
    PLACES,
    TABLE,
    TOUCHED,
    VECTOR,
)
from myobridge_plugins.macro_solid.finite_element.lane_vectors import add_to, aligned, load, spread, store
from myobridge_plugins.macro_solid.finite_element.point_kernels import OPTIONS, add_stress, add_tangent, raise_peak
from myobridge_plugins.macro_solid.finite_element.scatter_kernels import scatter_gradient, scatter_stiffness

__all__ = ["assemble"]

_L = LANES


@njit(
    types.void(
        *(types.intp, types.intp, types.intp, types.boolean, types.boolean, types.boolean),
        *CELLS,
        *(TOUCHED, MATRIX, TABLE, LAW, VECTOR),
        *(VECTOR, VECTOR, VECTOR, VECTOR),
        *(INDEX, INDEX, PLACES, INDEX, PLACES),
        *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR),
    ),
    **OPTIONS,
)
def assemble(
    first: Any,
    last: Any,
    dimension: Any,
    affine: Any,
    passive: Any,
    with_tangent: Any,
    sizes: Any,
    starts: Any,
    nodes: Any,
    corners: Any,
    fibre: Any,
    weights: Any,
    slopes: Any,
    map_slopes: Any,
    multipliers: Any,
    shapes: Any,
    blocks: Any,
    tangent_law: Any,
    constants: Any,
    displacement: Any,
    pressure: Any,
    tension: Any,
    stiffness: Any,
    lengths: Any,
    rows: Any,
    places: Any,
    gradient_rows: Any,
    gradient_places: Any,
    force: Any,
    constraint: Any,
    stiffness_data: Any,
    gradient_data: Any,
    largest: Any,
):
    """Add internal force, constraint and their derivatives of the blocks from `first` to before `last`.

    `largest` (n_blocks,) gets the largest stress [Pa] of each block.

    `tangent_law` is the material's tangent, or its stress where no tangent is wanted. Without `passive` the material
    is left out: then only pressure and tension act.
    """
    n_nodes, n_multipliers, n_q = nodes.shape[1], multipliers.shape[1], weights.shape[0]
    n_pairs = n_nodes * (n_nodes + 1) // 2
    local, local_pressure = aligned(3 * n_nodes), aligned(n_multipliers)
    gradients = aligned(3 * n_nodes)
    inverse, volume, at, peak = aligned(9), aligned(1), aligned(1), aligned(1)
    state, out, extra, half = aligned(15), aligned(54), aligned(14), aligned(27)
    local_force, local_constraint = aligned(3 * n_nodes), aligned(n_multipliers)
    local_stiffness = aligned(9 * n_pairs if with_tangent else 0)
    local_gradient = aligned(3 * n_multipliers * n_nodes if with_tangent else 0)
    state[:] = 0.0
    out[:] = 0.0
    for block in range(first, last):
        top = 0.0
        for batch in range(blocks[block, 0], blocks[block, 1]):
            n = sizes[batch]
            touched = nodes[batch]
            gather(dimension, n_nodes, touched, displacement, local)
            gather_scalars(multipliers[batch], pressure, local_pressure)
            local_force[:] = 0.0
            local_constraint[:] = 0.0
            local_stiffness[:] = 0.0
            local_gradient[:] = 0.0
            peak[:] = 0.0
            for q in range(n_q):
                if q == 0 or not affine:
                    volume_and_inverse(dimension, map_slopes[q], corners[batch], inverse, volume)
                shape_gradients(n_nodes, slopes[q], inverse, gradients)
                deformation(1.0, n_nodes, local, gradients, state)
                point = starts[batch] + q * n
                for lane in range(n):
                    state[9 * _L + lane] = fibre[0, point + lane]
                    state[10 * _L + lane] = fibre[1, point + lane]
                    state[11 * _L + lane] = fibre[2, point + lane]
                    state[13 * _L + lane] = tension[point + lane]
                    state[14 * _L + lane] = stiffness[point + lane]
                store(state, 12, spread(0.0))
                for k in range(n_multipliers):
                    add_to(state, 12, shapes[q, k] * load(local_pressure, k))
                if passive:
                    tangent_law(n, state, out, constants)
                else:
                    out[:] = 0.0
                add_stress(state, extra, out)
                raise_peak(out, peak)
                store(at, 0, weights[q] * load(volume, 0))
                add_force(n_nodes, at, gradients, out, local_force)
                add_dilation(at, shapes[q], extra[9 * _L :], local_constraint)
                if with_tangent:
                    add_tangent(state, extra, out)
                    add_stiffness(n_nodes, at, gradients, out, half, local_stiffness)
                    add_constraint(n_nodes, at, gradients, shapes[q], extra, local_gradient)
            for lane in range(n):
                top = max(top, peak[lane])
                for a in range(n_nodes):
                    for i in range(dimension):
                        force[dimension * touched[a, lane] + i] += local_force[(3 * a + i) * _L + lane]
                for k in range(n_multipliers):
                    constraint[multipliers[batch, k, lane]] += local_constraint[k * _L + lane]
            if with_tangent:
                scatter_stiffness(
                    n, dimension, n_nodes, touched, lengths, rows, places[batch], local_stiffness, stiffness_data
                )
                scatter_gradient(
                    n,
                    dimension,
                    n_nodes,
                    n_multipliers,
                    touched,
                    multipliers[batch],
                    lengths,
                    rows,
                    gradient_rows,
                    gradient_places[batch],
                    local_gradient,
                    gradient_data,
                )
        largest[block] = top
