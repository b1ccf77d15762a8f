"""Heat map of an atlas: rows are cases, columns methods; colour says what was found and whether it was expected."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from myobridge.atlas.cell import Finding
from myobridge.atlas.chart import Chart
from myobridge.figures import new_figure, save_figure

__all__ = ["draw_chart"]

# Holds, fails, fails as it must, does not go together, differs from what is expected.
_KINDS = ("holds", "fails", "fails, as it must", "does not apply", "surprise")
_COLOURS = ("#4c9f70", "#e0a458", "#b8c4bb", "#f4f4f4", "#c1121f")


def _kind(finding: Finding) -> int:
    if finding.surprise:
        return 4
    if finding.outcome == "holds":
        return 0
    if finding.outcome == "not applicable":
        return 3
    return 2 if finding.expected == "fails" else 1


def draw_chart(chart: Chart, path: str | os.PathLike[str]) -> Path:
    """Draw the heat map of a chart.

    Raises
    ------
    MyobridgeError
        If the file cannot be written.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    rows, columns = chart.rows, chart.columns
    values = np.full((len(rows), len(columns)), np.nan)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            finding = chart.at(row, column)
            if finding is not None:
                values[i, j] = _kind(finding)
    figure = new_figure(2.6 + 0.26 * len(columns), 2.2 + 0.21 * len(rows))
    axes = figure.add_subplot()
    axes.imshow(values, cmap=ListedColormap(_COLOURS), vmin=-0.5, vmax=4.5, aspect="auto", interpolation="nearest")
    axes.set_xticks(range(len(columns)), [name for _, name in columns], rotation=60, ha="right", fontsize=7)
    axes.set_yticks(range(len(rows)), rows, fontsize=7)
    axes.set_xticks(np.arange(-0.5, len(columns)), minor=True)
    axes.set_yticks(np.arange(-0.5, len(rows)), minor=True)
    axes.grid(which="minor", color="white", linewidth=0.8)
    axes.tick_params(which="both", length=0)
    for i, j in np.argwhere(values == 4):
        axes.text(j, i, "!", color="white", weight="bold", ha="center", va="center", fontsize=8)
    for j, (axis, _) in enumerate(columns):
        if j == 0 or axis != columns[j - 1][0]:
            axes.axvline(j - 0.5, color="black", linewidth=0.8)
            if j:
                axes.text(j - 0.4, -0.8, axis.replace("_", " "), fontsize=7, style="italic", rotation=25)
    for place in ("top", "right", "bottom", "left"):
        axes.spines[place].set_visible(False)
    handles = [Patch(facecolor=colour, edgecolor="#999999") for colour in _COLOURS]
    figure.legend(handles, _KINDS, loc="outside upper center", ncols=5, fontsize=7, frameon=False)
    return save_figure(figure, path)
