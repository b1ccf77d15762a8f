"""What explicit integrators share: the acceleration at a point."""

from __future__ import annotations

from myobridge.interfaces import ActiveLaw, Array, MacroSolid, Motion
from myobridge.solvers.linear import mass_solver, solve
from myobridge.solvers.step import effective_mass

__all__ = ["acceleration"]


def acceleration(solid: MacroSolid, law: ActiveLaw | None, motion: Motion, time: float) -> Array:
    r""":math:`-M^{-1} f(u, v, t)` [m/s^2]; the mass is factored once for each solid, unless heads add to it."""
    force = solid.balance(motion, law, time).force
    if law is None or law.inertance is None:
        return -mass_solver(solid)(force)
    mass = effective_mass(solid, law.inertance)
    return -force / mass if mass.ndim == 1 else -solve(mass, force)
