"""SuperLU, the sparse factors that scipy brings."""

from __future__ import annotations

from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Factorisation, LinearSolver, LinearSystem
from myobridge.parameters import number
from myobridge.solvers import SingularMatrix
from myobridge_plugins.linear_solver.direct import DirectFactorisation

__all__ = ["SuperLU"]


@final
@attrs.frozen
class SuperLU(LinearSolver):
    r"""Sparse factors by SuperLU (Li [1]_), ordered by minimum degree.

    .. math:: P_r A P_c = L U

    The pattern of a tangent is symmetric, also where its values are not: minimum degree on the pattern of
    :math:`A + A^T` and pivots on the diagonal wherever they are not tiny. For P2-P1 saddle matrices that fills in a
    quarter to a half less than the default of scipy (column minimum degree, partial pivoting), and twenty times less
    than minimum degree with partial pivoting: a pivot off the diagonal spoils the order.

    Parameters
    ----------
    pivot : float
        A diagonal pivot is taken where it is no smaller than this share of the largest in its column [-].

    References
    ----------
    .. [1] X. S. Li, ACM Trans. Math. Softw. 31 (2005) 302-325.
    """

    summary: ClassVar[str] = "sparse factors by SuperLU, always there; for the plane, and small bodies in space"

    pivot: float = number(0.01, within="[0, 1]", doc="smallest diagonal pivot, as a share of the largest of its column")

    def factorise(self, system: LinearSystem) -> Factorisation:
        import scipy.sparse as sparse
        import scipy.sparse.linalg as sparse_linalg

        matrix: Any = sparse.csc_array(system.matrix())
        if not np.all(np.isfinite(matrix.data)):
            raise SingularMatrix
        try:
            factors = sparse_linalg.splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=self.pivot, options={"SymmetricMode": True}
            )
        except RuntimeError:  # SuperLU's word for a pivot that is zero
            raise SingularMatrix from None
        text = f"superlu, {matrix.shape[0]} unknowns, {factors.nnz / 1e6:.3g} million entries in the factors"
        return DirectFactorisation(matrix, factors.solve, text)


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"superlu": SuperLU}
