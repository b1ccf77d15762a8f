r"""Largest frequency of a solid about a motion, with its constraint: what bounds the step of explicit methods.

.. math:: P^T K P\,x = \omega^2 M x, \qquad P = 1 - M^{-1} B^T S^{-1} B, \quad B\,x = 0

`K` is the tangent at the motion, active stiffness and the multiplier's share included.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Motion
from myobridge.solvers.constrained import ConstrainedMass
from myobridge.solvers.explicit import compliance_solver, elastic_multiplier
from myobridge.solvers.linear import times
from myobridge.solvers.step import effective_mass

__all__ = ["Frequency", "largest_frequency"]

# Accuracy of the multipliers in one product.
_ROUGH = 1e-8


class Frequency(NamedTuple):
    """Angular frequency [rad/s], not below the largest but for what the iteration missed, and its shape."""

    omega: float
    shape: Array


def largest_frequency(
    solid: MacroSolid,
    law: ActiveLaw | None,
    motion: Motion,
    time: float,
    *,
    start: Array | None = None,
    accuracy: float = 1e-3,
    most: int = 60,
) -> Frequency:
    """Largest frequency by Lanczos iterations in the norm of the mass.

    Parameters
    ----------
    start : ndarray, optional
        Shape to begin with, such as that of an earlier motion; without, one that holds every frequency.
    accuracy : float
        Relative error of the square at which it stops; the error that is left is added to the answer.
    most : int
        Iterations at most.

    Raises
    ------
    UnsolvedSystem, SingularMatrix
        See `ConstrainedMass.solve`.
    """
    n, inertance = solid.n_unknowns, None if law is None else law.inertance
    elastic = elastic_multiplier(solid, motion.displacement, time)
    at = motion if elastic is None else Motion(motion.displacement, motion.velocity, elastic)
    balance = solid.balance(at, law, time, tangent=True)
    stiffness, gradient, mass = balance.stiffness, balance.constraint_gradient, effective_mass(solid, inertance)
    yielding = compliance_solver(solid)
    strict = ConstrainedMass(solid, gradient if yielding is None else None, inertance=inertance)
    assert stiffness is not None

    def image(vector: Array) -> Array:
        force = stiffness @ vector
        if yielding is not None:  # the multiplier follows the displacement like a spring
            assert gradient is not None
            force = force + gradient.T @ yielding(gradient @ vector)
        return strict.solve(force, 0.0, _ROUGH)[0]

    # A shape that was largest once is helped by a little of everything: another may be by now.
    first = np.random.default_rng(1).standard_normal(n)
    if start is not None:
        first = 0.1 * float(np.linalg.norm(start)) / float(np.linalg.norm(first)) * first + start
    vector = strict.solve(times(mass, first), 0.0, _ROUGH)[0]
    length = math.sqrt(float(vector @ times(mass, vector)))
    if length == 0.0:
        return Frequency(0.0, first)
    basis = [vector / length]
    diagonal: list[float] = []
    beside: list[float] = []
    while True:
        last = basis[-1]
        found = image(last)
        weighted = times(mass, found)
        diagonal.append(float(last @ weighted))
        for _ in range(2):  # all of them, twice: otherwise round-off brings found frequencies back
            for earlier in basis:
                found = found - float(earlier @ weighted) * earlier
                weighted = times(mass, found)
        rest = math.sqrt(max(float(found @ weighted), 0.0))
        matrix = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
        values, shapes = np.linalg.eigh(matrix)
        missed = rest * abs(float(shapes[-1, -1]))
        done = missed <= accuracy * abs(float(values[-1])) or len(basis) >= min(most, n)
        if done or rest <= 1e-12 * abs(float(values[-1])):
            shape = np.stack(basis, axis=1) @ shapes[:, -1]
            return Frequency(math.sqrt(max(float(values[-1]) + missed, 0.0)), shape)
        beside.append(rest)
        basis.append(found / rest)
