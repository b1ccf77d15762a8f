"""Pictures of a result: stretch, tension, moments, energies over time; the density of heads at chosen times."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from myobridge.errors import MyobridgeError
from myobridge.figures import new_figure, save_figure, title
from myobridge.interfaces import Array
from myobridge.ledger import FLOWS, STORED
from myobridge.results import Result

__all__ = ["draw", "draw_density"]

_MAX_LINES = 12
# From here on a legend would hide more than it explains; colours run with the site's number instead.
_MAX_LEGEND = 6


def draw(result: Result, path: str | os.PathLike[str]) -> Path:
    """Draw a result into a PNG (or what the suffix says): one panel a quantity, sites in colours.

    What says nothing (full activation all the time, moments of a model without a population) is left out.

    Raises
    ------
    MyobridgeError
        If the result has nothing to draw, or the picture cannot be written.
    """
    panels = _panels(result)
    if not panels:
        raise MyobridgeError("the result has no series to draw; record some (record.quantities)")
    columns = 2 if len(panels) > 1 else 1
    figure, axes = _figure(-(-len(panels) // columns), columns)
    for panel, axis in zip(panels, axes, strict=False):
        panel(axis, result)
        axis.grid(alpha=0.3)
    for axis in axes[len(panels) :]:
        axis.remove()
    figure.suptitle(title(result))
    return save_figure(figure, path)


def draw_density(axis: Any, result: Result) -> None:
    """Attached fraction over displacement, one line a snapshot, of the site that moved most."""
    column = 0
    if "stretch" in result.series:
        column = int(np.argmax(np.ptp(result.series["stretch"], axis=0)))
    low, high = np.inf, -np.inf
    for snapshot in result.densities:
        position, fraction = snapshot.position[column], snapshot.fraction[column]
        axis.plot(position, fraction, label=f"{1e3 * snapshot.time:.4g} ms")
        occupied = position[fraction > 1e-2 * max(float(fraction.max()), 1e-300)]
        if occupied.size:
            low, high = min(low, float(occupied.min())), max(high, float(occupied.max()))
    if low < high:
        margin = 0.15 * (high - low)
        axis.set_xlim(low - margin, high + margin)
    axis.set_xlabel("displacement of the heads [reach]")
    axis.set_ylabel("attached fraction [-]")
    _legend(axis, len(result.densities) <= 8, f"site {result.sites[column]}")


def _panels(result: Result) -> list[Any]:
    series = result.series
    panels = [_over_time(name, label, unit) for name, label, unit in _LINES if _tells(series, name)]
    panels += [_summary(name, label, unit) for name, label, unit in _LINES if _tells_in_summary(series, name)]
    if "Q0" in series and np.any(series["Q0"] != 0.0):
        panels.append(_moments)
    if any(np.any(series.get(f"energy/{name}", 0.0) != 0.0) for name in (*STORED, *FLOWS)):
        panels.append(_energies)
    if (
        "tension" in series
        and series["tension"].size
        and np.ptp(series["tension"][-1]) > 1e-9 * np.abs(series["tension"][-1]).max()
    ):
        panels.append(_final_tension)
    if result.densities:
        panels.append(draw_density)
    return panels


def _tells(series: Any, name: str) -> bool:
    return name in series and series[name].size > 0 and (name != "activation" or bool(np.any(series[name] != 1.0)))


def _tells_in_summary(series: Any, name: str) -> bool:
    below_full = name != "activation" or bool(np.any(series.get("least/activation", 1.0) != 1.0))
    return name not in series and f"mean/{name}" in series and below_full


def _figure(rows: int, columns: int) -> tuple[Any, Any]:
    figure = new_figure(5.2 * columns, 3.1 * rows)
    return figure, figure.subplots(rows, columns, squeeze=False).ravel()


_LINES = (
    ("stretch", "stretch", "-"),
    ("tension", "tension", "kPa"),
    ("activation", "activation", "-"),
)


def _over_time(name: str, label: str, unit: str) -> Any:
    def panel(axis: Any, result: Result) -> None:
        from matplotlib import colormaps

        data = result.series[name] * (1e-3 if unit == "kPa" else 1.0)
        n_lines = min(_MAX_LINES, data.shape[1]) if np.any(data != data[:, :1]) else 1
        shown = np.unique(np.linspace(0, data.shape[1] - 1, n_lines).astype(int))
        colours = colormaps["viridis"](np.linspace(0.1, 0.9, len(shown)))
        for colour, column in zip(colours, shown, strict=True):
            ends = len(shown) <= _MAX_LEGEND or column in (shown[0], shown[-1])
            axis.plot(
                _along(result)[0],
                data[:, column],
                color=colour,
                label=f"site {result.sites[column]}" if ends else None,
            )
        _axes(axis, result, f"{label} [{unit}]")
        # A value that stays the same is no reason to magnify round-off.
        if np.ptp(data) <= 1e-9 * max(float(np.abs(data).max()), 1e-300):
            middle = float(data.flat[0])
            axis.set_ylim(middle - 0.1 * max(abs(middle), 0.1), middle + 0.1 * max(abs(middle), 0.1))
        if len(shown) == 1 < data.shape[1]:
            axis.lines[0].set_label("all sites")
        _legend(axis, data.shape[1] > 1)

    return panel


def _summary(name: str, label: str, unit: str) -> Any:
    """Mean over the volume, and the band from the least to the largest."""

    def panel(axis: Any, result: Result) -> None:
        factor = 1e-3 if unit == "kPa" else 1.0
        along = _along(result)[0]
        low, mean, high = (factor * result.series[f"{kind}/{name}"] for kind in ("least", "mean", "largest"))
        axis.fill_between(along, low, high, alpha=0.3, label="least to largest")
        axis.plot(along, mean, label="mean")
        _axes(axis, result, f"{label} [{unit}]")
        _legend(axis)

    return panel


def _moments(axis: Any, result: Result) -> None:
    several = result.series["Q0"].shape[1] > 1
    for name in ("Q0", "Q1", "Q2"):
        axis.plot(_along(result)[0], result.series[name].mean(axis=1), label=name)
    _axes(axis, result, "moments, mean over sites [-]" if several else "moments [-]")
    _legend(axis)


def _energies(axis: Any, result: Result) -> None:
    rows = {name: result.series[f"energy/{name}"] for name in (*STORED, *FLOWS) if f"energy/{name}" in result.series}
    largest = max(float(np.abs(data).max()) for data in rows.values())
    factor, unit = next(item for item in ((1.0, "J"), (1e3, "mJ"), (1e6, "µJ"), (1e9, "nJ")) if _fits(largest, item))
    for name, data in rows.items():
        # Round-off of what is nothing would only fill the legend.
        if np.abs(data).max() > 1e-12 * largest:
            stored = name in STORED
            label = f"{name.replace('_', ' ')} ({'stored' if stored else 'flowed'})"
            axis.plot(_along(result)[0], factor * data, "-" if stored else "--", label=label)
    _axes(axis, result, f"energy [{unit}]")
    _legend(axis)


def _fits(largest: float, item: tuple[float, str]) -> bool:
    return largest * item[0] >= 1.0 or item[1] == "nJ"


def _final_tension(axis: Any, result: Result) -> None:
    """Tension against what distinguishes the sites at the end: their speed, else their stretch, else their number."""
    series = result.series
    tension = 1e-3 * series["tension"][-1]
    across, label = _across(series, result.sites)
    order = np.argsort(across)
    axis.plot(across[order], tension[order], "o-", markersize=3)
    axis.set_xlabel(f"{label} at the end" if label != "site" else label)
    axis.set_ylabel("tension at the end [kPa]")
    if label == "site":
        axis.xaxis.get_major_locator().set_params(integer=True)


def _across(series: Any, sites: Array) -> tuple[Array, str]:
    for name, label, smallest in (("stretch_rate", "stretch rate [1/s]", 1e-9), ("stretch", "stretch [-]", 1e-12)):
        if name in series and np.ptp(series[name][-1]) > smallest:
            return series[name][-1], label
    return np.asarray(sites), "site"


def _along(result: Result) -> tuple[Array, str]:
    """What the curves run along: time, or the scale of statics."""
    if "scale" in result.series:
        return result.series["scale"], "scale [-]"
    return 1e3 * result.series["time"], "time [ms]"


def _axes(axis: Any, result: Result, label: str) -> None:
    axis.set_xlabel(_along(result)[1])
    axis.set_ylabel(label)
    # An offset at the corner of an axis is easily missed.
    axis.ticklabel_format(axis="y", useOffset=False)


def _legend(axis: Any, wanted: bool = True, title: str | None = None) -> None:
    handles: Sequence[Any] = axis.get_legend_handles_labels()[0]
    if wanted and handles:
        axis.legend(fontsize=8, title=title, title_fontsize=8, framealpha=0.7)
