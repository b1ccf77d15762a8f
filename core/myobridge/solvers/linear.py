"""Linear algebra that does not care whether a matrix is a number, a vector (lumped), dense or sparse."""

from __future__ import annotations

import functools
from collections.abc import Callable

import attrs
import numpy as np

from myobridge.interfaces import Array, LinearSystem, MacroSolid, Matrix
from myobridge.work import count

__all__ = [
    "SingularMatrix",
    "UnsolvedSystem",
    "absolute_product",
    "add_scaled",
    "bordered",
    "length_of",
    "mass_solver",
    "norm_of",
    "saddle",
    "solve",
    "times",
]


class SingularMatrix(ArithmeticError):
    """The matrix has no inverse."""


class UnsolvedSystem(ArithmeticError):
    """The residual asked for was not reached; the message says which solver, after what, and how far it came."""


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


def length_of(vector: Array) -> float:
    """Euclidean norm; infinite, without a warning, where its square is: a residual that is too large is just that."""
    if vector.size == 1:
        return float(abs(vector[0]))
    with np.errstate(over="ignore"):
        return float(np.sqrt(vector @ vector))


def norm_of(matrix: Matrix) -> float:
    """Square root of the sum of squares of all entries."""
    return float(np.linalg.norm(matrix if isinstance(matrix, np.ndarray) else matrix.data))


def absolute_product(matrix: Matrix | LinearSystem, vector: Array) -> Array:
    """``|matrix| @ |vector|``: the size of what cancels in their product."""
    if isinstance(matrix, LinearSystem):
        parts = (matrix.stiffness, matrix.transposed_gradient, matrix.gradient, matrix.compliance)
        sizes = [None if part is None else abs(part) for part in parts]
        if sizes[3] is not None:
            sizes[3] = -sizes[3]
        return attrs.evolve(
            matrix, stiffness=sizes[0], transposed_gradient=sizes[1], gradient=sizes[2], compliance=sizes[3]
        ).times(np.abs(vector))
    return abs(matrix) @ np.abs(vector)


def bordered(matrix: Matrix | LinearSystem, column: Array, row: Array, corner: float) -> Matrix | LinearSystem:
    """The matrix with one more column and row, ``[[matrix, column], [row, corner]]``, dense or sparse as it was.

    A system gets one more multiplier: its condition is the row.
    """
    if isinstance(matrix, LinearSystem):
        return _bordered_system(matrix, column, row, corner)
    if isinstance(matrix, np.ndarray):
        n = column.size
        result = np.empty((n + 1, n + 1))
        result[:n, :n], result[:n, n], result[n, :n], result[n, n] = matrix, column, row, corner
        return result
    import scipy.sparse as sparse

    blocks = [[matrix, column[:, None]], [row[None], np.array([[corner]])]]
    return sparse.block_array([[sparse.csc_array(block) for block in line] for line in blocks], format="csc")


def _bordered_system(system: LinearSystem, column: Array, row: Array, corner: float) -> LinearSystem:
    import scipy.sparse as sparse

    n, m = system.stiffness.shape[0], system.n_constraints

    def stacked(gradient: Matrix | None, last: Array) -> Matrix:
        lines = [sparse.csr_array(last[None])]
        return sparse.vstack([sparse.csr_array(gradient), *lines] if gradient is not None else lines, format="csr")

    inner = sparse.csr_array((m, m)) if system.compliance is None else sparse.csr_array(system.compliance)
    edges = [sparse.csr_array(-column[n:, None]), sparse.csr_array(-row[None, n:])]
    last = sparse.csr_array(np.array([[-corner]]))
    compliance = sparse.block_array([[inner, edges[0]], [edges[1], last]], format="csr") if m else last
    return LinearSystem(
        system.stiffness,
        stacked(system.transposed_gradient, column[:n]),
        stacked(system.gradient, row[:n]),
        compliance,
        system.rigid_motions,
        symmetric=False,
    )


def solve(matrix: Matrix | LinearSystem, vector: Array) -> Array:
    """Solution of ``matrix @ x = vector``; large systems by the solver that suits them.

    Raises
    ------
    SingularMatrix
        If there is none.
    UnsolvedSystem
        If the residual was not reached.
    """
    if isinstance(matrix, np.ndarray):
        count("factorisations")
        if matrix.size == 1:
            if matrix[0, 0] == 0.0:
                raise SingularMatrix
            return vector / matrix[0, 0]
        try:
            return np.asarray(np.linalg.solve(matrix, vector), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise SingularMatrix from None
    from myobridge.solvers.choice import factorise

    return factorise(matrix).solve(vector)


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

    # Positive definite: no pivoting, and an order that keeps the symmetry fills half as much.
    options = {"SymmetricMode": True}
    return sparse_linalg.splu(
        sparse.csc_array(mass), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    ).solve


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
