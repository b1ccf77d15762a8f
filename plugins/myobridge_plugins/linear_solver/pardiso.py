"""PARDISO of Intel's MKL, where the package pypardiso is installed."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import weakref
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.parameters import choice
from myobridge.solvers import Inertia, SingularMatrix
from myobridge_plugins.linear_solver.direct import PRECISIONS, DirectFactorisation, in_single, multifrontal_seconds

__all__ = ["Pardiso"]

# Kinds of matrices, in PARDISO's numbers.
_SYMMETRIC, _GENERAL = -2, 11
_ANALYSE_AND_FACTORISE, _SOLVE, _RELEASE = 12, 33, -1
# iparm by PARDISO's own numbers, counted from 1: own values, nested dissection, refinements only after perturbed pivots
# (`DirectFactorisation` has its own), perturbation 1e-8, scaling, matching, 1x1 pivots. Without scaling and matching a
# saddle matrix of 26k rows had 152 perturbed pivots and a residual of 5e-9; with them 1x1 pivots are as good as 2x2
# ones, and a tenth to a third faster. A matrix that they do not suit has perturbed pivots: it gets 2x2 ones.
_SETTINGS = {1: 1, 2: 3, 8: 0, 10: 8, 11: 1, 13: 1, 21: 2}
_PAIRS = {**_SETTINGS, 21: 1}
# Triangular solves that a factorisation is worth: so many, and so many for each entry of the factors in a row. As
# measured: 25 to 45 in the plane, 70 to 120 in space.
_WORTH = (30.0, 0.06)
_GENERAL_SETTINGS = {**_SETTINGS, 10: 13}


@final
@attrs.frozen
class Pardiso(LinearSolver):
    r"""Multifrontal factors by PARDISO (Schenk and Gaertner [1]_), symmetric indefinite where the system is symmetric.

    .. math:: P A P^T = L D L^T \quad\text{or}\quad P A Q = L U

    Pivots are 1x1 or, where those are too small, 2x2, so that saddle matrices need no ordering of their own; their
    signs are the inertia.
    The phases are called one by one: pypardiso's own `solve` hashes the matrix at every call.

    Parameters
    ----------
    precision : {"double", "single"}
        Of the factors. Single takes half the memory and half the time; residuals stay double and what is missing is
        refined. A matrix that single precision cannot invert gets factors in double.

    References
    ----------
    .. [1] O. Schenk, K. Gaertner, Electron. Trans. Numer. Anal. 23 (2006) 158-179.
    """

    tells_inertia: ClassVar[bool] = True
    summary: ClassVar[str] = "PARDISO of Intel's MKL (pip install 'myobridge[pardiso]'); tells the inertia"

    precision: str = choice("double", PRECISIONS, doc="precision of the factors")

    def obstacle(self) -> str:
        if importlib.util.find_spec("pypardiso") is None:
            return "the package pypardiso is absent: pip install 'myobridge[pardiso]' (x86 only, MKL is proprietary)"
        return ""

    def rough(self) -> LinearSolver:
        return attrs.evolve(self, precision="single")

    def seconds(self, size: SystemSize) -> float | None:
        return multifrontal_seconds(size)

    def factorise(self, system: LinearSystem) -> Factorisation:
        import scipy.sparse as sparse

        whole: Any = sparse.csr_array(system.matrix())
        if not np.all(np.isfinite(whole.data)):
            raise SingularMatrix
        n = whole.shape[0]
        if system.symmetric:
            # A diagonal entry in every row, also where it is zero: sums of sparse arrays keep explicit zeros.
            upper: Any = sparse.triu(whole, format="coo")
            every = np.arange(n)
            rows, columns = (np.concatenate([held, every]) for held in upper.coords)
            values = np.concatenate([upper.data, np.zeros(n)])
            given: Any = sparse.csr_array(sparse.coo_array((values, (rows, columns)), shape=(n, n)))
        else:
            given = whole.copy()
            if not np.all(np.diff(given.indptr)):
                raise SingularMatrix  # an empty row makes PARDISO fall over
        given.sort_indices()
        kind = _SYMMETRIC if system.symmetric else _GENERAL
        if self.precision == "single":
            try:
                return _factored(given, kind, whole, single=True)
            except SingularMatrix:  # or only in single precision
                pass
        return _factored(given, kind, whole, single=False)


def _factored(given: Any, kind: int, whole: Any, *, single: bool) -> Factorisation:
    call = _factors(given, kind, single=single)
    n, known = whole.shape[0], None
    if kind == _SYMMETRIC and call.told(14) == 0 and not single:  # signs of small pivots are noise in single precision
        negative, positive = int(call.told(23)), int(call.told(22))
        known = Inertia(negative, n - negative - positive, positive)
    text = f"pardiso, {n} unknowns, {call.told(18) / 1e6:.3g} million entries in the factors"
    worth = _WORTH[0] + _WORTH[1] * call.told(18) / n
    if not single:
        return DirectFactorisation(whole, call.solve, text, known, worth=worth)

    def double() -> Callable[[Array], Array]:
        return _factors(given, kind, single=False).solve

    return DirectFactorisation(whole, in_single(call.solve), text + " in single precision", worth=worth, double=double)


def _factors(given: Any, kind: int, *, single: bool) -> _Call:
    """Factors with 1x1 pivots where that did, else with 2x2 ones."""
    call = _Call(given, _SETTINGS if kind == _SYMMETRIC else _GENERAL_SETTINGS, kind, single=single)
    try:
        call.run(_ANALYSE_AND_FACTORISE)
        if kind != _SYMMETRIC or call.told(14) == 0:
            return call
    except SingularMatrix:
        if kind != _SYMMETRIC:
            raise
    del call  # its memory first
    call = _Call(given, _PAIRS, kind, single=single)
    call.run(_ANALYSE_AND_FACTORISE)
    return call


class _Handle(NamedTuple):
    """What a call of PARDISO needs: function, type and array of its pointers, iparm, kind and rows, matrix."""

    function: Any
    pointer_type: Any
    pointers: Any
    settings: Any
    sizes: tuple[int, int]
    matrix: tuple[Any, ...]


def _call(handle: _Handle, phase: int, right: Array, found: Array) -> int:
    """One phase; PARDISO's error, 0 for none."""
    integer, integers = ctypes.c_int32, ctypes.POINTER(ctypes.c_int32)
    one, error = integer(1), integer(0)
    values, starts, columns, order = handle.matrix
    handle.function(
        handle.pointers.ctypes.data_as(ctypes.POINTER(handle.pointer_type)),
        ctypes.byref(one),
        ctypes.byref(one),
        ctypes.byref(integer(handle.sizes[0])),
        ctypes.byref(integer(phase)),
        ctypes.byref(integer(handle.sizes[1])),
        values.ctypes.data_as(ctypes.c_void_p),
        starts.ctypes.data_as(integers),
        columns.ctypes.data_as(integers),
        order.ctypes.data_as(integers),
        ctypes.byref(one),
        handle.settings.ctypes.data_as(integers),
        ctypes.byref(integer(0)),
        right.ctypes.data_as(ctypes.c_void_p),
        found.ctypes.data_as(ctypes.c_void_p),
        ctypes.byref(error),
    )
    return error.value


