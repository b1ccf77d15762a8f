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
from myobridge.solvers.one_step import failed, implicit_stage, stage_report
from myobridge.solvers.stability import stability
from myobridge.solvers.stage import Formula, Solved, solve_stage
from myobridge.solvers.step import effective_mass, finished, kinetic_energy, step_report

__all__ = [
    "Automatic",
    "Choice",
    "Formula",
    "Inertia",
    "InertiaUnknown",
    "NewtonResult",
    "Ordinary",
    "SingularMatrix",
    "Solved",
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
    "failed",
    "finished",
    "implicit_stage",
    "inertia",
    "installed",
    "is_round_off",
    "iterate",
    "kinetic_energy",
    "mass_solver",
    "newton",
    "solve",
    "solve_stage",
    "stability",
    "stage_report",
    "step_report",
    "times",
]
