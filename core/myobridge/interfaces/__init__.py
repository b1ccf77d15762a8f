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
from myobridge.interfaces.fibre import Overlap, SarcomereDensity
from myobridge.interfaces.macro_solid import Balance, MacroSolid, Matrix, Motion
from myobridge.interfaces.signal import ActivationKinetics, Signal
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
    "Fluxes",
    "LawValue",
    "MacroSolid",
    "Matrix",
    "Memory",
    "Motion",
    "Overlap",
    "PathPoint",
    "Promises",
    "SarcomereDensity",
    "Signal",
    "StepReport",
    "StepResult",
    "TimeIntegrator",
]
