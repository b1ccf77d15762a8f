"""Solvers: Newton and linear algebra, a public service that integrators and continuation share."""

from myobridge.interfaces import NewtonResult
from myobridge.solvers.choice import Automatic, Choice, choice_for, choice_of, choose, factorise, installed
from myobridge.solvers.constrained import ConstrainedMass
from myobridge.solvers.explicit import (
    Accelerated,
    PointForce,
    accelerated,
    acceleration,
    constraint_at,
    constraint_rate,
    elastic_multiplier,
    point_force,
    strictly_constrained,
)
from myobridge.solvers.fgmres import fgmres
from myobridge.solvers.frequency import Frequency, largest_frequency
from myobridge.solvers.held import HeldTangent
from myobridge.solvers.inertia import Inertia, InertiaUnknown, inertia
from myobridge.solvers.linear import (
    SingularMatrix,
    UnsolvedSystem,
    absolute_product,
    add_scaled,
    bordered,
    length_of,
    mass_solver,
    solve,
    times,
)
from myobridge.solvers.method_choice import MethodChoice, method_for, method_for_size
from myobridge.solvers.newton import ROUND_OFF, Goal, Ordinary, is_round_off, iterate, log_step, newton
from myobridge.solvers.one_step import failed, implicit_stage, stage_report
from myobridge.solvers.projection import (
    Projected,
    gradient_at,
    onto_constraint,
    projected_displacement,
    projected_velocity,
)
from myobridge.solvers.stability import stability
from myobridge.solvers.stage import Formula, Solved, solve_stage
from myobridge.solvers.step import effective_mass, finished, kinetic_energy, step_report

__all__ = [
    "ROUND_OFF",
    "Accelerated",
    "Automatic",
    "Choice",
    "ConstrainedMass",
    "Formula",
    "Frequency",
    "Goal",
    "HeldTangent",
    "Inertia",
    "InertiaUnknown",
    "MethodChoice",
    "NewtonResult",
    "Ordinary",
    "PointForce",
    "Projected",
    "SingularMatrix",
    "Solved",
    "UnsolvedSystem",
    "absolute_product",
    "accelerated",
    "acceleration",
    "add_scaled",
    "bordered",
    "choice_for",
    "choice_of",
    "choose",
    "constraint_at",
    "constraint_rate",
    "effective_mass",
    "elastic_multiplier",
    "factorise",
    "failed",
    "fgmres",
    "finished",
    "gradient_at",
    "implicit_stage",
    "inertia",
    "installed",
    "is_round_off",
    "iterate",
    "kinetic_energy",
    "largest_frequency",
    "length_of",
    "log_step",
    "mass_solver",
    "method_for",
    "method_for_size",
    "newton",
    "onto_constraint",
    "point_force",
    "projected_displacement",
    "projected_velocity",
    "solve",
    "solve_stage",
    "stability",
    "stage_report",
    "step_report",
    "strictly_constrained",
    "times",
]
