"""Solvers: Newton and linear algebra, a public service that integrators and continuation share."""

from myobridge.solvers.explicit import acceleration
from myobridge.solvers.inertia import Inertia, InertiaUnknown, inertia
from myobridge.solvers.linear import SingularMatrix, add_scaled, bordered, mass_solver, solve, times
from myobridge.solvers.newton import NewtonResult, newton
from myobridge.solvers.step import effective_mass, implicit_stage, kinetic_energy, step_report

__all__ = [
    "Inertia",
    "InertiaUnknown",
    "NewtonResult",
    "SingularMatrix",
    "acceleration",
    "add_scaled",
    "bordered",
    "effective_mass",
    "implicit_stage",
    "inertia",
    "kinetic_energy",
    "mass_solver",
    "newton",
    "solve",
    "step_report",
    "times",
]
