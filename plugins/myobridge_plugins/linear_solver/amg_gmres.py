"""GMRES with algebraic multigrid, for systems whose factors would not fit."""

from __future__ import annotations

from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.parameters import integer
from myobridge.solvers import Inertia, SingularMatrix, UnsolvedSystem
from myobridge.solvers.fgmres import smallest_residual
from myobridge_plugins.linear_solver.multigrid import cycle_of
from myobridge_plugins.linear_solver.smallest_eigenvalues import judged

__all__ = ["AmgGmres"]

# Cycles that the hierarchy is worth: 25 to 40 as measured, but an old one is worse than it was from step to step.
_WORTH = 20.0
# Weight of the diagonal that stands for the Schur complement: for P2-P1 it is about twice too large.
_SCHUR = 0.5


@final
@attrs.frozen
class AmgGmres(LinearSolver):
    r"""Right-preconditioned GMRES; block-triangular preconditioner with one cycle of multigrid on the stiffness.

    .. math:: \begin{pmatrix} K & B_1^T \\ B_2 & -C \end{pmatrix} M^{-1} y = b, \quad x = M^{-1} y, \qquad
              M = \begin{pmatrix} \hat K & B_1^T \\ 0 & -\hat S \end{pmatrix}, \quad
              \hat S = 2\,\mathrm{diag}\bigl(B_2\,\mathrm{diag}(K)^{-1} B_1^T + C\bigr)

    with :math:`\hat K` smoothed aggregation (`multigrid`) of the symmetric part of `K`, which is told the rigid
    motions. Preconditioned from the right, the residual that GMRES minimises is the true one. Its iterations hardly
    grow with the mesh, its memory is that of the matrix and of two vectors for each iteration up to `restart`.
    The inertia is looked for and not proven (`smallest_eigenvalues`); a matrix that is singular shows itself by
    iterations that do not end.

    Parameters
    ----------
    restart : int
        Iterations between restarts: twice as many vectors are kept.
    max_iterations : int
        After which the system is given up.

    References
    ----------
    .. [1] H. Elman, D. Silvester, A. Wathen, Finite Elements and Fast Iterative Solvers (2014), chapter 4.
    """

    tells_inertia: ClassVar[bool] = True
    direct: ClassVar[bool] = False
    summary: ClassVar[str] = "GMRES with algebraic multigrid (pyamg), for large bodies in space"

    restart: int = integer(100, within="[10, inf)", doc="iterations between restarts of GMRES")
    max_iterations: int = integer(400, within="[1, inf)", doc="iterations after which a system is given up")

    def seconds(self, size: SystemSize) -> float | None:
        if not size.structured:
            return None
        # In space one system takes less, 0.45 s at 8 000 unknowns. But factors are worth keeping: they tell the inertia
        # and serve many steps, so that what is said is where iterations pay all the same.
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
        self._cycle = cycle_of(symmetric, system.rigid_motions)

    def approximate(self, vector: Array) -> Array:
        if self._coupling is None:
            return self._cycle @ vector
        multiplier = -vector[self._n :] / self._schur
        upper = self._cycle @ (vector[: self._n] - self._coupling @ multiplier)
        return np.concatenate([upper, multiplier])

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        return self.solve_near(self._system, vector, tolerance)[0]

    def solve_near(self, system: LinearSystem, vector: Array, tolerance: float) -> tuple[Array, int]:
        self._iterations = 0
        size = float(np.linalg.norm(vector))
        if size == 0.0:
            return np.zeros_like(vector), 0
        found = np.zeros(vector.size)
        missed, rest = size, vector
        while missed > tolerance * size and self._iterations < self._solver.max_iterations:
            room = min(self._solver.restart, self._solver.max_iterations - self._iterations)
            change, done = smallest_residual(system.times, self.approximate, rest, 0.9 * tolerance * size, room)
            self._iterations += done
            found = found + change
            # Computed afresh after each cycle: the residual that was carried along knows nothing of its own round-off.
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
        levels = " > ".join(str(size) for size in self._cycle.sizes)
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


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"amg_gmres": AmgGmres}
