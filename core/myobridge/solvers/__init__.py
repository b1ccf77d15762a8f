"""Solvers: Newton and linear algebra, a public service that integrators and continuation share."""

from myobridge.interfaces import NewtonResult
from myobridge.solvers.choice import Automatic, Choice, choice_for, choice_of, choose, factorise, installed
from myobridge.solvers.explicit import acceleration
from myobridge.solvers.inertia import Inertia, InertiaUnknown, inertia
from myobridge.solvers.linear import (
    SingularMatrix,
    UnsolvedSystem,
    absolute_product,
    add_scaled,
    bordered,
    mass_solver,
    solve,
    times,
)
from myobridge.solvers.newton import Ordinary, is_round_off, iterate, newton
from myobridge.solvers.stability import stability
from myobridge.solvers.stage import implicit_stage
from myobridge.solvers.step import effective_mass, kinetic_energy, step_report

__all__ = [
    "Automatic",
    "Choice",
    "Inertia",
    "InertiaUnknown",
    "NewtonResult",
    "Ordinary",
    "SingularMatrix",
    "UnsolvedSystem",
    "absolute_product",
    "acceleration",
    "add_scaled",
    "bordered",
    "choice_for",
    "choice_of",
    "choose",
    "effective_mass",
    "factorise",
    "implicit_stage",
    "inertia",
    "installed",
    "is_round_off",
    "iterate",
    "kinetic_energy",
    "mass_solver",
    "newton",
    "solve",
    "stability",
    "step_report",
    "times",
]
