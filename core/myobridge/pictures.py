"""Pictures of a result: stretch, tension, moments, energies over time; the density of heads at chosen times."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from myobridge.errors import MyobridgeError
from myobridge.results import Result

__all__ = ["draw", "draw_density"]

_MAX_LINES = 12
_STORED = ("kinetic", "elastic", "cross_bridge")
_FLOWS = ("attached", "detached", "active_work", "external", "viscous", "numerical")


def _figure(rows: int, columns: int) -> tuple[Any, Any]:
    # Straight to a canvas: no display is asked for, no global state is left behind.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2 * columns, 3.1 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False).ravel()


def draw(result: Result, path: str | os.PathLike[str]) -> Path:
    """Draw a result into a PNG (or what the suffix says): one panel a quantity, sites in colours, densities below.

    Raises
    ------
    MyobridgeError
        If the result has nothing to draw, or the picture cannot be written.
    """
    series = result.series
    panels = [_lines(name, label, unit) for name, label, unit in _LINES if name in series]
    if "Q0" in series:
        panels.append(_moments)
    if "energy/kinetic" in series:
        panels.append(_energies)
    if series.get("tension") is not None and series["tension"].shape[1] > 1:
        panels.append(_final_tension)
    if result.densities:
        panels.append(draw_density)
    if not panels:
        raise MyobridgeError("the result has no series to draw; record some (record.quantities)")
    columns = 2 if len(panels) > 1 else 1
    figure, axes = _figure(-(-len(panels) // columns), columns)
    for panel, axis in zip(panels, axes, strict=False):
        panel(axis, result)
    for axis in axes[len(panels) :]:
        axis.remove()
    target = Path(path)
    try:
        figure.savefig(target, dpi=120)
    except (OSError, ValueError) as error:
        raise MyobridgeError(f"{target}: the picture cannot be written ({error})") from None
    return target


_LINES = (
    ("stretch", "stretch", "-"),
    ("tension", "tension", "kPa"),
    ("activation", "activation", "-"),
)


def _lines(name: str, label: str, unit: str) -> Any:
    def panel(axis: Any, result: Result) -> None:
        data = result.series[name] * (1e-3 if unit == "kPa" else 1.0)
        shown = np.unique(np.linspace(0, data.shape[1] - 1, min(_MAX_LINES, data.shape[1])).astype(int))
        for column in shown:
            axis.plot(1e3 * result.series["time"], data[:, column], label=f"site {result.sites[column]}")
        _finish(axis, f"{label} [{unit}]", legend=1 < len(shown) <= 6)

    return panel


def _moments(axis: Any, result: Result) -> None:
    for name in ("Q0", "Q1", "Q2"):
        axis.plot(1e3 * result.series["time"], result.series[name].mean(axis=1), label=name)
    _finish(axis, "moments, mean over sites [-]")


def _energies(axis: Any, result: Result) -> None:
    for group, style in ((_STORED, "-"), (_FLOWS, "--")):
        for name in group:
            rows = 1e3 * result.series[f"energy/{name}"]
            if np.any(rows != 0.0):
                axis.plot(1e3 * result.series["time"], rows, style, label=name.replace("_", " "))
    _finish(axis, "energy [mJ] (- stored, -- flowed)")


def _final_tension(axis: Any, result: Result) -> None:
    """Tension against what distinguishes the sites at the end: their speed if they move, else their stretch."""
    series = result.series
    tension = 1e-3 * series["tension"][-1]
    rate = series["stretch_rate"][-1] if "stretch_rate" in series else np.zeros_like(tension)
    moving = np.ptp(rate) > 1e-9
    across = rate if moving else series["stretch"][-1]
    if not moving and np.ptp(across) < 1e-12:
        across = result.sites
    order = np.argsort(across)
    axis.plot(across[order], tension[order], "o-", markersize=3)
    label = "stretch rate [1/s]" if moving else "stretch [-]" if np.ptp(series["stretch"][-1]) >= 1e-12 else "site"
    axis.set_xlabel(label)
    axis.set_ylabel("tension at the end [kPa]")
    axis.grid(alpha=0.3)


def draw_density(axis: Any, result: Result) -> None:
    """Attached fraction over displacement, first recorded site, one line a snapshot."""
    for snapshot in result.densities:
        axis.plot(snapshot.position[0], snapshot.fraction[0], label=f"{1e3 * snapshot.time:.4g} ms")
    _finish(axis, "attached fraction [-]", across="displacement [reach]", legend=len(result.densities) <= 8)


def _finish(axis: Any, label: str, *, across: str = "time [ms]", legend: bool = True) -> None:
    axis.set_xlabel(across)
    axis.set_ylabel(label)
    axis.grid(alpha=0.3)
    if legend and axis.get_legend_handles_labels()[0]:
        axis.legend(fontsize=8)
