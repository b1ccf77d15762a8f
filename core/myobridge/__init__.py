"""myobridge: multi-scale muscle simulation, cross-bridges below, tissue above, joined by a coupling bus."""

from myobridge.atlas import Atlas, Chart
from myobridge.bus import CouplingBus
from myobridge.errors import ContinuationFailed, MyobridgeError, ParameterError, PluginError, SceneError, StepFailed
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    ActivationKinetics,
    ActiveLaw,
    AffineLaw,
    ContinuationPath,
    ContinuationProblem,
    ContinuationStrategy,
    CouplingScheme,
    CrossBridgeModel,
    Expectation,
    Fibres,
    Fluxes,
    Limit,
    LinearSolver,
    Load,
    MacroSolid,
    Material,
    MeshSource,
    Motion,
    Overlap,
    PathPoint,
    Promises,
    SarcomereDensity,
    Signal,
    StabilityCase,
    StepReport,
    StepResult,
    TimeIntegrator,
)
from myobridge.ledger import Ledger
from myobridge.plan import Plan
from myobridge.recording import Record
from myobridge.registry import registry
from myobridge.results import Result
from myobridge.run import Run, resume, run
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.static_run import StaticRun
from myobridge.statics import Statics
from myobridge.study import Study, StudyResult

__all__ = [
    "ActivationKinetics",
    "ActiveLaw",
    "AffineLaw",
    "Atlas",
    "Chart",
    "ContinuationFailed",
    "ContinuationPath",
    "ContinuationProblem",
    "ContinuationStrategy",
    "CouplingBus",
    "CouplingScheme",
    "CrossBridgeModel",
    "Expectation",
    "Fibres",
    "Fluxes",
    "Ledger",
    "Limit",
    "LinearSolver",
    "Load",
    "MacroSolid",
    "Material",
    "MeshSource",
    "Motion",
    "MyobridgeError",
    "Overlap",
    "ParameterError",
    "PathPoint",
    "Plan",
    "PluginError",
    "Promises",
    "Record",
    "Result",
    "Run",
    "SarcomereDensity",
    "Scene",
    "SceneError",
    "Signal",
    "Simulation",
    "StabilityCase",
    "StaticRun",
    "Statics",
    "StepFailed",
    "StepReport",
    "StepResult",
    "Study",
    "StudyResult",
    "TimeIntegrator",
    "hookimpl",
    "registry",
    "resume",
    "run",
]

__version__ = "0.1.0"
