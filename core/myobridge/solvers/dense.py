"""Systems that are small or full: LAPACK's factors of the whole matrix."""

from __future__ import annotations

from typing import Any

import numpy as np

from myobridge.interfaces import Array, Factorisation
from myobridge.solvers.inertia import Inertia, inertia
from myobridge.solvers.linear import SingularMatrix, UnsolvedSystem

__all__ = ["DenseFactorisation"]

# A residual above this share of the right side is no solution, whatever the condition of the matrix.
_WORST = 1e-6


class DenseFactorisation(Factorisation):
    r"""Factors of a dense matrix, shape (n, n); of one that looks singular, with rows and columns of one size.

    .. math:: D_r A D_c \; y = D_r b, \qquad x = D_c \, y, \qquad \max_j |D_r A D_c|_{ij} \approx 1

    The equations of a saddle have units of their own: mass over a short step squared stands beside the gradient of a
    constraint, and unscaled such a matrix looks singular from some 1e-4 of a sensible step on.

    Raises
    ------
    SingularMatrix
        If the matrix is singular to round-off, or not finite.
    """

    def __init__(self, matrix: Array, *, symmetric: bool = False) -> None:
        self._matrix, self._symmetric = matrix, symmetric
        if not np.isfinite(matrix).all():
            raise SingularMatrix
        self._rows = self._columns = np.ones(matrix.shape[0])
        factors = _factors(matrix)
        if factors is None:
            self._rows, self._columns = _scales(matrix)
            factors = _factors(self._rows[:, None] * matrix * self._columns)
        if factors is None:
            raise SingularMatrix
        self._factors = factors

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        found = self.approximate(vector)
        missed = float(np.linalg.norm(vector - self._matrix @ found))
        allowed = max(tolerance, _WORST) * float(np.linalg.norm(vector))
        if not missed <= allowed:
            raise UnsolvedSystem(f"dense factors left a residual of {missed:.1e}, allowed is {allowed:.1e}")
        return found

    def approximate(self, vector: Array) -> Array:
        import scipy.linalg as linalg

        found = linalg.lu_solve(self._factors, (self._rows * vector.T).T, check_finite=False)
        return (self._columns * np.asarray(found).T).T

    @property
    def worth(self) -> float:
        # n/3 by the operations, of which factors do several at the price of one.
        return max(self._matrix.shape[0] / 10.0, 1.0)

    def inertia(self) -> Inertia | None:
        return inertia(self._matrix) if self._symmetric else None

    def describe(self) -> str:
        return f"dense factors of {self._matrix.shape[0]} unknowns"


def _factors(matrix: Array) -> Any:
    """Triangular factors and pivots; none if the matrix is singular to round-off."""
    import scipy.linalg as linalg

    factor, condition = linalg.get_lapack_funcs(("getrf", "gecon"), (matrix,))
    factors, pivots, info = factor(matrix)
    norm = float(np.abs(matrix).sum(axis=0).max()) if matrix.size else 0.0
    if matrix.size and (info > 0 or condition(factors, norm)[0] < np.finfo(float).eps):
        return None
    return factors, pivots


def _scales(matrix: Array) -> tuple[Array, Array]:
    """Powers of two that bring the largest entry of every row and column near one, in a few sweeps of Ruiz' method.

    An empty row or column keeps its size, and the factors find it singular.
    """
    rows, columns, size = np.ones(matrix.shape[0]), np.ones(matrix.shape[0]), np.abs(matrix)
    for _ in range(3 if matrix.size else 0):
        row, column = size.max(axis=1), size.max(axis=0)
        by_row = np.exp2(-np.round(0.5 * np.log2(np.where(row > 0.0, row, 1.0))))
        by_column = np.exp2(-np.round(0.5 * np.log2(np.where(column > 0.0, column, 1.0))))
        rows, columns, size = rows * by_row, columns * by_column, by_row[:, None] * size * by_column
    return rows, columns
