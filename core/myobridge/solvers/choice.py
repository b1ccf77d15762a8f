"""Which linear solver: the cheapest of those that are installed, by what each says of a system of this size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple, final

import attrs
import numpy as np

from myobridge.errors import PluginError
from myobridge.interfaces import Array, Factorisation, LinearSolver, LinearSystem, MacroSolid, Matrix, SystemSize
from myobridge.solvers.dense import DenseFactorisation
from myobridge.solvers.inertia import Inertia
from myobridge.work import count

__all__ = [
    "Automatic",
    "Choice",
    "choice_for",
    "choice_of",
    "choose",
    "factorise",
    "installed",
    "size_of",
    "size_of_solid",
]

# Below this size LAPACK on the whole matrix costs less than any analysis of its pattern.
_DENSE = 120


class Choice(NamedTuple):
    """Name of a solver, the reason for it in words, and the solver; None where LAPACK does it, without a plugin."""

    name: str
    reason: str
    solver: LinearSolver | None = None


def choose(size: SystemSize, solvers: Mapping[str, LinearSolver] | None = None) -> Choice:
    """The solver for systems of this size: the one that says that it takes the least time.

    Parameters
    ----------
    solvers : mapping, optional
        Solvers by name; by default those that are registered and have no obstacle.

    Raises
    ------
    PluginError
        If none is for such a system.
    """
    told = {name: (one, one.seconds(size)) for name, one in (installed() if solvers is None else solvers).items()}
    costs = sorted((cost, name) for name, (_, cost) in told.items() if cost is not None)
    said = f"{size.n_unknowns} unknowns in {size.dimension}D"
    if not costs:
        raise PluginError(f"no installed linear solver is for a system of {said}; see 'myobridge plugins'")
    cost, name = costs[0]
    reason = f"{said}: about {cost:.2g} s a system"
    if len(costs) > 1:
        reason += f", {costs[1][1]} {costs[1][0]:.2g} s"
    return Choice(name, reason, told[name][0])


def choice_for(system: LinearSystem) -> Choice:
    """The solver for this system: "dense" (LAPACK, no plugin) or a registered one."""
    n = system.n_unknowns
    whole = isinstance(system.stiffness, np.ndarray) and system.gradient is None
    if n <= _DENSE or whole:
        return Choice("dense", f"{n} unknowns" + (", all coupled" if n > _DENSE else ""))
    return choose(size_of(system))


def choice_of(solid: MacroSolid) -> Choice:
    """The solver for the tangents of a solid, before there is one."""
    size = size_of_solid(solid)
    return Choice("dense", f"{size.n_unknowns} unknowns") if size.n_unknowns <= _DENSE else choose(size)


def size_of_solid(solid: MacroSolid) -> SystemSize:
    """Size of the tangents of a solid, before there is one."""
    motions = solid.rigid_motions()
    n = solid.n_unknowns + solid.rest_motion().multiplier.size
    return SystemSize(n, 3 if motions is not None and motions.shape[1] > 3 else 2, structured=motions is not None)


def size_of(system: LinearSystem) -> SystemSize:
    """Size of a system, as a solver is asked about it."""
    return SystemSize(system.n_unknowns, _dimension(system), structured=system.rigid_motions is not None)


def installed(*, telling_inertia: bool = False) -> dict[str, LinearSolver]:
    """Registered solvers that can be used here, by name; if wanted those only that tell the inertia."""
    from myobridge.registry import registry

    found = registry()
    built = {name: found.find("linear_solver", name).cls() for name in found.names("linear_solver")}
    return {
        name: one for name, one in built.items() if not one.obstacle() and (one.tells_inertia or not telling_inertia)
    }


@final
@attrs.frozen
class Automatic(LinearSolver):
    """The solver that suits each system.

    Parameters
    ----------
    roughly : bool
        Factors that need not be exact (`LinearSolver.rough`).
    """

    summary: ClassVar[str] = "the solver that suits the size of the system and the packages that are installed"

    roughly: bool = False

    def rough(self) -> LinearSolver:
        return Automatic(roughly=True)

    def factorise(self, system: LinearSystem) -> Factorisation:
        _, reason, solver = choice_for(system)
        if solver is None:
            return DenseFactorisation(_dense(system.matrix()), symmetric=system.symmetric)
        return _Chosen((solver.rough() if self.roughly else solver).factorise(system), reason)


@final
class _Chosen(Factorisation):
    """A factorisation that knows why it was chosen."""

    def __init__(self, inner: Factorisation, reason: str) -> None:
        self._inner, self._reason = inner, reason

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        return self._inner.solve(vector, tolerance)

    def solve_near(self, system: LinearSystem, vector: Array, tolerance: float) -> tuple[Array, int]:
        return self._inner.solve_near(system, vector, tolerance)

    def approximate(self, vector: Array) -> Array:
        return self._inner.approximate(vector)

    @property
    def worth(self) -> float:
        return self._inner.worth

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
    count("factorisations")
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
