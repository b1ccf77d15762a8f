"""Loop over batches of elements that writes the passive energy of each.

Its arguments are those of `assembly_kernels`. A module of its own: what asks for no energy does not compile it.
"""

from __future__ import annotations

from typing import Any

from numba import njit, types

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.element_kernels import (
    deformation,
    gather,
    shape_gradients,
    volume_and_inverse,
)
from myobridge_plugins.macro_solid.finite_element.kernel_types import CELLS, INDEX, LAW, VECTOR
from myobridge_plugins.macro_solid.finite_element.lane_vectors import aligned
from myobridge_plugins.macro_solid.finite_element.point_kernels import OPTIONS

__all__ = ["energies"]

_L = LANES


@njit(
    types.void(types.intp, types.intp, types.intp, types.boolean, *CELLS, INDEX, LAW, VECTOR, VECTOR, VECTOR),
    **OPTIONS,
)
def energies(
    first: Any,
    last: Any,
    dimension: Any,
    affine: Any,
    sizes: Any,
    starts: Any,
    nodes: Any,
    corners: Any,
    fibre: Any,
    weights: Any,
    slopes: Any,
    map_slopes: Any,
    batches: Any,
    energy_law: Any,
    constants: Any,
    displacement: Any,
    energy: Any,
):
    """Passive energy [J] of each of the given `batches` from place `first` to before `last`."""
    n_nodes, n_q = nodes.shape[1], weights.shape[0]
    local, gradients = aligned(3 * n_nodes), aligned(3 * n_nodes)
    inverse, volume, state, out = aligned(9), aligned(1), aligned(15), aligned(1)
    for index in range(first, last):
        batch = batches[index]
        n = sizes[batch]
        gather(dimension, n_nodes, nodes[batch], displacement, local)
        total = 0.0
        for q in range(n_q):
            if q == 0 or not affine:
                volume_and_inverse(dimension, map_slopes[q], corners[batch], inverse, volume)
            shape_gradients(n_nodes, slopes[q], inverse, gradients)
            deformation(1.0, n_nodes, local, gradients, state)
            for lane in range(n):
                for J in range(3):
                    state[(9 + J) * _L + lane] = fibre[J, starts[batch] + q * n + lane]
            energy_law(n, state, out, constants)
            for lane in range(n):
                total += weights[q] * volume[lane] * out[lane]
        energy[batch] = total
