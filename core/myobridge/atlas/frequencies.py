r"""Largest frequency of a solid about a state, to predict the step beyond which explicit methods fail.

.. math:: K w = \omega^2 M w, \qquad B w = 0

Worked out with dense matrices, by no method that an integrator uses: it is what those are measured by.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Motion

__all__ = ["exact_largest_frequency"]


def exact_largest_frequency(
    solid: MacroSolid, motion: Motion | None = None, law: ActiveLaw | None = None, time: float = 0.0
) -> float:
    """Largest angular frequency [rad/s] of small motions that keep the constraint.

    Parameters
    ----------
    motion : Motion, optional
        State about which it moves; at rest without.
    law : ActiveLaw, optional
        Whose stiffness counts too.
    """
    import scipy.linalg

    state = solid.rest_motion() if motion is None else motion
    balance = solid.balance(state, law, time, rate=False, tangent=True)
    stiffness, mass = _dense(balance.stiffness), _dense(solid.mass_matrix)
    gradient = balance.constraint_gradient
    if gradient is not None and state.multiplier.size:
        free = scipy.linalg.null_space(_dense(gradient))
        stiffness, mass = free.T @ stiffness @ free, free.T @ mass @ free
    highest = len(mass) - 1
    squared = scipy.linalg.eigh(
        0.5 * (stiffness + stiffness.T), 0.5 * (mass + mass.T), eigvals_only=True, subset_by_index=[highest, highest]
    )
    return math.sqrt(max(float(squared[0]), 0.0))


def _dense(matrix: Any) -> Array:
    found = matrix.toarray() if hasattr(matrix, "toarray") else np.asarray(matrix)
    return np.diag(found) if found.ndim == 1 else found
