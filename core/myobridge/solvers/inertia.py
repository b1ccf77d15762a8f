r"""Inertia of a symmetric matrix: how many eigenvalues are negative, zero, positive.

.. math:: N(A + S) \;\le\; N(A) \;\le\; N(A - S), \qquad S \succ 0, \qquad
          N(P A P^T) = N(L D L^T) = N(D)

with `N` the number of negative eigenvalues: monotonicity first, then Sylvester's law of inertia.

Dense matrices: all eigenvalues. Sparse ones: the two bounds, from two factorisations without off-diagonal pivots.
SuperLU does not know symmetry, but when its row order is its column order, `L U` is the `L D L^T` of the permuted
matrix, and the signs of the diagonal of `U` are those of `D`. That, and the round-off of the factors, is checked and
not hoped for: :math:`|E| \le \gamma_k |L||U|` with `k` the longest row of `L` (Higham [1]_, theorem 9.3). The shift `S`
is chosen larger than `|E|`, so that both counts are true of the matrix itself. Where they agree the count is proven;
where they differ, the eigenvalues between are zero to within the shift. Lanczos iterations cannot promise as much: they
may miss an eigenvalue.

The matrix is first scaled by a congruence :math:`D A D`, exact because `D` holds powers of two: it keeps the inertia
and lets displacements [m] and pressures [Pa] stand side by side. Cost: two factorisations, one for a stable state with
constraints, seven in the worst case.

References
----------
.. [1] N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), sections 9.3 and 10.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from myobridge.interfaces import Array, Matrix

__all__ = ["Inertia", "InertiaUnknown", "inertia"]

_EPS = float(np.finfo(float).eps)
# Below this size all eigenvalues of a dense copy cost less than two sparse factorisations.
_DENSE = 200
# The largest dense copy that is made when the factors of a sparse matrix prove nothing (0.1 GB).
_LARGEST_COPY = 4000
# Eigenvalues of the scaled matrix below this share of its norm may at most be called zero.
_WIDEST = 1e-7


class InertiaUnknown(ArithmeticError):
    """The signs of the eigenvalues cannot be proven: the matrix is not finite, or large with unstable factors."""


class Inertia(NamedTuple):
    """Numbers of negative eigenvalues, of those that are zero to round-off, and of positive ones."""

    negative: int
    zero: int
    positive: int


def inertia(matrix: Matrix, constraints: int = 0) -> Inertia:
    r"""Signs of the eigenvalues of the symmetric part of a matrix, dense or sparse.

    An equilibrium is stable where its stiffness has no negative eigenvalue. The saddle matrix ``[[A, B], [B^T, -C]]``
    of a solid with `n_p` constraints (`B` of full rank, `C` zero or positive) has exactly `n_p` of them where the solid
    is stable, and one more for each unstable direction.

    Of an unsymmetric matrix (follower loads) the symmetric part is judged. If that is positive definite every
    eigenvalue of the matrix has a positive real part (Bendixson); the reverse does not hold, so a negative eigenvalue
    is then a warning and no proof of instability.

    Parameters
    ----------
    matrix : ndarray or sparse array, shape (n, n)
        Any unit.
    constraints : int
        Rows at the end that are constraints of full rank: there are at least as many negative eigenvalues, so that one
        factorisation proves a stable state.

    Returns
    -------
    Inertia
        An eigenvalue of the scaled matrix below about ``n`` times round-off of its norm counts as zero; of a sparse
        matrix with growing factors below 1e-7 of its norm.

    Raises
    ------
    InertiaUnknown
        If the matrix is not finite; if it is sparse, beyond 4000 rows, and its factors are too large to prove a count.
    """
    if isinstance(matrix, np.ndarray):
        return _of_dense(matrix)
    import scipy.sparse as sparse

    whole: Any = sparse.csc_array(matrix, dtype=np.float64)
    if whole.shape[0] <= _DENSE:
        return _of_dense(whole.toarray())
    scaled = _scaled_sparse(sparse.csc_array(0.5 * (whole + whole.T)))
    if constraints:
        order = _small_diagonals_late(scaled)
        if _at_most(scaled, order) == constraints:
            return Inertia(constraints, 0, scaled.shape[0] - constraints)
        orders = [order, None]
    else:
        orders = [None, _small_diagonals_late(scaled)]
    for order in orders:  # rows of small diagonal behind all their neighbours, or an order of less fill
        found = _between_bounds(scaled, order)
        if found is not None:
            return found
    if scaled.shape[0] <= _LARGEST_COPY:
        return _of_dense(scaled.toarray())
    raise InertiaUnknown(
        f"the factors of a sparse matrix with {scaled.shape[0]} rows grow too much to count its negative eigenvalues"
    )


def _of_dense(matrix: Array) -> Inertia:
    n = matrix.shape[0]
    if n == 0:
        return Inertia(0, 0, 0)
    if not np.all(np.isfinite(matrix)):
        raise InertiaUnknown("the matrix is not finite")
    symmetric = 0.5 * (matrix + matrix.T)
    for _ in range(3):
        factors = _powers_of_two(np.abs(symmetric).max(axis=0))
        symmetric = factors[:, None] * symmetric * factors
    eigenvalues = np.linalg.eigvalsh(symmetric)
    zero = 4.0 * n * _EPS * float(np.abs(eigenvalues).max())
    negative, positive = int(np.sum(eigenvalues < -zero)), int(np.sum(eigenvalues > zero))
    return Inertia(negative, n - negative - positive, positive)


def _scaled_sparse(symmetric: Any) -> Any:
    """The matrix with largest entries of about 1 in every row and column."""
    import scipy.sparse as sparse

    if not np.all(np.isfinite(symmetric.data)):
        raise InertiaUnknown("the matrix is not finite")
    for _ in range(3):
        factors = sparse.diags_array(_powers_of_two(abs(symmetric).max(axis=0).toarray().ravel()))
        symmetric = sparse.csc_array(factors @ symmetric @ factors)
    return symmetric


def _powers_of_two(largest: Array) -> Array:
    """About ``1 / sqrt(largest)``, 1 where a row is empty."""
    return np.exp2(-np.round(0.5 * np.log2(np.where(largest > 0.0, largest, 1.0))))


def _between_bounds(scaled: Any, order: np.ndarray | None) -> Inertia | None:
    """Inertia from the counts at a shift up and down that exceeds the round-off of the factors; None without."""
    n = scaled.shape[0]
    norm = float(abs(scaled).sum(axis=0).max())
    shift = 16.0 * n * _EPS * norm  # about the error that is found; too small costs a second round
    while shift <= _WIDEST * norm:
        up, down = _count(scaled, shift, order), _count(scaled, -shift, order)
        if up is None or down is None:
            shift *= 1e4
            continue
        error = max(up[1], down[1])
        if error <= shift:
            return Inertia(up[0], down[0] - up[0], n - down[0])
        shift = 2.0 * error
    return None


def _at_most(scaled: Any, order: np.ndarray | None) -> int | None:
    """Upper bound of the number of negative eigenvalues, mostly from one factorisation; None without."""
    norm = float(abs(scaled).sum(axis=0).max())
    shift = 64.0 * scaled.shape[0] * _EPS * norm
    while shift <= _WIDEST * norm:
        down = _count(scaled, -shift, order)
        if down is None or down[1] <= shift:
            return None if down is None else down[0]
        shift = 2.0 * down[1]
    return None


def _count(scaled: Any, shift: float, order: np.ndarray | None) -> tuple[int, float] | None:
    """Negative pivots of the shifted matrix and the error of its factors; None where a pivot left the diagonal."""
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    shifted = sparse.csc_array(scaled + shift * sparse.eye_array(scaled.shape[0]))
    rule = "MMD_AT_PLUS_A"
    if order is not None:
        shifted, rule = sparse.csc_array(shifted[order][:, order]), "NATURAL"
    try:
        factors = sparse_linalg.splu(
            shifted, permc_spec=rule, diag_pivot_thresh=0.0, options={"SymmetricMode": True, "Equil": False}
        )
    except RuntimeError:  # SuperLU's word for a pivot that is zero
        return None
    if not np.array_equal(factors.perm_r, factors.perm_c):
        return None
    lower, upper = abs(factors.L), abs(factors.U)
    longest = float(np.diff(sparse.csr_array(lower).indptr).max())
    # The infinity norm bounds the eigenvalues of the symmetric error.
    error = 2.0 * longest * _EPS * float(np.max(lower @ (upper @ np.ones(upper.shape[0]))))
    return int(np.sum(factors.U.diagonal() < 0.0)), error


def _small_diagonals_late(scaled: Any) -> np.ndarray:
    """Elimination order in which rows of small diagonal, as of constraints, come right after their last neighbour."""
    import scipy.sparse as sparse
    import scipy.sparse.csgraph as csgraph

    n = scaled.shape[0]
    place = np.empty(n)
    place[csgraph.reverse_cuthill_mckee(sparse.csr_array(scaled), symmetric_mode=True)] = np.arange(n)
    late = np.abs(scaled.diagonal()) < 1e-3
    entries = sparse.coo_array(scaled[:, late])
    rows, columns = entries.coords
    ordinary = ~late[rows]
    last = place[late]
    np.maximum.at(last, columns[ordinary], place[rows[ordinary]])
    place[late] = last + 0.5
    return np.argsort(place, kind="stable")
