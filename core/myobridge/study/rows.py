"""Rows of the table of a study: what each variant costs and how far it is off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from myobridge.study.measurement import Measurement
from myobridge.study.variants import Variant

__all__ = ["Row", "priced"]


@attrs.frozen(kw_only=True)
class Row:
    """One variant, measured.

    Attributes
    ----------
    variant : Variant
    error : float
        Distance from the solution of the reference model, relative; never less than that solution's own error. NaN
        without.
    discretisation_error : float
        Distance from the fine solution of the variant's own model.
    model_error : float
        Distance of that fine solution from the solution of the reference model; 0 where they are one.
    cpu, wall : float
        Medians of the timed runs [s].
    spread : float
        Largest minus smallest CPU time over the median.
    runs : int
        Timed runs.
    rounds : tuple of float
        CPU time of each run [s], in the order of the rounds.
    steps : int
    work : mapping
        Counts of `myobridge.work.WORK`.
    reason : str
        Why there is no result, or why it was not run; empty where there is one.
    hosts : tuple of str
        Machines on which it ran.
    """

    variant: Variant
    error: float = math.nan
    discretisation_error: float = math.nan
    model_error: float = math.nan
    cpu: float = math.nan
    wall: float = math.nan
    spread: float = 0.0
    runs: int = 0
    rounds: tuple[float, ...] = ()
    steps: int = 0
    work: Mapping[str, int] = attrs.field(factory=dict)
    reason: str = ""
    hosts: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """What distinguishes the variant."""
        return self.variant.label

    @property
    def command(self) -> str:
        """Its settings as ``--set`` options, ready to paste."""
        return self.variant.command

    @property
    def measured(self) -> bool:
        """Whether there is an error and a time."""
        return not self.reason and math.isfinite(self.error) and math.isfinite(self.cpu)

    def ratio(self, other: Row) -> float:
        """CPU time over that of another row: median over the rounds in which both ran, one after the other."""
        pairs = list(zip(self.rounds, other.rounds, strict=False))
        return float(np.median([mine / yours for mine, yours in pairs])) if pairs else math.nan

    def as_data(self) -> dict[str, Any]:
        """Plain flat data, a line of the tidy table."""
        plain = {
            "label": self.label,
            "family": self.variant.family,
            "model": self.variant.model,
            "error": self.error,
            "discretisation_error": self.discretisation_error,
            "model_error": self.model_error,
            "cpu": self.cpu,
            "wall": self.wall,
            "spread": self.spread,
            "runs": self.runs,
            "steps": self.steps,
            **self.work,
            "reason": self.reason,
            "set": self.command,
        }
        return plain | {f"set {key}": _plain(value) for key, value in self.variant.settings.items()}


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def priced(variant: Variant, measurements: Sequence[Measurement], **errors: float) -> Row:
    """Row of the runs of one variant; a run that failed makes it a row with its reason."""
    failed = next((one for one in measurements if one.failure), None)
    if failed is not None:
        return Row(variant=variant, reason=failed.failure, hosts=(failed.host,))
    stopped = next((one for one in measurements if one.stopped), None)
    rounds = tuple(one.cpu for one in measurements)
    first, middle = measurements[0], float(np.median(rounds))
    return Row(
        variant=variant,
        cpu=middle,
        wall=float(np.median([one.wall for one in measurements])),
        spread=(max(rounds) - min(rounds)) / middle if middle else 0.0,
        runs=len(rounds),
        rounds=rounds,
        steps=first.steps,
        work=first.work,
        hosts=tuple(sorted({one.host for one in measurements})),
        reason="given up: it costs more than another that is good enough" if stopped else "",
        **errors,
    )
