"""myobridge: multi-scale muscle simulation, cross-bridges below, tissue above, joined by a coupling bus."""

from myobridge.interfaces import (
    ActivationKinetics,
    ActiveLaw,
    AffineLaw,
    ContinuationPath,
    ContinuationProblem,
    ContinuationStrategy,
    CouplingScheme,
    CrossBridgeModel,
    Fluxes,
    MacroSolid,
    Motion,
    Overlap,
    PathPoint,
    Promises,
    SarcomereDensity,
    Signal,
    StepReport,
    StepResult,
    TimeIntegrator,
)

__all__ = [
    "ActivationKinetics",
    "ActiveLaw",
    "AffineLaw",
    "ContinuationPath",
    "ContinuationProblem",
    "ContinuationStrategy",
    "CouplingScheme",
    "CrossBridgeModel",
    "Fluxes",
    "MacroSolid",
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

__version__ = "0.1.0"
