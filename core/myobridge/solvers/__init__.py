"""Solvers: Newton and linear algebra, a public service that integrators and continuation share."""

from myobridge.solvers.explicit import acceleration
from myobridge.solvers.linear import SingularMatrix, add_scaled, mass_solver, solve, times
from myobridge.solvers.newton import NewtonResult, newton
from myobridge.solvers.step import effective_mass, implicit_stage, kinetic_energy, step_report

__all__ = [
    "NewtonResult",
    "SingularMatrix",
    "acceleration",
    "add_scaled",
    "effective_mass",
    "implicit_stage",
    "kinetic_energy",
    "mass_solver",
    "newton",
    "solve",
    "step_report",
    "times",
]
