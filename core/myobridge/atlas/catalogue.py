"""Catalogue of the quantities that a case can put limits on, by name."""

from __future__ import annotations

from collections.abc import Mapping

from myobridge.atlas.comparison import Amplification, DisplacementError, TensionError
from myobridge.atlas.energy import EnergyGrowth, EnergyLoss, GrowthRate, LedgerDrift, LedgerResidual
from myobridge.atlas.path import Iterations, LimitLevelError, LimitPoints, NegativeEigenvalues, Points
from myobridge.atlas.population import OutOfBounds, Unrealizable
from myobridge.atlas.quantities import PathGauge, RunGauge
from myobridge.atlas.state import AngularMomentumDrift, ConstraintError, MomentumDrift, PressureNoise, VolumeError

__all__ = ["ALWAYS", "PATH_GAUGES", "QUANTITIES", "RUN_GAUGES"]

RUN_GAUGES: Mapping[str, type[RunGauge]] = {
    "energy_growth": EnergyGrowth,
    "energy_loss": EnergyLoss,
    "ledger_residual": LedgerResidual,
    "ledger_drift": LedgerDrift,
    "growth_rate": GrowthRate,
    "constraint_error": ConstraintError,
    "volume_error": VolumeError,
    "momentum_drift": MomentumDrift,
    "angular_momentum_drift": AngularMomentumDrift,
    "pressure_noise": PressureNoise,
    "out_of_bounds": OutOfBounds,
    "unrealizable": Unrealizable,
    "tension_error": TensionError,
    "displacement_error": DisplacementError,
    "amplification": Amplification,
}

PATH_GAUGES: Mapping[str, type[PathGauge]] = {
    "points": Points,
    "path_iterations": Iterations,
    "negative_eigenvalues": NegativeEigenvalues,
    "limit_points": LimitPoints,
    "limit_level_error": LimitLevelError,
}

# Measured in every run, whatever the limits are.
ALWAYS = ("energy_growth", "energy_loss", "constraint_error", "ledger_residual")

# What the trial itself counts.
_OWN = {
    "steps": ("steps", "-"),
    "iterations": ("iterations of a step", "-"),
    "halvings": ("halvings", "-"),
    "largest_step": ("largest stable step", "s"),
}

QUANTITIES: Mapping[str, tuple[str, str]] = {
    **_OWN,
    **{name: (gauge.words, gauge.unit) for name, gauge in (*RUN_GAUGES.items(), *PATH_GAUGES.items())},
}
"""Words and unit of every quantity, by name."""
