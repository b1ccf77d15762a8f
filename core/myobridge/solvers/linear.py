"""Linear algebra that does not care whether a matrix is a number, a vector (lumped), dense or sparse."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from myobridge.interfaces import Array, LinearSystem, MacroSolid, Matrix

__all__ = ["SingularMatrix", "add_scaled", "bordered", "mass_solver", "saddle", "solve", "times"]


class SingularMatrix(ArithmeticError):
    """The matrix has no inverse."""


def times(matrix: Matrix, vector: Array) -> Array:
    """``matrix @ vector``; a lumped matrix is the vector of its diagonal."""
    return matrix * vector if isinstance(matrix, np.ndarray) and matrix.ndim == 1 else matrix @ vector


def add_scaled(matrix: Matrix, factor: float, other: Matrix | None) -> Matrix:
    """``matrix + factor * other`` for a square `matrix`, dense or sparse; `other` may be lumped or None."""
    if other is None:
        return matrix
    if isinstance(other, np.ndarray) and other.ndim == 1:
        if isinstance(matrix, np.ndarray):
            result = matrix.copy()
            result.flat[:: matrix.shape[0] + 1] += factor * other
            return result
        import scipy.sparse as sparse  # here and below: it takes longer to import than all the rest

        return matrix + sparse.diags_array(factor * other)
    return matrix + factor * other


def bordered(matrix: Matrix, column: Array, row: Array, corner: float) -> Matrix:
    """The matrix with one more column and row, ``[[matrix, column], [row, corner]]``, dense or sparse as it was."""
    if isinstance(matrix, np.ndarray):
        n = column.size
        result = np.empty((n + 1, n + 1))
        result[:n, :n], result[:n, n], result[n, :n], result[n, n] = matrix, column, row, corner
        return result
    import scipy.sparse as sparse

    blocks = [[matrix, column[:, None]], [row[None], np.array([[corner]])]]
    return sparse.block_array([[sparse.csc_array(block) for block in line] for line in blocks], format="csc")


def solve(matrix: Matrix, vector: Array) -> Array:
    """Solution of ``matrix @ x = vector``.

    Raises
    ------
    SingularMatrix
        If there is none.
    """
    if isinstance(matrix, np.ndarray):
        if matrix.size == 1:
            if matrix[0, 0] == 0.0:
                raise SingularMatrix
            return vector / matrix[0, 0]
        try:
            return np.asarray(np.linalg.solve(matrix, vector), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise SingularMatrix from None
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    try:
        return sparse_linalg.splu(sparse.csc_array(matrix)).solve(vector)
    except RuntimeError:  # SuperLU's word for a singular factor
        raise SingularMatrix from None


@functools.lru_cache(maxsize=8)
def mass_solver(solid: MacroSolid) -> Callable[[Array], Array]:
    """Function that applies the inverse of the solid's mass matrix; factored once for each solid."""
    mass = solid.mass_matrix
    if isinstance(mass, np.ndarray) and mass.ndim == 1:
        return lambda force: force / mass
    if isinstance(mass, np.ndarray):
        return functools.partial(solve, mass)
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    return sparse_linalg.splu(sparse.csc_array(mass)).solve


def saddle(system: LinearSystem) -> Matrix:
    """The whole matrix of a system: dense where its stiffness is dense and alone, else a sparse array (CSC)."""
    if system.gradient is None or system.transposed_gradient is None:
        return system.stiffness
    import scipy.sparse as sparse

    compliance = None if system.compliance is None else -sparse.csr_array(system.compliance)
    upper = [sparse.csr_array(system.stiffness), sparse.csr_array(system.transposed_gradient.T)]
    if compliance is None:
        n = system.n_constraints
        compliance = sparse.csr_array((n, n))
    return sparse.block_array([upper, [sparse.csr_array(system.gradient), compliance]], format="csc")
