"""SuperLU, the sparse factors that scipy brings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.parameters import choice, number
from myobridge.solvers import SingularMatrix
from myobridge_plugins.linear_solver.direct import PRECISIONS, DirectFactorisation, in_single

__all__ = ["SuperLU"]

# Triangular solves that a factorisation is worth: so many, and so many for each entry of the factors in a row. As
# measured: 24 to 40 in the plane, 80 to 140 in space.
_WORTH = (30.0, 0.06)


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
    precision : {"double", "single"}
        Of the factors. Single takes half the memory and two thirds of the time; residuals stay double and what is
        missing is refined. A matrix that single precision cannot invert gets factors in double.
    pivot : float
        A diagonal pivot is taken where it is no smaller than this share of the largest in its column [-].

    References
    ----------
    .. [1] X. S. Li, ACM Trans. Math. Softw. 31 (2005) 302-325.
    """

    summary: ClassVar[str] = "sparse factors by SuperLU, always there; for the plane, and small bodies in space"

    precision: str = choice("double", PRECISIONS, doc="precision of the factors")
    pivot: float = number(0.01, within="[0, 1]", doc="smallest diagonal pivot, as a share of the largest of its column")

    def rough(self) -> LinearSolver:
        return attrs.evolve(self, precision="single")

    def seconds(self, size: SystemSize) -> float:
        # Rough powers, fitted so that this wins over amg_gmres up to 8 000 unknowns in space, 250 000 in the plane.
        return 0.75 * (size.n_unknowns / 8e3) ** 2 if size.dimension == 3 else 1.4 * (size.n_unknowns / 58e3) ** 1.5

    def factorise(self, system: LinearSystem) -> Factorisation:
        import scipy.sparse as sparse
        import scipy.sparse.linalg as sparse_linalg

        matrix: Any = sparse.csc_array(system.matrix())
        if not np.all(np.isfinite(matrix.data)):
            raise SingularMatrix
        order = _cellwise_order(system)
        rule = "MMD_AT_PLUS_A" if order is None else "NATURAL"
        ordered = matrix if order is None else sparse.csc_array(matrix[order][:, order])

        def prepared(*, single: bool) -> tuple[Callable[[Array], Array], int]:
            """The inverse, and the entries of its factors."""
            given = ordered.astype(np.float32) if single else ordered
            try:
                factors = sparse_linalg.splu(
                    given, permc_spec=rule, diag_pivot_thresh=self.pivot, options={"SymmetricMode": True}
                )
            except RuntimeError:  # SuperLU's word for a pivot that is zero
                raise SingularMatrix from None
            apply = in_single(factors.solve) if single else factors.solve

            def inverse(vector: Array) -> Array:
                if order is None:
                    return apply(vector)
                found = np.empty_like(vector)
                found[order] = apply(vector[order])
                return found

            return inverse, factors.nnz

        def factored(*, single: bool) -> Factorisation:
            inverse, entries = prepared(single=single)
            text = f"superlu, {matrix.shape[0]} unknowns, {entries / 1e6:.3g} million entries in the factors"
            text += " in single precision" if single else ""
            double = (lambda: prepared(single=False)[0]) if single else None
            worth = _WORTH[0] + _WORTH[1] * entries / matrix.shape[0]
            return DirectFactorisation(matrix, inverse, text, worth=worth, double=double)

        if self.precision == "single":
            try:
                return factored(single=True)
            except SingularMatrix:  # or only in single precision
                pass
        return factored(single=False)


def _cellwise_order(system: LinearSystem) -> np.ndarray | None:
    """Minimum degree of the stiffness, and each multiplier right after its last neighbour; None where that is no gain.

    It is one where the pressure lives in each cell alone, so that neighbours of a multiplier are neighbours of each
    other: then it fills in nothing, no pivot is zero when its turn comes, and none leaves the diagonal. Minimum degree
    on the whole matrix takes the multipliers too early: of Q2-P1disc the factors are seven times larger on 16 x 16
    cells, and ever more on finer meshes.
    """
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    if system.gradient is None or isinstance(system.stiffness, np.ndarray):
        return None
    gradient = sparse.csr_array(system.gradient)
    lengths = np.diff(gradient.indptr)
    local = gradient[lengths <= 4.0 * np.median(lengths)]  # not the row that a border adds
    pattern = _ones(sparse.csc_array(system.stiffness))
    together = _ones(local).T @ _ones(local)
    if (pattern + together).nnz > pattern.nnz:
        return None
    n = pattern.shape[0]
    definite = pattern + sparse.diags_array(pattern.sum(axis=0) + 1.0, format="csc")
    places = np.empty(system.n_unknowns)
    places[:n] = sparse_linalg.splu(
        definite, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).perm_c
    last = np.zeros(system.n_constraints)
    np.maximum.at(last, np.repeat(np.arange(last.size), lengths), places[gradient.indices])
    places[n:] = last + 0.5
    return np.argsort(places, kind="stable")


def _ones(matrix: Any) -> Any:
    """The pattern of a sparse matrix, every stored entry 1."""
    found = matrix.copy()
    found.data = np.ones_like(found.data)
    return found


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"superlu": SuperLU}
