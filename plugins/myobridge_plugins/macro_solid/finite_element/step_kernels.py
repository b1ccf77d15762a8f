"""Loop over batches of elements for a whole step: residual of its discrete gradient, and its tangent, into sparse rows.

Arguments are those of `assembly_kernels`, with the displacement at the start and its change, `slope` = dT / d lambda at
the end, `drag` = viscosity / dt, and a `modulus` [Pa] of the tissue, the measure of round-off. Nothing here is
symmetric: all pairs of nodes are summed up and scattered.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.contraction_kernels import (
    add_constraint,
    add_dilation,
    add_force,
    add_whole_stiffness,
)
from myobridge_plugins.macro_solid.finite_element.element_kernels import (
    deformation,
    gather,
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
from myobridge_plugins.macro_solid.finite_element.lane_vectors import aligned, load, store
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER, OPTIONS, raise_peak
from myobridge_plugins.macro_solid.finite_element.scatter_kernels import scatter_gradient, scatter_whole_stiffness
from myobridge_plugins.macro_solid.finite_element.step_moduli_kernels import (
    add_correction_moduli,
    add_moduli,
    add_other_moduli,
    gradients_of_volume,
    whole_tangent,
)
from myobridge_plugins.macro_solid.finite_element.step_point_kernels import (
    KEPT,
    correct,
    mean_stress,
    step_states,
    step_stress,
)

__all__ = ["assemble_step"]

_L = LANES
# Shares of the end in C at the Gauss points, and the weight of both.
_EARLY, _LATE = 0.5 - np.sqrt(1.0 / 12.0), 0.5 + np.sqrt(1.0 / 12.0)


@njit(**INNER)
def _fill(n, point, fibre, tension, slope, shapes, numbers, pressure, start, end, first, second):
    """Rows beyond 8 of the states of a point: N everywhere, and p, T and dT / d lambda of `start`."""
    for lane in range(n):
        for row in range(3):
            x = fibre[row, point + lane]
            start[(9 + row) * _L + lane] = x
            end[(9 + row) * _L + lane] = x
            first[(9 + row) * _L + lane] = x
            second[(9 + row) * _L + lane] = x
        start[12 * _L + lane] = 0.0
        start[13 * _L + lane] = tension[point + lane]
        start[14 * _L + lane] = slope[point + lane]
    for k in range(shapes.shape[0]):
        for lane in range(n):
            start[12 * _L + lane] += shapes[k] * pressure[numbers[k, lane]]


@njit(
    types.void(
        *(types.intp, types.intp, types.intp, types.boolean, types.boolean),
        *CELLS,
        *(TOUCHED, MATRIX, TABLE, LAW, LAW, VECTOR),
        *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, types.float64, types.float64),
        *(INDEX, INDEX, PLACES, INDEX, PLACES),
        *(VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX),
    ),
    **OPTIONS,
)
def assemble_step(
    first_block: Any,
    last_block: Any,
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
    multipliers: Any,
    shapes: Any,
    blocks: Any,
    law: Any,
    energy: Any,
    constants: Any,
    displacement: Any,
    moved: Any,
    pressure: Any,
    tension: Any,
    slope: Any,
    drag: Any,
    modulus: Any,
    lengths: Any,
    rows: Any,
    places: Any,
    gradient_rows: Any,
    gradient_places: Any,
    force: Any,
    constraint: Any,
    stiffness_data: Any,
    gradient_data: Any,
    acting_data: Any,
    measures: Any,
):
    """Add force, constraint at the end and their derivatives of the blocks from `first_block` to before `last_block`.

    `law` is the material's tangent, or its stress where no tangent is wanted. `measures` (n_blocks, 4) gets of each
    block the largest stress [Pa], the energy that viscosity takes [J], the integral of the square of what cancels in
    the corrections [Pa^2 m^3], and the volume [m^3].
    """
    n_nodes, n_multipliers, n_q = nodes.shape[1], multipliers.shape[1], weights.shape[0]
    local, change = aligned(3 * n_nodes), aligned(3 * n_nodes)
    gradients = aligned(3 * n_nodes)
    inverse, volume, at, peak = aligned(9), aligned(1), aligned(1), aligned(1)
    start, end, first, second = aligned(15), aligned(15), aligned(15), aligned(15)
    early, late, out = aligned(54), aligned(54), aligned(54)
    kept, half = aligned(KEPT), aligned(63)
    before, after = aligned(1), aligned(1)
    moduli, whole = aligned(36), aligned(81)
    volumes = aligned(18)
    local_force = aligned(3 * n_nodes)
    local_constraint = aligned(n_multipliers)
    local_stiffness = aligned(9 * n_nodes * n_nodes if with_tangent else 0)
    local_gradient = aligned(3 * n_multipliers * n_nodes if with_tangent else 0)
    local_acting = aligned(3 * n_multipliers * n_nodes if with_tangent else 0)
    for block in range(first_block, last_block):
        top, lost, rough, whole_volume = 0.0, 0.0, 0.0, 0.0
        for batch in range(blocks[block, 0], blocks[block, 1]):
            n = sizes[batch]
            touched = nodes[batch]
            gather(dimension, n_nodes, touched, displacement, local)
            gather(dimension, n_nodes, touched, moved, change)
            local_force[:] = 0.0
            peak[:] = 0.0
            local_constraint[:] = 0.0
            local_stiffness[:] = 0.0
            local_gradient[:] = 0.0
            local_acting[:] = 0.0
            for q in range(n_q):
                if q == 0 or not affine:
                    volume_and_inverse(dimension, map_slopes[q], corners[batch], inverse, volume)
                shape_gradients(n_nodes, slopes[q], inverse, gradients)
                deformation(1.0, n_nodes, local, gradients, start)
                deformation(0.0, n_nodes, change, gradients, end)
                point = starts[batch] + q * n
                _fill(
                    *(n, point, fibre, tension, slope, shapes[q], multipliers[batch], pressure),
                    *(start, end, first, second),
                )
                step_states(n, start, end, first, second, kept)
                law(n, first, early, constants)
                law(n, second, late, constants)
                large = mean_stress(n, first, second, early, late, kept)
                if large:
                    energy(n, start, before, constants)
                    energy(n, end, after, constants)
                    correct(n, modulus, before, after, kept)
                step_stress(n, drag, start, kept, out)
                store(at, 0, weights[q] * load(volume, 0))
                for lane in range(n):
                    lost += at[lane] * drag * kept[27 * _L + lane]
                    rough += at[lane] * kept[39 * _L + lane] * kept[39 * _L + lane]
                    whole_volume += at[lane]
                raise_peak(out, peak)
                add_force(n_nodes, at, gradients, out, local_force)
                add_dilation(at, shapes[q], kept[30 * _L :], local_constraint)
                if with_tangent:
                    moduli[:] = 0.0
                    add_moduli(n, 0.5 * _EARLY, first, early, half, moduli)
                    add_moduli(n, 0.5 * _LATE, second, late, half, moduli)
                    if large:
                        law(n, end, out, constants)
                        add_correction_moduli(n, end, out, half, kept, moduli)
                    add_other_moduli(n, drag, start, end, half, kept, moduli)
                    whole_tangent(n, end, kept, moduli, half, whole)
                    add_whole_stiffness(n_nodes, at, gradients, whole, half, local_stiffness)
                    if n_multipliers > 0:
                        gradients_of_volume(n, end, kept, volumes)
                        add_constraint(n_nodes, at, gradients, shapes[q], volumes, local_gradient)
                        add_constraint(n_nodes, at, gradients, shapes[q], volumes[9 * _L :], local_acting)
            for lane in range(n):
                top = max(top, peak[lane])
                for a in range(n_nodes):
                    for i in range(dimension):
                        force[dimension * touched[a, lane] + i] += local_force[(3 * a + i) * _L + lane]
                for k in range(n_multipliers):
                    constraint[multipliers[batch, k, lane]] += local_constraint[k * _L + lane]
            if with_tangent:
                scatter_whole_stiffness(
                    n, dimension, n_nodes, touched, lengths, rows, places[batch], local_stiffness, stiffness_data
                )
                scatter_gradient(
                    *(n, dimension, n_nodes, n_multipliers, touched, multipliers[batch], lengths, rows),
                    *(gradient_rows, gradient_places[batch], local_gradient, gradient_data),
                )
                scatter_gradient(
                    *(n, dimension, n_nodes, n_multipliers, touched, multipliers[batch], lengths, rows),
                    *(gradient_rows, gradient_places[batch], local_acting, acting_data),
                )
        measures[block, 0] = top
        measures[block, 1] = lost
        measures[block, 2] = rough
        measures[block, 3] = whole_volume
