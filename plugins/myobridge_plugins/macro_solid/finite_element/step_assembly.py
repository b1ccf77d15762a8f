"""Assembly of a whole step: the discrete gradient of the body and its derivatives, summed up by the kernels."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from myobridge.interfaces import Array
from myobridge.work import count
from myobridge_plugins.macro_solid.finite_element.assembly import Assembly

__all__ = ["StepSums", "step_sums"]

_NONE = np.empty(0)


class StepSums(NamedTuple):
    """What one assembly of a step gives.

    Attributes
    ----------
    force, constraint : ndarray
        Over all numbers [N], and at the end [m^3].
    stiffness, constraint_gradient, acting_gradient : ndarray
        Data of the derivatives of force and constraint by the end, and of the gradient in the force; the caller's.
    magnitude : float
        Largest stress, and the root mean square of what cancels in the corrections of the material's [Pa].
    taken : float
        Energy that viscosity takes [J].
    """

    force: Array
    constraint: Array
    stiffness: Array
    constraint_gradient: Array
    acting_gradient: Array
    magnitude: float
    taken: float


def step_sums(
    assembly: Assembly,
    start: Array,
    change: Array,
    pressure: Array,
    tension: Array | None,
    slope: Array | None,
    drag: float,
    modulus: float,
    *,
    tangent: bool,
) -> StepSums:
    """Force and constraint of a step, with their derivatives where `tangent` is asked for.

    Parameters
    ----------
    start, change : ndarray, (n_full,)
        Displacement of all nodes at the start, and how it changes [m].
    pressure : ndarray, (n_multipliers,)
        Multiplier that acts [Pa].
    tension, slope : ndarray, (n_points,), or None
        Tension of the step at every point [Pa], and its derivative by the stretch at the end.
    drag : float
        Viscosity over the length of the step [Pa].
    modulus : float
        Of the tissue [Pa], the measure of round-off.
    """
    from myobridge_plugins.macro_solid.finite_element.step_kernels import assemble_step

    grid, pattern = assembly.discretisation, assembly.pattern
    count("assembled_elements", grid.n_cells)
    force, constraint = np.zeros(start.size), np.zeros(grid.n_multipliers)
    stiffness_data = np.zeros(pattern.stiffness.size) if tangent else _NONE
    gradient_data, acting_data = (np.zeros(pattern.gradient.size) if tangent else _NONE for _ in range(2))
    measures = [np.zeros((len(region.blocks), 4)) for region in assembly.regions]
    for region, measured in zip(assembly.regions, measures, strict=True):
        functions = region.material.functions()
        law = functions.tangent if tangent else functions.stress
        given = (
            *assembly.shape,
            tangent,
            *assembly.cells,
            assembly.multipliers,
            grid.cell.shapes,
            region.blocks,
            law.pointer,
            functions.energy.pointer,
            region.constants,
            start,
            change,
            pressure,
            assembly.zeros if tension is None else tension,
            assembly.zeros if slope is None else slope,
            drag,
            modulus,
            pattern.lengths,
            pattern.stiffness.rows,
            pattern.stiffness.places,
            pattern.gradient.rows,
            pattern.gradient.places,
            force,
            constraint,
            stiffness_data,
            gradient_data,
            acting_data,
            measured,
        )
        assembly.run(lambda first, last, given=given: assemble_step(first, last, *given), region.colours)
    largest, lost, rough, volume = np.concatenate(measures).T
    magnitude = float(largest.max() + math.sqrt(rough.sum() / volume.sum()))
    return StepSums(force, constraint, stiffness_data, gradient_data, acting_data, magnitude, float(lost.sum()))
