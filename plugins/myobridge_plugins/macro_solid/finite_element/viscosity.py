r"""Viscosity of a body (Kelvin and Voigt).

.. math:: S = \eta\,\dot E, \qquad E = \tfrac12 (F^T F - I)

The power that it takes, :math:`\int \eta\,\lVert \dot E \rVert^2`, is never negative, and a body that turns without
deforming feels nothing.
"""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array
from myobridge_plugins.macro_solid.finite_element.assembly import Assembly

__all__ = ["add_viscosity"]

_NONE = np.empty(0)


def add_viscosity(
    assembly: Assembly,
    viscosity: float,
    displacement: Array,
    velocity: Array,
    force: Array,
    stiffness: Array | None = None,
    damping: Array | None = None,
) -> float:
    """Add the viscous share to the force [N] of all numbers, and to the data of both tangents where they are given.

    The stiffness is the derivative at a given rate of strain, which is symmetric.

    Returns
    -------
    float
        Largest viscous stress [Pa].
    """
    from myobridge_plugins.macro_solid.finite_element.viscous_kernels import add_viscous

    pattern, top = assembly.pattern, 0.0
    for region in assembly.regions:
        largest = np.zeros(len(region.blocks))
        given = (
            *assembly.shape,
            stiffness is not None,
            *assembly.cells,
            region.blocks,
            displacement,
            velocity,
            viscosity,
            pattern.lengths,
            pattern.stiffness.rows,
            pattern.stiffness.places,
            force,
            _NONE if stiffness is None else stiffness,
            _NONE if damping is None else damping,
            largest,
        )
        assembly.run(lambda first, last, given=given: add_viscous(first, last, *given), region.colours)
        top = max(top, float(largest.max(initial=0.0)))
    return top
