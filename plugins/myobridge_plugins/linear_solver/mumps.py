"""MUMPS, where the package python-mumps is installed."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.solvers import Inertia, SingularMatrix
from myobridge_plugins.linear_solver.direct import DirectFactorisation, multifrontal_seconds

__all__ = ["Mumps"]

# MUMPS' own numbers of errors: singular in structure, singular in numbers.
_SINGULAR = (-6, -10)
# infog, counted from 1: negative pivots of a symmetric matrix, pivots that were replaced.
_NEGATIVE, _REPLACED = 12, 25


@final
@attrs.frozen
class Mumps(LinearSolver):
    r"""Multifrontal factors by MUMPS (Amestoy et al. [1]_), symmetric indefinite where the system is symmetric.

    .. math:: P A P^T = L D L^T \quad\text{or}\quad P A Q = L U

    Of a symmetric matrix MUMPS counts the negative pivots: the inertia.

    References
    ----------
    .. [1] P. R. Amestoy, I. S. Duff, J. Koster, J.-Y. L'Excellent, SIAM J. Matrix Anal. Appl. 23 (2001) 15-41.
    """

    tells_inertia: ClassVar[bool] = True
    summary: ClassVar[str] = "MUMPS where python-mumps is installed (conda, or built by hand); tells the inertia"

    def obstacle(self) -> str:
        # Another package, PyMUMPS, has the same name and another interface.
        if importlib.util.find_spec("mumps") is None or importlib.util.find_spec("mumps._mumps") is None:
            return "the package python-mumps is absent: conda install -c conda-forge python-mumps"
        return ""

    def seconds(self, size: SystemSize) -> float | None:
        pardiso = multifrontal_seconds(size)
        # As fast with a good BLAS; with the reference one two to four times slower.
        return None if pardiso is None else 1.1 * pardiso

    def factorise(self, system: LinearSystem) -> Factorisation:
        mumps: Any = importlib.import_module("mumps")
        import scipy.sparse as sparse

        whole: Any = sparse.csr_array(system.matrix())
        if not np.all(np.isfinite(whole.data)):
            raise SingularMatrix
        context = mumps.Context()
        context.set_matrix(sparse.coo_array(whole), symmetric=system.symmetric)
        try:
            context.factor()
        except mumps.MUMPSError as error:
            if error.error in _SINGULAR:
                raise SingularMatrix from None
            raise MemoryError(str(error)) from None
        told = context.mumps_instance.infog
        n = whole.shape[0]
        known = None
        if system.symmetric and told[_REPLACED] == 0:
            known = Inertia(int(told[_NEGATIVE]), 0, n - int(told[_NEGATIVE]))
        text = f"mumps, {n} unknowns, {context.factor_stats.nonzeros / 1e6:.3g} million entries in the factors"
        return DirectFactorisation(whole, lambda vector: np.asarray(context.solve(vector)), text, known)


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"mumps": Mumps}
