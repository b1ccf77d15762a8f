"""Stability of an equilibrium: negative eigenvalues of its tangent beyond those of its constraints."""

from __future__ import annotations

from myobridge.errors import PluginError
from myobridge.interfaces import Factorisation, LinearSystem
from myobridge.solvers.choice import choice_for, choose, installed, size_of
from myobridge.solvers.inertia import Inertia, InertiaUnknown, inertia

__all__ = ["stability"]


def stability(system: LinearSystem, factorisation: Factorisation | None = None) -> int:
    r"""Number of unstable directions: negative eigenvalues of the saddle matrix beyond its ``n_constraints``.

    Asked first is the factorisation, which may have counted its pivots; then the solver that suits the system, where it
    tells the inertia: one that iterates may count fewer unstable directions than there are; else comes the proof by
    `inertia`.

    Parameters
    ----------
    system : LinearSystem
        Tangent at the equilibrium; of an unsymmetric one the symmetric part is judged.
    factorisation : Factorisation, optional
        Of this very system.

    Raises
    ------
    InertiaUnknown
        If nobody can tell at a bounded cost. To be reported as "not checked", never as stable.
    SingularMatrix
        If the system has no inverse and is too large for the proof.
    """
    known = None if factorisation is None else factorisation.inertia()
    if known is None:
        solver = choice_for(system).solver
        asked = solver is not None and solver.tells_inertia
        known = solver.factorise(system).inertia() if solver and asked else _proven(system)
    if known is None:
        raise InertiaUnknown(
            f"the eigenvalues of a system of {system.n_unknowns} unknowns were not counted: no factorisation that "
            "tells its inertia fits, and the iterations that look for a negative one did not settle. A direct solver "
            "that tells the inertia would (myobridge plugins lists them)"
        )
    return max(known.negative - system.n_constraints, 0)


def _proven(system: LinearSystem) -> Inertia | None:
    """Inertia by proof; where the factors grow too much for one, by a solver that tells it."""
    try:
        return inertia(system.matrix(), system.n_constraints)
    except InertiaUnknown as error:
        try:
            solver = choose(size_of(system), installed(telling_inertia=True)).solver
        except PluginError:
            raise error from None
    assert solver is not None
    return solver.factorise(system).inertia()
