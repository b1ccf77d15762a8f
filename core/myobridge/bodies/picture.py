"""Picture of a body: a panel a state, one scale, one colour bar, the undeformed outline behind."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from myobridge.bodies.choice import Colouring, choose_field, choose_states, named
from myobridge.bodies.flat import paint_flat
from myobridge.bodies.skin import Skin, skin
from myobridge.bodies.space import View, paint_space
from myobridge.bodies.surface import intervals, polylines, surface
from myobridge.errors import MyobridgeError, nearest
from myobridge.figures import new_figure, save_figure, title
from myobridge.interfaces import Array, VisibleMesh
from myobridge.results import Result

__all__ = ["ENGINES", "draw_body"]

ENGINES = ("auto", "matplotlib", "pyvista")
# Beyond this, edges are all that one sees; and no picture has more pixels than this many triangles.
_MANY_FACES = 3000
_MOST_TRIANGLES = {"flat": 60_000, "matplotlib": 20_000, "pyvista": 400_000}


def draw_body(
    result: Result,
    path: str | os.PathLike[str],
    *,
    field: str = "",
    states: str | int = "",
    per_cell: bool = False,
    edges: bool | None = None,
    view: tuple[float, float] = (-60.0, 22.0),
    engine: str = "auto",
) -> Path:
    """Draw the body of a result, coloured by a field, into a PNG (or what the suffix says).

    Parameters
    ----------
    field, states : str
        See `choose_field` and `choose_states`.
    per_cell : bool
        One colour a cell; else smooth, values on cells averaged at the nodes.
    edges : bool, optional
        Whether the cells' edges are drawn; without, where they are few enough to tell apart.
    view : pair of float
        Azimuth and elevation [degrees] from which a body in space is seen.
    engine : str
        For bodies in space: ``pyvista``, ``matplotlib``, or ``auto``, pyvista where it is installed.

    Raises
    ------
    MyobridgeError
        If the result has no body, no such field or state, or the picture cannot be written.
    """
    mesh = result.mesh
    if mesh is None:
        raise MyobridgeError("the result has no body to draw: its solid has no shape, or record.fields is empty")
    chosen = choose_states(result.fields, states)
    colouring = choose_field(chosen, field)
    seen = skin(mesh)
    deep = mesh.kind.startswith(("tetra", "hexahedron"))
    look = View.of(*view) if deep else View.of(-90.0, 90.0)
    engine = _engine(engine) if deep else "flat"
    places = [mesh.points + state["displacement"] for state in chosen]
    n = intervals(seen, _MOST_TRIANGLES[engine])
    outline = polylines(seen, mesh.points, n, _outline(mesh, seen, look) if deep else seen.border())
    frame = _frame([*(look.flattened(place) for place in places), look.flattened(outline.reshape(-1, 3))], deep)
    figure, axes = _panels(frame, len(chosen))
    paint = _painter(engine, look, frame)
    for axis, state, place, values in zip(axes, chosen, places, colouring.values, strict=False):
        _behind(axis, look.flattened(outline))
        body = surface(mesh, seen, place, values, n, on_cells=colouring.on_cells, flat=per_cell)
        wanted = len(seen.faces) <= _MANY_FACES if edges is None else edges
        shown = seen.facing(place, look.eye)[0] if deep else seen
        lines = polylines(shown, place, n) if wanted else None
        paint(axis, body, lines, _norm(colouring), colouring.colours, flat=per_cell)
        _dress(axis, frame, named(state, chosen), look if deep else None)
    for axis in axes[len(chosen) :]:
        axis.remove()
    _bar(figure, axes[: len(chosen)], colouring)
    figure.suptitle(title(result))
    return save_figure(figure, path)


def _engine(wanted: str) -> str:
    if wanted not in ENGINES:
        raise MyobridgeError(f"--engine {wanted}: is unknown. {nearest(wanted, ENGINES)}")
    there = importlib.util.find_spec("pyvista") is not None
    if wanted == "pyvista" and not there:
        raise MyobridgeError("--engine pyvista: is not installed; pip install 'myobridge[viz]', or --engine matplotlib")
    return "pyvista" if there and wanted != "matplotlib" else "matplotlib"


def _painter(engine: str, look: View, frame: tuple[float, float, float, float]) -> Callable[..., None]:
    if engine == "flat":
        return paint_flat
    if engine == "matplotlib":
        return lambda *items, flat: paint_space(*items, view=look, flat=flat)
    from myobridge.bodies.rendered import paint_rendered

    return lambda *items, flat: paint_rendered(*items, view=look, flat=flat, frame=frame)


def _outline(mesh: VisibleMesh, seen: Skin, look: View) -> np.ndarray:
    """Edges of the undeformed body that show its shape: its silhouette, and creases in front."""
    facing, front = seen.facing(mesh.points, look.eye)
    border, creases = facing.border(), facing.creases(mesh.points)
    found = np.concatenate([border, creases])
    found[:, 0] = front[found[:, 0]]
    return found


def _frame(points: list[Array], deep: bool) -> tuple[float, float, float, float]:
    """Left, right, bottom, top [mm] around all points, with a margin; below a body in space one for the scale."""
    everything = 1e3 * np.concatenate(points)
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.04 * float((high - low).max())
    return low[0] - margin, high[0] + margin, low[1] - (2.5 * margin if deep else margin), high[1] + margin


def _panels(frame: tuple[float, float, float, float], count: int) -> tuple[Any, list[Any]]:
    width, height = frame[1] - frame[0], frame[3] - frame[2]
    # The arrangement that leaves a page of 3 to 2 the least empty.
    columns = min(range(1, count + 1), key=lambda k: abs(np.log(k * width / (-(-count // k) * height) / 1.5)))
    rows = -(-count // columns)
    scale = min(10.0 / (columns * width), 7.5 / (rows * height))
    figure = new_figure(columns * (scale * width + 0.35) + 1.1, rows * (scale * height + 0.45) + 0.5)
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def _norm(colouring: Colouring) -> Any:
    from matplotlib.colors import Normalize

    return Normalize(*colouring.limits)


def _bar(figure: Any, axes: list[Any], colouring: Colouring) -> None:
    from matplotlib.cm import ScalarMappable

    colours = ScalarMappable(_norm(colouring), colouring.colours)
    bar = figure.colorbar(colours, ax=axes, shrink=0.8, aspect=25, label=colouring.label)
    # An offset at the corner of an axis is easily missed.
    bar.formatter.set_useOffset(False)


def _behind(axis: Any, outline: Array) -> None:
    from matplotlib.collections import LineCollection

    lines = LineCollection([*(1e3 * outline)], colors="0.45", linewidths=0.8, linestyles=(0, (4, 3)), zorder=1)
    axis.add_collection(lines)


def _dress(axis: Any, frame: tuple[float, float, float, float], name: str, look: View | None) -> None:
    axis.set_xlim(frame[0], frame[1])
    axis.set_ylim(frame[2], frame[3])
    axis.set_aspect("equal")
    axis.set_title(name, fontsize=10)
    axis.tick_params(labelsize=7)
    axis.set_xlabel("[mm]", fontsize=7, labelpad=1)
    if look is None:
        return
    # In space no coordinate can be read off an axis: a bar tells the scale, three arrows the directions.
    axis.set_axis_off()
    span = frame[1] - frame[0]
    length = 10.0 ** np.floor(np.log10(0.4 * span))
    length *= max(k for k in (1, 2, 5) if k * length <= 0.4 * span)
    corner = np.array([frame[1] - 0.03 * span - length, frame[2] + 0.02 * span])
    axis.plot(corner[0] + np.array([0.0, length]), corner[[1, 1]], color="black", linewidth=1.5, zorder=4)
    middle = (corner[0] + 0.5 * length, corner[1])
    axis.annotate(f"{length:g} mm", middle, (0, 3), textcoords="offset points", fontsize=7, ha="center")
    origin = np.array([frame[0] + 0.08 * span, frame[2] + 0.08 * span])
    for direction, letter in zip(look.flattened(np.eye(3)), "xyz", strict=True):
        tip = origin + 0.06 * span * direction
        axis.plot([origin[0], tip[0]], [origin[1], tip[1]], color="0.3", linewidth=1.0, zorder=4)
        axis.text(*(origin + 0.085 * span * direction), letter, fontsize=7, color="0.3", ha="center", va="center")
