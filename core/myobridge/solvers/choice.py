"""Which linear solver: chosen by what is installed and by how much the factors of the matrix would fill in."""

from __future__ import annotations

from typing import ClassVar, NamedTuple, final

import attrs
import numpy as np

from myobridge.errors import PluginError
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, MacroSolid, Matrix
from myobridge.solvers.dense import DenseFactorisation
from myobridge.solvers.inertia import Inertia

__all__ = ["Automatic", "Choice", "choice_for", "choice_of", "choose", "factorise"]

# Below this size LAPACK on the whole matrix costs less than any analysis of its pattern.
_DENSE = 120
# Unknowns above which MUMPS and PARDISO, where present, win over SuperLU.
_SMALL = 2_000
# Unknowns beyond which the factors of any solver take more than 8 GB.
_FACTORS = {2: 2_000_000, 3: 120_000}
# Unknowns up to which SuperLU wins over AMG-GMRES, in the plane and in space.
_SUPERLU = {2: 250_000, 3: 8_000}


class Choice(NamedTuple):
    """Name of a registered solver, and the reason for it in words."""

    name: str
    reason: str


def choose(
    n_unknowns: int, dimension: int, available: frozenset[str] | None = None, *, structured: bool = True
) -> Choice:
    """The solver for systems of this size.

    Parameters
    ----------
    n_unknowns : int
        Displacements and multipliers.
    dimension : int
        2 or 3: in space factors fill in far more.
    available : frozenset of str, optional
        Names of solvers that can be used; by default those that are registered and have no obstacle.
    structured : bool
        Whether the fields and their rigid motions are known; without, iterations have nothing to stand on.
    """
    present = _available() if available is None else available
    size = f"{n_unknowns} unknowns in {dimension}D"
    if _SMALL < n_unknowns <= _FACTORS[dimension] or not structured:
        for name, package in (("pardiso", "pypardiso"), ("mumps", "python-mumps")):
            if name in present:
                return Choice(name, f"{size}, and {package} is installed")
    limit = _SUPERLU[dimension]
    if n_unknowns <= limit:
        return Choice("superlu", f"{size}, direct up to {limit}")
    if not structured or "amg_gmres" not in present:
        return Choice("superlu", f"{size}: without its rigid motions no iterative solver suits the matrix")
    return Choice("amg_gmres", f"{size}: beyond {limit} factors cost more than iterations")


def choice_for(system: LinearSystem) -> Choice:
    """The solver for this system: "dense" (LAPACK, no plugin) or a registered one."""
    n = system.n_unknowns
    whole = isinstance(system.stiffness, np.ndarray) and system.gradient is None
    if n <= _DENSE or whole:
        return Choice("dense", f"{n} unknowns" + (", all coupled" if n > _DENSE else ""))
    return choose(n, _dimension(system), structured=system.rigid_motions is not None)


def choice_of(solid: MacroSolid) -> Choice:
    """The solver for the tangents of a solid, before there is one."""
    n = solid.n_unknowns + solid.rest_motion().multiplier.size
    motions = solid.rigid_motions()
    if n <= _DENSE:
        return Choice("dense", f"{n} unknowns")
    if motions is None:
        return choose(n, 2, structured=False)
    return choose(n, 3 if motions.shape[1] > 3 else 2)


@final
@attrs.frozen
class Automatic(LinearSolver):
    """The solver that suits each system."""

    summary: ClassVar[str] = "the solver that suits the size of the system and the packages that are installed"

    def factorise(self, system: LinearSystem) -> Factorisation:
        name, reason = choice_for(system)
        if name == "dense":
            return DenseFactorisation(_dense(system.matrix()), symmetric=system.symmetric)
        from myobridge.registry import registry

        return _Chosen(registry().find("linear_solver", name).cls().factorise(system), reason)


@final
class _Chosen(Factorisation):
    """A factorisation that knows why it was chosen."""

    def __init__(self, inner: Factorisation, reason: str) -> None:
        self._inner, self._reason = inner, reason

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        return self._inner.solve(vector, tolerance)

    @property
    def iterations(self) -> int:
        return self._inner.iterations

    def inertia(self) -> Inertia | None:
        return self._inner.inertia()

    def describe(self) -> str:
        return f"{self._inner.describe()} (chosen for {self._reason})"


def factorise(tangent: Matrix | LinearSystem, linear: LinearSolver | None = None) -> Factorisation:
    """Prepare for solves with a matrix or a system; with `linear` None by the solver that suits it.

    Raises
    ------
    SingularMatrix
        If it has no inverse.
    PluginError
        If the solver cannot be used on this machine.
    """
    if linear is not None and (obstacle := linear.obstacle()):
        raise PluginError(f"linear solver {type(linear).__name__}: {obstacle}")
    system = tangent if isinstance(tangent, LinearSystem) else LinearSystem(tangent, symmetric=False)
    return (linear or Automatic()).factorise(system)


def _dense(matrix: Matrix) -> Array:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def _dimension(system: LinearSystem) -> int:
    """2 or 3: from the rigid motions where they are given, else from the length of the rows.

    Quadratic elements couple about 21 unknowns to a row in the plane, and 50 to 80 in space.
    """
    if system.rigid_motions is not None:
        return 3 if system.rigid_motions.shape[1] > 3 else 2
    stiffness = system.stiffness
    entries = stiffness.size if isinstance(stiffness, np.ndarray) else stiffness.nnz
    return 3 if entries > 35 * stiffness.shape[0] else 2


def _available() -> frozenset[str]:
    from myobridge.registry import registry

    found = registry()
    names = found.names("linear_solver")
    return frozenset(name for name in names if not found.find("linear_solver", name).cls().obstacle())
