"""GMRES with algebraic multigrid, for systems whose factors would not fit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.parameters import integer
from myobridge.solvers import Inertia, SingularMatrix, UnsolvedSystem
from myobridge_plugins.linear_solver.smallest_eigenvalues import judged

__all__ = ["AmgGmres"]

# Blocks of unknowns, one an aggregate of nodes, of the coarsest level, which is solved directly.
_COARSEST = 200
# Cycles that the hierarchy is worth, as measured.
_WORTH = 15.0
# Weight of the diagonal that stands for the Schur complement: for P2-P1 it is about twice too large.
_SCHUR = 0.5


@final
@attrs.frozen
class AmgGmres(LinearSolver):
    r"""Right-preconditioned GMRES; block-triangular preconditioner with one W-cycle of multigrid on the stiffness.

    .. math:: \begin{pmatrix} K & B_1^T \\ B_2 & -C \end{pmatrix} M^{-1} y = b, \quad x = M^{-1} y, \qquad
              M = \begin{pmatrix} \hat K & B_1^T \\ 0 & -\hat S \end{pmatrix}, \quad
              \hat S = 2\,\mathrm{diag}\bigl(B_2\,\mathrm{diag}(K)^{-1} B_1^T + C\bigr)

    with :math:`\hat K` smoothed aggregation (Vanek et al. [1]_, by pyamg) of the symmetric part of `K`, which is told
    the rigid motions. Preconditioned from the right, the residual that GMRES minimises is the true one. Its iterations
    grow slowly with the mesh, its memory is that of the matrix and of one vector for each iteration up to `restart`.
    The inertia is looked for and not proven (`smallest_eigenvalues`); a matrix that is singular shows itself by
    iterations that do not end.

    Parameters
    ----------
    restart : int
        Iterations between restarts: as many vectors are kept.
    max_iterations : int
        After which the system is given up.

    References
    ----------
    .. [1] P. Vanek, J. Mandel, M. Brezina, Computing 56 (1996) 179-196.
    .. [2] H. Elman, D. Silvester, A. Wathen, Finite Elements and Fast Iterative Solvers (2014), chapter 4.
    """

    tells_inertia: ClassVar[bool] = True
    direct: ClassVar[bool] = False
    summary: ClassVar[str] = "GMRES with algebraic multigrid (pyamg), for large bodies in space"

    restart: int = integer(100, within="[10, inf)", doc="iterations between restarts of GMRES")
    max_iterations: int = integer(400, within="[1, inf)", doc="iterations after which a system is given up")

    def seconds(self, size: SystemSize) -> float | None:
        if not size.structured:
            return None
        return 0.75 * (size.n_unknowns / 8e3) ** 1.2 if size.dimension == 3 else 3.0 * size.n_unknowns / 58e3

    def factorise(self, system: LinearSystem) -> Factorisation:
        return _Multigrid(self, system)


@final
class _Multigrid(Factorisation):
    """Hierarchy of one stiffness, and the diagonal that stands for its Schur complement."""

    def __init__(self, solver: AmgGmres, system: LinearSystem) -> None:
        import scipy.sparse as sparse

        self._solver, self._iterations = solver, 0
        stiffness: Any = sparse.csr_matrix(system.stiffness)
        if not np.all(np.isfinite(stiffness.data)):
            raise SingularMatrix
        self._n = stiffness.shape[0]
        coupling: Any = None
        self._schur = np.empty(0)
        if system.gradient is not None and system.transposed_gradient is not None:
            coupling = sparse.csr_array(system.transposed_gradient)
            self._schur = _schur_diagonal(system, stiffness, coupling) / _SCHUR
            if not np.all(self._schur > 0.0):
                raise SingularMatrix
            # Transposed once: products with a transposed view of rows are slower.
            coupling = sparse.csr_array(coupling.T)
        self._coupling = coupling
        self._system = attrs.evolve(system, stiffness=stiffness)
        symmetric = stiffness if system.symmetric else sparse.csr_matrix(0.5 * (stiffness + stiffness.T))
        self._hierarchy = _hierarchy(symmetric, system.rigid_motions)
        self._cycle = self._hierarchy.aspreconditioner(cycle="W")

    def approximate(self, vector: Array) -> Array:
        if self._coupling is None:
            return self._cycle @ vector
        multiplier = -vector[self._n :] / self._schur
        upper = self._cycle @ (vector[: self._n] - self._coupling @ multiplier)
        return np.concatenate([upper, multiplier])

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        return self.solve_near(self._system, vector, tolerance)[0]

    def solve_near(self, system: LinearSystem, vector: Array, tolerance: float) -> tuple[Array, int]:
        import scipy.sparse.linalg as sparse_linalg

        self._iterations = 0
        size = float(np.linalg.norm(vector))
        if size == 0.0:
            return np.zeros_like(vector), 0

        linear_operator: Any = sparse_linalg.LinearOperator  # its types know no matvec

        def product(inner: Array) -> Array:
            self._iterations += 1
            return system.times(self.approximate(inner))

        n = vector.size
        found = np.zeros(n)
        missed, rest = size, vector
        restart = min(self._solver.restart, n)
        while missed > tolerance * size and self._iterations < self._solver.max_iterations:
            room = min(restart, self._solver.max_iterations - self._iterations)
            operator: Any = linear_operator((n, n), matvec=product, dtype=np.float64)
            # One cycle a call: the residual that counts is computed afresh, not the one that was carried along.
            inner, _ = sparse_linalg.gmres(
                operator, rest, rtol=0.9 * tolerance * size / missed, atol=0.0, restart=room, maxiter=1
            )
            found = found + self.approximate(inner)
            rest = vector - system.times(found)
            before, missed = missed, float(np.linalg.norm(rest))
            if not missed < 0.9 * before:
                break
        if missed <= tolerance * size:
            return found, self._iterations
        raise UnsolvedSystem(
            f"amg_gmres left {missed / size:.1e} of the right side after {self._iterations} iterations, allowed is "
            f"{tolerance:.1e}. Near a limit point or for an unstable state take a direct solver (superlu, or pardiso "
            "or mumps where installed); else raise 'max_iterations' or 'restart'"
        )

    def inertia(self) -> Inertia | None:
        return judged(self._system, self._cycle)

    @property
    def worth(self) -> float:
        return _WORTH

    @property
    def iterations(self) -> int:
        return self._iterations

    def describe(self) -> str:
        levels = " > ".join(str(level.A.shape[0]) for level in self._hierarchy.levels)
        return f"amg_gmres, {self._system.n_unknowns} unknowns, levels {levels}"


def _schur_diagonal(system: LinearSystem, stiffness: Any, coupling: Any) -> Array:
    import scipy.sparse as sparse

    diagonal = np.abs(stiffness.diagonal())
    diagonal[diagonal == 0.0] = float(diagonal.max()) or 1.0
    products: Any = sparse.csr_array(coupling).multiply(sparse.csr_array(system.gradient))
    schur = np.abs(np.asarray(products @ (1.0 / diagonal)).ravel())
    if system.compliance is not None:
        schur = schur + np.abs(sparse.csr_array(system.compliance).diagonal())
    return schur


def _hierarchy(matrix: Any, rigid_motions: Array | None) -> Any:
    import pyamg

    # pyamg estimates spectral radii from random vectors of the global generator: the same ones every time.
    state = np.random.get_state()  # noqa: NPY002
    np.random.seed(0)  # noqa: NPY002
    try:
        return pyamg.smoothed_aggregation_solver(
            matrix, B=rigid_motions, max_coarse=_COARSEST, coarse_solver=_Coarsest(), improve_candidates=None
        )
    finally:
        np.random.set_state(state)  # noqa: NPY002


@final
class _Coarsest:
    """Solves on the coarsest level: Cholesky's factors, or a pseudo-inverse where it is not positive definite.

    pyamg's default is a pseudo-inverse by singular values: a third of the whole solve at 30 000 unknowns.
    """

    def __init__(self) -> None:
        self._inverse: Callable[[Array], Array] | None = None

    def __call__(self, matrix: Any, vector: Array) -> Array:
        if self._inverse is None:
            import scipy.linalg as linalg

            dense = matrix.toarray()
            try:
                factor = linalg.cho_factor(0.5 * (dense + dense.T), check_finite=False)
                self._inverse = lambda right: linalg.cho_solve(factor, right, check_finite=False)
            except linalg.LinAlgError:
                inverse = linalg.pinvh(0.5 * (dense + dense.T))
                self._inverse = lambda right: inverse @ right
        return self._inverse(vector)


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"amg_gmres": AmgGmres}
