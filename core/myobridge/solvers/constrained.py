r"""Mass and constraint together: what accelerations, impulses and projections of a constrained solid solve.

.. math:: \begin{pmatrix} M & B_1^T \\ B_2 & 0 \end{pmatrix} \begin{pmatrix} x \\ p \end{pmatrix}
          = \begin{pmatrix} b \\ r \end{pmatrix}, \qquad
          S\,p = B_2 M^{-1} b - r, \quad S = B_2 M^{-1} B_1^T, \quad x = M^{-1} (b - B_1^T p)

The mass is factored once for each solid. Of few constraints `S` is formed and factored; of many it is only applied:
conjugate gradients, preconditioned by a factor of :math:`B D^{-1} B^T` at the start of the motion, `D` the diagonal of
the mass. A rotation does not change it, and moderate deformations hardly, so that it serves a whole run; where it does
not, it is made anew for the one system. What was solved before plays no part: an interrupted run gives the same digits.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, final

import numpy as np

from myobridge.interfaces import Array, MacroSolid, Matrix
from myobridge.solvers.dense import DenseFactorisation
from myobridge.solvers.linear import UnsolvedSystem, mass_solver, solve
from myobridge.solvers.step import effective_mass

__all__ = ["ConstrainedMass", "diagonal_of"]

# Up to this many constraints S is formed, which takes a solve with the mass for each.
_FEW = 150
# Columns solved at a time: of more, the threads of BLAS cost several times what they save.
_BLOCK = 8
# Iterations after which the preconditioner of the start is given up, and those after which all is.
_MANY, _TOO_MANY = 80, 2000
# Relative residual of the multipliers unless another is asked for.
_TOLERANCE = 1e-13


@final
class ConstrainedMass:
    """Mass of a solid with the gradient of its constraint, ready to solve.

    Parameters
    ----------
    solid : MacroSolid
    gradient : matrix, shape (n_constraints, n_unknowns), or None
        B_2; None without constraint: the mass alone.
    acting : matrix, optional
        B_1, whose transpose acts on the multipliers; `gradient` unless given.
    inertance : ndarray, optional
        Of attached heads with mass [Pa s^2].
    """

    def __init__(
        self,
        solid: MacroSolid,
        gradient: Matrix | None,
        acting: Matrix | None = None,
        inertance: Array | None = None,
    ) -> None:
        self._solid, self._inertance = solid, inertance
        self._gradient = gradient
        self._acting = gradient if acting is None else acting
        self._count = 0 if gradient is None else int(gradient.shape[0])
        self._few = self._count <= _FEW
        self._formed: tuple[Array, DenseFactorisation] | None = None
        if isinstance(gradient, np.ndarray) and not self._few:
            import scipy.sparse as sparse

            self._gradient = sparse.csr_array(gradient)
            self._acting = self._gradient if acting is None else sparse.csr_array(acting)

    def inverse(self, force: Array) -> Array:
        """The inverse of the mass alone times a vector."""
        if self._inertance is None:
            return mass_solver(self._solid)(force)
        mass = effective_mass(self._solid, self._inertance)
        return force / mass if mass.ndim == 1 else solve(mass, force)

    def solve(self, force: Array, rate: Array | float = 0.0, tolerance: float = _TOLERANCE) -> tuple[Array, Array]:
        """`x` and `p` for the right-hand sides `force` and `rate`.

        Parameters
        ----------
        tolerance : float
            Residual of the multipliers, relative to their right-hand side.

        Raises
        ------
        UnsolvedSystem
            If the iteration does not reach it.
        SingularMatrix
            If the gradient has not full rank.
        """
        gradient, acting = self._gradient, self._acting
        if gradient is None or acting is None:
            return self.inverse(force), np.empty(0)
        free = self.inverse(force)
        right = gradient @ free - rate
        if self._few:
            way, schur = self._schur(gradient, acting)
            multiplier = schur.solve(right)
            return free - way @ multiplier, multiplier
        multiplier = self._multiplier(right, tolerance)
        return free - self.inverse(acting.T @ multiplier), multiplier

    # ------------------------------------------------------------------ inside

    def _schur(self, gradient: Matrix, acting: Matrix) -> tuple[Array, DenseFactorisation]:
        """M^-1 B_1^T and the factors of S."""
        if self._formed is None:
            columns = np.ascontiguousarray(_dense(acting).T)
            mass = effective_mass(self._solid, self._inertance)
            if isinstance(mass, np.ndarray) and mass.ndim == 1:
                way = columns / mass[:, None]
            else:
                blocks = np.array_split(columns, np.arange(_BLOCK, self._count, _BLOCK), axis=1)
                way = np.concatenate([self.inverse(np.asfortranarray(block)) for block in blocks], axis=1)
            self._formed = way, DenseFactorisation(np.asarray(gradient @ way))
        return self._formed

    def _multiplier(self, right: Array, tolerance: float) -> Array:
        """Solution of S p = right."""
        gradient, acting = self._gradient, self._acting
        assert gradient is not None
        assert acting is not None
        transposed = acting.T.tocsr() if hasattr(acting, "tocsr") else acting.T

        def times(multiplier: Array) -> Array:
            return gradient @ self.inverse(transposed @ multiplier)

        method = _conjugate_gradients if acting is gradient else _generalised_residuals
        found = method(times, right, _start_factor(self._solid), tolerance, _MANY)
        if found is None:
            found = method(times, right, _factor(self._solid, gradient), tolerance, _TOO_MANY)
        if found is None:
            raise UnsolvedSystem(
                f"the multipliers of {right.size} constraints were not found in {_TOO_MANY} iterations"
            )
        return found


def _conjugate_gradients(
    times: Callable[[Array], Array], right: Array, near: Callable[[Array], Array], tolerance: float, most: int
) -> Array | None:
    """Conjugate gradients from zero, preconditioned by `near`; None where they take more than `most` iterations."""
    found, residual = np.zeros_like(right), right.copy()
    enough = tolerance * float(np.linalg.norm(right))
    if enough == 0.0:
        return found
    if not np.isfinite(enough):
        return None
    nearer = near(residual)
    direction, product = nearer, float(residual @ nearer)
    for _ in range(most):
        image = times(direction)
        step = product / float(direction @ image)
        found += step * direction
        residual -= step * image
        if float(np.linalg.norm(residual)) <= enough:
            return found
        nearer = near(residual)
        product, before = float(residual @ nearer), product
        direction = nearer + (product / before) * direction
    return None


def _generalised_residuals(
    times: Callable[[Array], Array], right: Array, near: Callable[[Array], Array], tolerance: float, most: int
) -> Array | None:
    """GMRES, for two different gradients."""
    import scipy.sparse.linalg as sparse_linalg

    size = (right.size, right.size)
    found, failed = sparse_linalg.gmres(
        sparse_linalg.LinearOperator(size, matvec=times, dtype=np.float64),  # pyright: ignore[reportCallIssue]
        right,
        rtol=tolerance,
        restart=min(most, right.size, 100),
        maxiter=max(1, most // 100),
        M=sparse_linalg.LinearOperator(size, matvec=near, dtype=np.float64),  # pyright: ignore[reportCallIssue]
    )
    # It stalls in the last digits; what it has then is as good as it gets.
    close = float(np.linalg.norm(times(found) - right)) <= max(10.0 * tolerance, 1e-11) * float(np.linalg.norm(right))
    return found if not failed or close else None


@functools.lru_cache(maxsize=8)
def _start_factor(solid: MacroSolid) -> Callable[[Array], Array]:
    """Factor at the start of the motion; its position is given as it is, violated constraint or not."""
    gradient = solid.balance(solid.rest_motion(), None, 0.0, rate=False, tangent=True).constraint_gradient
    return _factor(solid, gradient)


def _factor(solid: MacroSolid, gradient: Any) -> Callable[[Array], Array]:
    """Inverse of B D^-1 B^T."""
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    rows = sparse.csr_array(gradient)
    scaled = rows @ sparse.diags_array(1.0 / diagonal_of(solid.mass_matrix))
    options = {"SymmetricMode": True}
    factor = sparse_linalg.splu(
        sparse.csc_array(scaled @ rows.T), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
    )
    return factor.solve


def diagonal_of(mass: Matrix) -> Array:
    """Diagonal of a mass matrix, lumped or not."""
    return mass if isinstance(mass, np.ndarray) and mass.ndim == 1 else np.asarray(mass.diagonal())


def _dense(matrix: Any) -> Array:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
