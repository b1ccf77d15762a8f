r"""Newton's method, shared by all implicit integrators and by continuation.

.. math:: F'(x_k)\,\delta_k = -F(x_k), \qquad x_{k+1} = x_k + \alpha_k\,\delta_k

The step is halved (backtracking) while the new point is not admissible or its residual is not finite.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from myobridge.interfaces import Array, Matrix
from myobridge.solvers.linear import SingularMatrix, solve

__all__ = ["NewtonResult", "newton"]

_ROUND_OFF = 16.0 * float(np.finfo(float).eps)


class NewtonResult(NamedTuple):
    """Unknowns found, whether they solve the problem, iterations spent, and why not."""

    unknowns: Array
    converged: bool
    iterations: int
    reason: str = ""


def newton(
    evaluate: Callable[[Array], tuple[Array, Matrix, float]],
    start: Array,
    *,
    admissible: Callable[[Array], bool],
    tolerance: float = 1e-12,
    max_iterations: int = 30,
    backtracks: int = 20,
) -> NewtonResult:
    """Solve ``F(x) = 0``.

    Parameters
    ----------
    evaluate : callable
        Residual and tangent at a point, and the norm of the terms that cancel in the residual.
    start : ndarray, shape (n,)
        Where to begin.
    admissible : callable
        Whether a point is physically possible.
    tolerance : float
        Converged when the residual has fallen by this factor, or when it, or a correction, is round-off.

    Returns
    -------
    NewtonResult
        Failure is a result, not an exception: the caller halves its step.
    """
    unknowns = start
    residual, tangent, magnitude = evaluate(unknowns)
    size = _size(residual)
    first = size
    for iteration in range(max_iterations):
        if not math.isfinite(size):
            return NewtonResult(unknowns, False, iteration, "the residual is not finite")
        # A residual below the round-off of its own terms cannot fall any further.
        if size <= _ROUND_OFF * magnitude or (iteration > 0 and size <= tolerance * first):
            return NewtonResult(unknowns, True, iteration)
        try:
            correction = solve(tangent, residual)
        except SingularMatrix:
            return NewtonResult(unknowns, False, iteration, "the tangent is singular")
        fraction = 1.0
        for _ in range(backtracks):
            candidate = unknowns - fraction * correction
            if admissible(candidate):
                residual, tangent, magnitude = evaluate(candidate)
                size = _size(residual)
                if math.isfinite(size):
                    break
            fraction *= 0.5
        else:
            return NewtonResult(unknowns, False, iteration + 1, "no admissible point along Newton's direction")
        unknowns = candidate
        if fraction == 1.0 and _size(correction) <= _ROUND_OFF * _size(unknowns):
            return NewtonResult(unknowns, True, iteration + 1)
    if size <= max(tolerance * first, _ROUND_OFF * magnitude):
        return NewtonResult(unknowns, True, max_iterations)
    reason = f"Newton did not converge in {max_iterations} iterations (residual {first:.2e} at first, {size:.2e} now)"
    return NewtonResult(unknowns, False, max_iterations, reason)


def _size(vector: Array) -> float:
    return float(abs(vector[0])) if vector.size == 1 else float(np.sqrt(vector @ vector))
