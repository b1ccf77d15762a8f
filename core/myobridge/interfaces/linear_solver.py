r"""Linear solver: the systems of Newton's method, plain or with a constraint.

.. math:: \begin{pmatrix} K & B_1^T \\ B_2 & -C \end{pmatrix} \begin{pmatrix} x_u \\ x_p \end{pmatrix} = b

`K` stiffness, `B` gradient of the constraint (two of them where force and constraint are taken at different points of a
step), `C` compliance of the constraint, zero for strict incompressibility.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import attrs

from myobridge.interfaces.active_law import Array
from myobridge.interfaces.motion import Matrix

if TYPE_CHECKING:
    from myobridge.solvers.inertia import Inertia

__all__ = ["Factorisation", "LinearSolver", "LinearSystem", "SystemSize"]


class SystemSize(NamedTuple):
    """What a solver is told before there is a matrix: unknowns with multipliers, and 2 or 3 for the dimension.

    `structured`: whether the fields and their rigid motions are known; without, iterations have nothing to stand on.
    """

    n_unknowns: int
    dimension: int
    structured: bool = True


@attrs.frozen(eq=False)
class LinearSystem:
    """System of one field or two.

    Attributes
    ----------
    stiffness : matrix, shape (n_u, n_u)
        K, dense or sparse.
    transposed_gradient, gradient : matrix, shape (n_p, n_u), or None
        B_1, whose transpose acts on the multipliers, and B_2; None for one field.
    compliance : matrix, shape (n_p, n_p), or None
        C, positive semi-definite; None where it is zero.
    rigid_motions : ndarray, shape (n_u, k), or None
        Displacements that deform nothing, translations first, restricted to the unknowns: what algebraic multigrid
        must know.
    symmetric : bool
        Whether the matrix is symmetric.
    """

    stiffness: Matrix
    transposed_gradient: Matrix | None = None
    gradient: Matrix | None = None
    compliance: Matrix | None = None
    rigid_motions: Array | None = None
    symmetric: bool = True

    @property
    def n_unknowns(self) -> int:
        """Displacements and multipliers."""
        return self.stiffness.shape[0] + (0 if self.gradient is None else self.gradient.shape[0])

    @property
    def n_constraints(self) -> int:
        """Multipliers: a stable state has exactly as many negative eigenvalues."""
        return 0 if self.gradient is None else self.gradient.shape[0]

    def matrix(self) -> Any:
        """The whole matrix: dense where K is dense and alone, else a sparse array (CSC)."""
        from myobridge.solvers.linear import saddle

        return saddle(self)

    def times(self, vector: Array) -> Array:
        """Product with a vector, without forming the matrix."""
        import numpy as np

        n = self.stiffness.shape[0]
        upper = self.stiffness @ vector[:n]
        if self.gradient is None or self.transposed_gradient is None:
            return upper
        lower = self.gradient @ vector[:n]
        if self.compliance is not None:
            lower = lower - self.compliance @ vector[n:]
        return np.concatenate([upper + self.transposed_gradient.T @ vector[n:], lower])


class Factorisation(ABC):
    """What a solver prepared for one matrix."""

    @abstractmethod
    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        """Solution to the relative residual `tolerance`; direct solvers do what they can and check.

        Raises
        ------
        UnsolvedSystem
            If the residual is not reached; never a wrong answer.
        """

    def solve_near(self, system: LinearSystem, vector: Array, tolerance: float) -> tuple[Array, int]:
        """Solution for another system, near the one that this was prepared for, and applications that it took.

        Raises
        ------
        UnsolvedSystem
            If the residual is not reached within `worth` applications: then a new factorisation is the cheaper way.
        """
        from myobridge.solvers.fgmres import fgmres

        return fgmres(system.times, self.approximate, vector, tolerance, max(int(self.worth), 20))

    def approximate(self, vector: Array) -> Array:
        """One application of what was prepared, as it is: factors without refinement, one cycle of multigrid.

        Linear in the vector: what iterations on another system use as preconditioner.
        """
        return self.solve(vector)

    @property
    def worth(self) -> float:
        """How many applications (`approximate`) cost as much as all the preparation, roughly.

        Never measured by a clock: what a method decides by it must not depend on the load of the machine.
        """
        return 50.0

    @property
    def iterations(self) -> int:
        """Iterations that the last solve took; 0 for a direct solver on its own system."""
        return 0

    def inertia(self) -> Inertia | None:
        """Signs of the eigenvalues where the factorisation knows them; None where it does not.

        A solver that iterates may count fewer negative ones than there are, but not miss that there are some.
        """
        return None

    def describe(self) -> str:
        """Which solver this is, how large it has become, and why it was chosen, in a line."""
        return type(self).__name__


class LinearSolver(ABC):
    """Abstract linear solver; its settings are the attributes of a frozen class.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    tells_inertia : bool
        Whether its factorisations know the signs of the eigenvalues, or look for them.
    direct : bool
        Whether it factors; one that iterates wants the true system, and no second one to iterate on.
    """

    summary: ClassVar[str] = ""
    tells_inertia: ClassVar[bool] = False
    direct: ClassVar[bool] = True

    @abstractmethod
    def factorise(self, system: LinearSystem) -> Factorisation:
        """Prepare for solves with one matrix.

        Raises
        ------
        SingularMatrix
            If it has no inverse.
        """

    def rough(self) -> LinearSolver:
        """The same solver for factors that need not be exact, as those of a kept tangent: in single precision, say."""
        return self

    def seconds(self, size: SystemSize) -> float | None:
        """Roughly, CPU seconds of one system of this size; None where the solver is not for it.

        Where a scene names no solver the cheapest is taken: what counts is where the solvers cross.
        """
        return None

    def obstacle(self) -> str:
        """Why the solver cannot be used on this machine (a package that is missing); empty where it can."""
        return ""
