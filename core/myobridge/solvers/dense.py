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
    """Factors of a dense matrix, shape (n, n).

    Raises
    ------
    SingularMatrix
        If the matrix is singular to round-off, or not finite.
    """

    def __init__(self, matrix: Array, *, symmetric: bool = False) -> None:
        import scipy.linalg as linalg

        self._matrix, self._symmetric = matrix, symmetric
        norm = float(np.abs(matrix).sum(axis=0).max()) if matrix.size else 0.0
        if not np.isfinite(norm):
            raise SingularMatrix
        factor, condition = linalg.get_lapack_funcs(("getrf", "gecon"), (matrix,))
        factors, pivots, info = factor(matrix)
        if matrix.size and (info > 0 or condition(factors, norm)[0] < np.finfo(float).eps):
            raise SingularMatrix
        self._factors: Any = (factors, pivots)

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        import scipy.linalg as linalg

        found = np.asarray(linalg.lu_solve(self._factors, vector, check_finite=False))
        missed = float(np.linalg.norm(vector - self._matrix @ found))
        allowed = max(tolerance, _WORST) * float(np.linalg.norm(vector))
        if not missed <= allowed:
            raise UnsolvedSystem(f"dense factors left a residual of {missed:.1e}, allowed is {allowed:.1e}")
        return found

    def approximate(self, vector: Array) -> Array:
        import scipy.linalg as linalg

        return np.asarray(linalg.lu_solve(self._factors, vector, check_finite=False))

    @property
    def worth(self) -> float:
        # n/3 by the operations, of which factors do several at the price of one.
        return max(self._matrix.shape[0] / 10.0, 1.0)

    def inertia(self) -> Inertia | None:
        return inertia(self._matrix) if self._symmetric else None

    def describe(self) -> str:
        return f"dense factors of {self._matrix.shape[0]} unknowns"