@functools.lru_cache(maxsize=1)
def _library() -> Any:
    """pypardiso's object, which searches the disk for MKL when it is made: half a second, a fifth of a solve."""
    from pypardiso import PyPardisoSolver  # pyright: ignore[reportMissingImports]

    return PyPardisoSolver()


@final
class _Call:
    """PARDISO's memory for one matrix, released with this object."""

    def __init__(self, matrix: Any, settings: dict[int, int], kind: int, *, single: bool) -> None:
        library = _library()
        self._function: Any = library._mkl_pardiso
        # Its arrays are copied: the object is shared.
        self._pointers, self._settings = np.zeros_like(library.pt), np.zeros_like(library.iparm)
        for index, value in settings.items():
            self._settings[index - 1] = value
        self._settings[17] = -1  # asks for the number of entries in the factors
        self._settings[27] = int(single)
        self._number: Any = np.float32 if single else np.float64
        self._pointer_type: Any = library._pt_type[0]
        self._kind, self._n = kind, matrix.shape[0]
        self._values = np.ascontiguousarray(matrix.data, dtype=self._number)
        self._starts = np.ascontiguousarray(matrix.indptr, dtype=np.int32) + 1
        self._columns = np.ascontiguousarray(matrix.indices, dtype=np.int32) + 1
        self._order = np.zeros(0, dtype=np.int32)
        self._nothing = np.zeros(self._n, dtype=self._number)
        self._matrix = (self._values, self._starts, self._columns, self._order)
        # Not bound to this object: the memory is released after it is gone.
        weakref.finalize(self, _call, self._handle(), _RELEASE, self._nothing, self._nothing)

    def _handle(self) -> _Handle:
        sizes = (self._kind, self._n)
        return _Handle(self._function, self._pointer_type, self._pointers, self._settings, sizes, self._matrix)

    def run(self, phase: int, right: Array | None = None, found: Array | None = None) -> None:
        nothing = self._nothing
        error = _call(self._handle(), phase, nothing if right is None else right, nothing if found is None else found)
        if error in (-4, -7):  # zero pivot; singular diagonal
            raise SingularMatrix
        if error:
            raise MemoryError(f"PARDISO ended phase {phase} with error {error} (-2 and -9: not enough memory)")

    def solve(self, vector: Array) -> Array:
        found = np.empty(self._n, dtype=self._number)
        self.run(_SOLVE, np.ascontiguousarray(vector, dtype=self._number), found)
        return found

    def told(self, index: int) -> int:
        """What PARDISO wrote at iparm(`index`), counted from 1."""
        return int(self._settings[index - 1])


@hookimpl
def myobridge_linear_solvers() -> dict[str, type[LinearSolver]]:
    return {"pardiso": Pardiso}
