r"""Stability of systems too large to factorise: the smallest eigenvalues of the stiffness where the constraint holds.

.. math:: P^T K P x = \mu\, D x, \qquad P = I - D^{-1} B^T (B D^{-1} B^T)^{-1} B, \qquad D = \mathrm{diag}(K)

A saddle matrix without compliance has ``n_p`` negative eigenvalues and one for each negative :math:`\mu`. LOBPCG
(Knyazev [1]_) with one cycle of multigrid as preconditioner finds the smallest few at the cost of one or two linear
solves. A negative Rayleigh quotient *proves* an unstable direction; there may be more than are counted. That none is
found proves nothing, but it is what is said once the smallest value, which can only fall, is positive and has settled;
the start is random, so that no direction is left out.

References
----------
.. [1] A. V. Knyazev, SIAM J. Sci. Comput. 23 (2001) 517-541.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from myobridge.interfaces import Array, LinearSystem
from myobridge.solvers import Inertia

__all__ = ["judged"]

# Vectors that are iterated together, and how often.
_BLOCK, _ITERATIONS, _ROUNDS = 4, 20, 6
# A smallest value that is positive, and has fallen by no more than this in a round, stays positive.
_SETTLED = 0.98
# Eigenvalues of the scaled stiffness below this are zero: the largest are of the order of 10.
_ROUND_OFF = 1e-11


def judged(system: LinearSystem, cycle: Any) -> Inertia | None:
    """Inertia of a system with a preconditioner `cycle` of its stiffness; None where the iterations do not settle.

    With compliance, instability where the constraint holds is instability; that none is found there says nothing.
    """
    import scipy.linalg as linalg
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    stiffness: Any = sparse.csr_array(system.stiffness)
    if not system.symmetric:
        if system.gradient is not system.transposed_gradient:
            return None
        stiffness = sparse.csr_array(0.5 * (stiffness + stiffness.T))
    n = stiffness.shape[0]
    scale = np.abs(stiffness.diagonal())
    scale[scale == 0.0] = float(scale.max()) or 1.0
    project, pulled = _projections(system.gradient, scale)

    def product(block: Array) -> Array:
        inside = project(block)
        # What leaves the constraint by round-off must not pass for an eigenvalue that is zero.
        outside = scale[:, None] * (block - inside)
        return pulled(stiffness @ inside) + outside - pulled(outside)

    def precondition(block: Array) -> Array:
        right = pulled(block)
        return project(np.column_stack([cycle @ column for column in right.T]))

    linear_operator: Any = sparse_linalg.LinearOperator  # its types know no matvec

    def operator(function: Any) -> Any:
        return linear_operator(
            (n, n), matvec=lambda x: function(x.reshape(n, 1)).ravel(), matmat=function, dtype=np.float64
        )

    vectors = project(np.random.default_rng(0).standard_normal((n, _BLOCK)))
    metric = sparse.diags_array(scale)
    before = np.inf
    for _ in range(_ROUNDS):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it complains of a tolerance that is not wanted
            _, vectors = sparse_linalg.lobpcg(
                operator(product),
                vectors,
                B=metric,
                M=operator(precondition),
                tol=0.0,
                maxiter=_ITERATIONS,
                largest=False,
            )
        # Rayleigh and Ritz once more, where the constraint holds to round-off: this is what is counted.
        vectors = project(vectors)
        forces = stiffness @ vectors
        values, turned = linalg.eigh(vectors.T @ forces, vectors.T @ (scale[:, None] * vectors))
        vectors = vectors @ turned
        if values[0] < -_ROUND_OFF or (values[0] > _ROUND_OFF and values[0] > _SETTLED * before):
            break
        before = float(values[0])
    else:
        return None
    negative = int(np.sum(values < -_ROUND_OFF))
    if negative == 0 and system.compliance is not None:
        return None
    m = system.n_constraints
    return Inertia(m + negative, 0, n - negative)


def _projections(gradient: Any, scale: Array) -> tuple[Any, Any]:
    """The projection on the constraint, and its transpose, for blocks of vectors."""
    if gradient is None:
        return (lambda block: block), (lambda block: block)
    import scipy.sparse as sparse
    import scipy.sparse.linalg as sparse_linalg

    rows: Any = sparse.csr_array(gradient)
    columns: Any = sparse.csr_array(rows.T)
    schur = sparse.csc_array(rows @ sparse.diags_array(1.0 / scale) @ columns)
    solve = sparse_linalg.splu(schur, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve

    def project(block: Array) -> Array:
        return block - (columns @ solve(np.ascontiguousarray(rows @ block))) / scale[:, None]

    def pulled(block: Array) -> Array:
        return block - columns @ solve(np.ascontiguousarray(rows @ (block / scale[:, None])))

    return project, pulled
