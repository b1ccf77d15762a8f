r"""What explicit integrators share: the force at a point, and the acceleration that keeps a constraint.

.. math:: M a + f(u, v, t) + B^T p = 0, \qquad B a + \gamma = 0, \qquad
          \gamma = \frac{d^2}{ds^2}\Big|_{s=0} c(u + s v, t + s)

A constraint with a compliance, :math:`c(u) - C p = 0`, is none to these methods: its multiplier is
:math:`C^{-1} c(u)`, and acts like a spring. The compliance must not change with the motion.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import attrs
import numpy as np

from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Matrix, Motion
from myobridge.solvers.constrained import ConstrainedMass
from myobridge.solvers.linear import mass_solver, solve
from myobridge.solvers.step import effective_mass

__all__ = [
    "Accelerated",
    "PointForce",
    "accelerated",
    "acceleration",
    "compliance_solver",
    "constraint_at",
    "constraint_curvature",
    "constraint_rate",
    "elastic_multiplier",
    "point_force",
    "strictly_constrained",
]

# Of a step: within it a support's velocity hardly changes, and round-off of the constraint does not count.
_NEAR = 1.0 / 64.0


class PointForce(NamedTuple):
    """Force at a point without that of a strict constraint [N], gradient of that constraint, and multiplier.

    Without a strict constraint the gradient is None, and the force is that of the multiplier given.
    """

    force: Array
    gradient: Matrix | None
    multiplier: Array


class Accelerated(NamedTuple):
    """Acceleration [m/s^2], and the multiplier that goes with it."""

    acceleration: Array
    multiplier: Array


def point_force(
    solid: MacroSolid, law: ActiveLaw | None, motion: Motion, time: float, *, strict: bool = False
) -> PointForce:
    """Force and gradient at a motion; its multiplier plays no part.

    Parameters
    ----------
    strict : bool
        Take a constraint with compliance as one without.
    """
    if motion.multiplier.size == 0:
        return PointForce(solid.balance(motion, law, time).force, None, motion.multiplier)
    if not strict:
        multiplier = elastic_multiplier(solid, motion.displacement, time)
        if multiplier is not None:
            there = attrs.evolve(motion, multiplier=multiplier)
            return PointForce(solid.balance(there, law, time).force, None, multiplier)
    free = attrs.evolve(motion, multiplier=np.zeros_like(motion.multiplier))
    balance = solid.balance(free, law, time, tangent=True)
    return PointForce(balance.force, balance.constraint_gradient, free.multiplier)


def acceleration(solid: MacroSolid, law: ActiveLaw | None, motion: Motion, time: float) -> Array:
    r"""Acceleration [m/s^2]; the mass is factored once for each solid, unless heads add to it."""
    if motion.multiplier.size:
        return accelerated(solid, law, motion, time).acceleration
    force = solid.balance(motion, law, time).force
    if law is None or law.inertance is None:
        return -mass_solver(solid)(force)
    mass = effective_mass(solid, law.inertance)
    return -force / mass if mass.ndim == 1 else -solve(mass, force)


def accelerated(
    solid: MacroSolid,
    law: ActiveLaw | None,
    motion: Motion,
    time: float,
    *,
    strict: bool = False,
    dt: float | None = None,
) -> Accelerated:
    """Acceleration and multiplier at a motion whose multiplier plays no part.

    Parameters
    ----------
    strict : bool
        Take a constraint with compliance as one without: what oscillates through the compliance is left out of the
        multiplier.
    dt : float, optional
        Step [s], for supports that move: their way is looked at within a fraction of it. Without, they count as still.

    Raises
    ------
    UnsolvedSystem, SingularMatrix
        See `ConstrainedMass.solve`.
    """
    at = point_force(solid, law, motion, time, strict=strict)
    mass = ConstrainedMass(solid, at.gradient, inertance=None if law is None else law.inertance)
    if at.gradient is None:
        return Accelerated(-mass.inverse(at.force), at.multiplier)
    return Accelerated(*mass.solve(-at.force, -constraint_curvature(solid, motion, time, dt)))


def constraint_at(solid: MacroSolid, displacement: Array, time: float) -> tuple[Array, float]:
    """Constraint without compliance, and the size of what cancels in it."""
    at = _still(solid, displacement)
    balance = solid.balance(at, None, time, rate=False)
    assert balance.constraint is not None, "a solid with multipliers must have a constraint"
    return balance.constraint, balance.constraint_magnitude


def constraint_rate(solid: MacroSolid, displacement: Array, time: float, dt: float) -> Array:
    """Rate of the constraint [1/s] that supports alone give it just before `time`; zero where they stand still."""
    near = _NEAR * dt
    here, before = (constraint_at(solid, displacement, at)[0] for at in (time, time - near))
    if np.array_equal(here, before):
        return np.zeros_like(here)
    earlier = constraint_at(solid, displacement, time - 2.0 * near)[0]
    return (3.0 * here - 4.0 * before + earlier) / (2.0 * near)


def constraint_curvature(solid: MacroSolid, motion: Motion, time: float, dt: float | None = None) -> Array:
    """gamma [1/s^2], by a difference that is exact for constraints of degree three in the displacement.

    J is of that degree, so the difference may be as wide as the shape of the body allows. Supports that move bring it
    down to a fraction of the step; what they do around `time` is then taken as smooth.
    """
    fastest = float(np.abs(motion.velocity).max(initial=0.0))
    here = constraint_at(solid, motion.displacement, time)[0]
    if dt is not None:
        near = _NEAR * dt
        moved = [constraint_at(solid, motion.displacement, time + side * near)[0] for side in (-1.0, 1.0)]
        if not (np.array_equal(moved[0], here) and np.array_equal(moved[1], here)):
            if fastest > 0.0:
                near = min(near, solid.displacement_scale / fastest)
            return _second_difference(solid, motion, time, here, near, near)
    if fastest == 0.0:
        return np.zeros_like(here)
    return _second_difference(solid, motion, time, here, solid.displacement_scale / fastest, 0.0)


def _second_difference(solid: MacroSolid, motion: Motion, time: float, here: Array, span: float, way: float) -> Array:
    after, before = (
        constraint_at(solid, motion.displacement + side * span * motion.velocity, time + side * way)[0]
        for side in (1.0, -1.0)
    )
    return (after - 2.0 * here + before) / span**2


def elastic_multiplier(solid: MacroSolid, displacement: Array, time: float) -> Array | None:
    """Multiplier of a constraint with compliance; None without constraint, or where it is strict."""
    inverse = compliance_solver(solid)
    return None if inverse is None else inverse(constraint_at(solid, displacement, time)[0])


def strictly_constrained(solid: MacroSolid) -> bool:
    """Whether a solid has a constraint without compliance."""
    return _n_constraints(solid) > 0 and compliance_solver(solid) is None


def _still(solid: MacroSolid, displacement: Array) -> Motion:
    return Motion(displacement, np.zeros_like(displacement), np.zeros(_n_constraints(solid)))


@functools.lru_cache(maxsize=8)
def _n_constraints(solid: MacroSolid) -> int:
    return solid.rest_motion().multiplier.size


@functools.lru_cache(maxsize=8)
def compliance_solver(solid: MacroSolid) -> Callable[[Array], Array] | None:
    """Inverse of the compliance, factored once for each solid; None without."""
    start = solid.rest_motion()
    if not start.multiplier.size:
        return None
    compliance = solid.balance(start, None, 0.0, rate=False, tangent=True).constraint_compliance
    if compliance is None:
        return None
    if isinstance(compliance, np.ndarray):
        return functools.partial(solve, compliance)
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    return sparse_linalg.splu(sparse.csc_array(compliance)).solve
