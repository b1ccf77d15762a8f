"""Work-precision plot of a study: error against time, one line a family, slopes written, the Pareto front marked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from myobridge.figures import new_figure, save_figure
from myobridge.study.families import families
from myobridge.study.result import StudyResult

__all__ = ["COLOURS", "KINDS", "draw"]

COLOURS = ("#1b6ca8", "#d1603d", "#3c8d53", "#7d4f9e", "#8a6d1d", "#b03a6f", "#4a4a4a", "#2a9d8f")
_MARKERS = "osD^vP*X"
KINDS = {"error": "relative error", "discretisation_error": "error of the discretisation"}
"""Errors that are drawn, with their words; the second only where a study has several models."""


def draw(result: StudyResult, folder: Path, name: str = "work_precision") -> list[Path]:
    """Draw the plot into a folder, as PNG and as SVG.

    Raises
    ------
    MyobridgeError
        If a file cannot be written.
    """
    several = len({row.variant.model for row in result.rows}) > 1
    kinds = list(KINDS)[: 2 if several else 1]
    figure = new_figure(6.0 * len(kinds), 4.6)
    for place, kind in enumerate(kinds):
        axes = figure.add_subplot(1, len(kinds), place + 1)
        _panel(axes, result, kind)
    figure.suptitle(result.study.title.replace("$", r"\$"))
    return [save_figure(figure, folder / f"{name}.{suffix}") for suffix in ("png", "svg")]


def _panel(axes: Any, result: StudyResult, kind: str) -> None:
    found = families(result, kind)
    for place, family in enumerate(found):
        colour, marker = COLOURS[place % len(COLOURS)], _MARKERS[place % len(_MARKERS)]
        axes.loglog(*_points(family.rows, kind), marker, color=colour, alpha=0.35, markersize=4)
        axes.loglog(
            *_points(family.front, kind),
            "-" + marker,
            color=colour,
            markersize=5,
            linewidth=1.3,
            label=family.label.replace("$", r"\$"),
        )
    if kind == "error" and result.pareto():
        axes.loglog(
            *_points(result.pareto(), kind), "o", fillstyle="none", color="black", markersize=11, label="Pareto front"
        )
    tolerance = result.study.tolerance
    if tolerance is not None:
        axes.axhline(tolerance, color="gray", linestyle="--", linewidth=0.9, label=f"tolerance {tolerance:g}")
    least = next(iter(result.reference_errors().values()), 0.0)  # that of the reference model comes first
    if kind == "error" and least > 0.0:
        axes.axhline(least, color="gray", linestyle=":", linewidth=0.9, label=f"reference {least:.1e}")
    axes.set_xlabel("CPU time [s]")
    axes.set_ylabel(KINDS[kind])
    axes.grid(which="major", alpha=0.3)
    axes.tick_params(axis="x", which="minor", labelsize=6, labelrotation=60)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize=7)


def _points(rows: Any, kind: str) -> tuple[list[float], list[float]]:
    return [row.cpu for row in rows], [getattr(row, kind) for row in rows]
