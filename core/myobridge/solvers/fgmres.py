r"""Flexible GMRES: the smallest residual of a system in the space that a preconditioner spans.

.. math:: \min_{y}\,\|b - A Z_k\,y\|, \qquad Z_k = (M^{-1} v_1, \dots, M^{-1} v_k), \qquad A Z_k = V_{k+1} \bar H_k

The residual is that of the system itself, whatever the preconditioner [1]_. It keeps `Z` beside `V`: twice the memory
of GMRES, and no application more than it has iterations. A vector is made orthogonal to all earlier ones at once, and
twice, so that it is [2]_.

References
----------
.. [1] Y. Saad, SIAM J. Sci. Comput. 14 (1993) 461-469.
.. [2] L. Giraud, J. Langou, M. Rozloznik, J. van den Eshof, Numer. Math. 101 (2005) 87-100.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from myobridge.interfaces import Array
from myobridge.solvers.linear import UnsolvedSystem

__all__ = ["fgmres", "smallest_residual"]

# What is left of a vector that lies in the space already, as a share of it.
_ROUND_OFF = 100.0 * float(np.finfo(float).eps)


def fgmres(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    vector: Array,
    tolerance: float,
    max_iterations: int,
) -> tuple[Array, int]:
    """Solution of ``product(x) = vector`` from zero, and the iterations that it took.

    Parameters
    ----------
    precondition : callable
        Approximate inverse; need not be linear.
    tolerance : float
        Residual relative to the vector.
    max_iterations : int
        After which the system is given up; there is no restart.

    Raises
    ------
    UnsolvedSystem
        If the residual is not reached.
    """
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return np.zeros(vector.size), 0
    found, done = smallest_residual(product, precondition, vector, 0.9 * tolerance * size, max_iterations)
    # Computed afresh: the residual that was carried along knows nothing of its own round-off.
    missed = float(np.linalg.norm(vector - product(found))) / size
    if not missed <= tolerance:
        raise UnsolvedSystem(
            f"GMRES with a kept factorisation left {missed:.1e} of the right side after {done} iterations, allowed is "
            f"{tolerance:.1e}"
        )
    return found, done


def smallest_residual(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    vector: Array,
    allowed: float,
    max_iterations: int,
) -> tuple[Array, int]:
    """Point of smallest residual after one cycle without restart, from zero, and the iterations that it took.

    Parameters
    ----------
    vector : ndarray
        Right side, not zero.
    allowed : float
        Norm of the residual that ends the cycle early; it is the one carried along.

    Raises
    ------
    UnsolvedSystem
        If the preconditioner answers with numbers that are not finite.
    """
    n, size = vector.size, float(np.linalg.norm(vector))
    most = min(max_iterations, n)
    # Memory that is not written yet takes no room.
    basis, steps = np.empty((most + 1, n)), np.empty((most, n))
    np.divide(vector, size, out=basis[0])
    hessenberg = np.zeros((most + 1, most))
    right = np.zeros(most + 1)
    right[0] = size
    cosines, sines = np.zeros(most), np.zeros(most)
    done = most
    for k in range(most):
        steps[k] = precondition(basis[k])
        following = product(steps[k])
        before = float(np.linalg.norm(following))
        known = basis[: k + 1]
        for _ in range(2):
            shares = known @ following
            following -= shares @ known
            hessenberg[: k + 1, k] += shares
        left = float(np.linalg.norm(following))
        if not np.isfinite(left):
            raise UnsolvedSystem(
                f"after {k + 1} iterations the preconditioner answers with numbers that are not finite"
            )
        hessenberg[k + 1, k] = left
        for i in range(k):
            _rotate(hessenberg[:, k], i, cosines[i], sines[i])
        length = float(np.hypot(hessenberg[k, k], hessenberg[k + 1, k]))
        if length == 0.0:
            done = k + 1
            break
        cosines[k], sines[k] = hessenberg[k, k] / length, hessenberg[k + 1, k] / length
        _rotate(hessenberg[:, k], k, cosines[k], sines[k])
        _rotate(right, k, cosines[k], sines[k])
        if abs(right[k + 1]) <= allowed or left <= _ROUND_OFF * before:
            done = k + 1
            break
        np.divide(following, left, out=basis[k + 1])
    shares = np.linalg.lstsq(np.triu(hessenberg[:done, :done]), right[:done], rcond=None)[0]
    return shares @ steps[:done], done


def _rotate(column: Array, i: int, cosine: float, sine: float) -> None:
    """Givens' rotation of the entries i and i + 1, in place."""
    upper, lower = column[i], column[i + 1]
    column[i], column[i + 1] = cosine * upper + sine * lower, cosine * lower - sine * upper
