"""Stability of an equilibrium: negative eigenvalues of its tangent beyond those of its constraints."""

from __future__ import annotations

from myobridge.interfaces import Factorisation, LinearSystem
from myobridge.solvers.choice import choice_for, factorise
from myobridge.solvers.inertia import Inertia, InertiaUnknown, inertia

__all__ = ["stability"]


def stability(system: LinearSystem, factorisation: Factorisation | None = None) -> int:
    r"""Number of unstable directions: negative eigenvalues of the saddle matrix beyond its ``n_constraints``.

    Asked first is the factorisation, which may have counted its pivots; then, where the factors of SuperLU fit, comes
    the proof by `inertia`; else the solver that suits the system, which may count fewer unstable directions than there
    are.

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
        suited = choice_for(system).name
        if suited in ("dense", "superlu"):
            known = _proven(system)
        elif factorisation is None:
            known = factorise(system).inertia()
    if known is None:
        raise InertiaUnknown(
            f"the eigenvalues of a system of {system.n_unknowns} unknowns were not counted: no factorisation that "
            "tells its inertia fits, and the iterations that look for a negative one did not settle. Install pypardiso "
            "or python-mumps to have them counted"
        )
    return max(known.negative - system.n_constraints, 0)


def _proven(system: LinearSystem) -> Inertia | None:
    """Inertia by proof; where the factors grow too much for one, by the solver that looks for unstable directions."""
    try:
        return inertia(system.matrix(), system.n_constraints)
    except InertiaUnknown:
        if system.rigid_motions is None:
            raise
    from myobridge.registry import registry

    return registry().find("linear_solver", "amg_gmres").cls().factorise(system).inertia()
