r"""Projections onto a constraint, in the norm of the mass.

.. math:: u = u^* - M^{-1} B^T \mu, \quad c(u) = 0; \qquad v = v^* - M^{-1} B(u)^T \nu, \quad B(u)\,v + \dot c = 0

with :math:`\dot c` the rate that supports alone give the constraint.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from myobridge.interfaces import Array, MacroSolid, Matrix
from myobridge.solvers.constrained import ConstrainedMass
from myobridge.solvers.explicit import constraint_at, constraint_rate
from myobridge.solvers.linear import SingularMatrix, UnsolvedSystem, times

__all__ = ["Projected", "gradient_at", "onto_constraint", "projected_displacement", "projected_velocity"]

# Of the size of what cancels in the constraint: what is aimed at, and what is enough once it gets no better.
_AIM, _ENOUGH = 4.0 * float(np.finfo(float).eps), 1e-13
_MANY = 40
# Accuracy of the multipliers of one correction; the next one makes up for the rest.
_ROUGH = 1e-4


class Projected(NamedTuple):
    """A displacement on the constraint, how far it was corrected, its multipliers, and how it went.

    The correction is told apart: as a difference of displacements it would lose digits. `reason` is empty where all
    went well.
    """

    displacement: Array
    correction: Array
    multiplier: Array
    iterations: int
    reason: str = ""


def gradient_at(solid: MacroSolid, displacement: Array, time: float, multiplier: Array) -> Matrix:
    """Gradient of the constraint; `multiplier` says how many there are."""
    from myobridge.interfaces import Motion

    at = Motion(displacement, np.zeros_like(displacement), np.zeros_like(multiplier))
    found = solid.balance(at, None, time, rate=False, tangent=True).constraint_gradient
    assert found is not None, "a solid with multipliers must have a gradient of its constraint"
    return found


def onto_constraint(solid: MacroSolid, near: ConstrainedMass, displacement: Array, time: float) -> Projected:
    r"""Displacement ``u - M^-1 B^T mu`` on the constraint, by Newton's method with :math:`B M^{-1} B^T`.

    Parameters
    ----------
    near : ConstrainedMass
        Mass and gradient; the gradient is kept, so it must be that of a displacement close by.
    """
    total, multiplier, last = np.zeros_like(displacement), np.zeros(0), math.inf
    nothing = np.zeros_like(displacement)
    for iteration in range(_MANY):
        here = displacement + total
        violation, size = constraint_at(solid, here, time)
        left = float(np.linalg.norm(violation)) / size
        if left <= _AIM or (left <= _ENOUGH and left > 0.5 * last):
            multiplier = multiplier if iteration else np.zeros_like(violation)
            return Projected(here, total, multiplier, iteration)
        if not left < 4.0 * last:  # written so that nan is caught too
            return Projected(here, total, multiplier, iteration, _lost(left))
        try:
            correction, added = near.solve(nothing, -violation, _ROUGH)
        except (UnsolvedSystem, SingularMatrix) as error:
            return Projected(here, total, multiplier, iteration, f"{_lost(left)}: {error}")
        total, last = total + correction, left
        multiplier = multiplier + added if iteration else added
    return Projected(displacement + total, total, multiplier, _MANY, _lost(last))


def projected_displacement(solid: MacroSolid, displacement: Array, multiplier: Array, time: float) -> Projected:
    """The nearest displacement on the constraint, in the norm of the mass; halved corrections keep it admissible."""
    here, mass = displacement, solid.mass_matrix
    scale = float(np.linalg.norm(displacement))
    acting = np.zeros_like(multiplier)
    for iteration in range(_MANY):
        violation, size = constraint_at(solid, here, time)
        left = float(np.linalg.norm(violation)) / size
        near = ConstrainedMass(solid, gradient_at(solid, here, time, multiplier))
        try:
            correction, acting = near.solve(times(mass, displacement - here), -violation)
        except (UnsolvedSystem, SingularMatrix) as error:
            return Projected(here, here - displacement, acting, iteration, f"{_lost(left)}: {error}")
        if left <= _ENOUGH and float(np.linalg.norm(correction)) <= 1e-8 * scale:
            last = onto_constraint(solid, near, here, time)
            return last._replace(correction=last.displacement - displacement, multiplier=acting, iterations=iteration)
        share = 1.0
        while not solid.admissible(here + share * correction, time):
            share *= 0.5
            if share < 1e-3:
                return Projected(here, here - displacement, acting, iteration, _lost(left))
        here = here + share * correction
    return Projected(here, here - displacement, acting, _MANY, _lost(math.inf))


def projected_velocity(
    solid: MacroSolid, velocity: Array, multiplier: Array, displacement: Array, time: float, dt: float
) -> Array:
    """The nearest velocity that keeps the constraint; `multiplier` says how many there are."""
    gradient = gradient_at(solid, displacement, time, multiplier)
    rate = -constraint_rate(solid, displacement, time, dt) - gradient @ velocity
    return velocity + ConstrainedMass(solid, gradient).solve(np.zeros_like(velocity), rate)[0]


def _lost(left: float) -> str:
    return f"the displacement was not brought onto the constraint (J - 1 is still about {left:.2g})"
