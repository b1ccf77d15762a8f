"""The contracts: what a plugin is given and what it must answer. The core knows nothing else of any model."""

from myobridge.interfaces.active_law import ActiveLaw, AffineLaw, Array, LawValue
from myobridge.interfaces.continuation import (
    ContinuationPath,
    ContinuationProblem,
    ContinuationStrategy,
    PathPoint,
)
from myobridge.interfaces.coupling import CouplingScheme
from myobridge.interfaces.cross_bridge import CrossBridgeModel, Fluxes, Promises
from myobridge.interfaces.fibre import Fibres, Overlap, SarcomereDensity
from myobridge.interfaces.linear_solver import Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.interfaces.load import Load, Surface
from myobridge.interfaces.macro_solid import MacroSolid
from myobridge.interfaces.material import Material, MaterialFunctions
from myobridge.interfaces.mesh import MeshSource
from myobridge.interfaces.motion import Balance, Matrix, Motion, VisibleMesh, Works
from myobridge.interfaces.newton import KeptTangent, NewtonMethod, NewtonProblem, NewtonResult, NewtonStep, NewtonTask
from myobridge.interfaces.signal import ActivationKinetics, Signal
from myobridge.interfaces.stability_case import Expectation, Limit, StabilityCase
from myobridge.interfaces.time_integrator import Memory, StepReport, StepResult, TimeIntegrator

__all__ = [
    "ActivationKinetics",
    "ActiveLaw",
    "AffineLaw",
    "Array",
    "Balance",
    "ContinuationPath",
    "ContinuationProblem",
    "ContinuationStrategy",
    "CouplingScheme",
    "CrossBridgeModel",
    "Expectation",
    "Factorisation",
    "Fibres",
    "Fluxes",
    "KeptTangent",
    "LawValue",
    "Limit",
    "LinearSolver",
    "LinearSystem",
    "Load",
    "MacroSolid",
    "Material",
    "MaterialFunctions",
    "Matrix",
    "Memory",
    "MeshSource",
    "Motion",
    "NewtonMethod",
    "NewtonProblem",
    "NewtonResult",
    "NewtonStep",
    "NewtonTask",
    "Overlap",
    "PathPoint",
    "Promises",
    "SarcomereDensity",
    "Signal",
    "StabilityCase",
    "StepReport",
    "StepResult",
    "Surface",
    "SystemSize",
    "TimeIntegrator",
    "VisibleMesh",
    "Works",
]
