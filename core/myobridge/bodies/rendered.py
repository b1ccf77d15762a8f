"""Bodies in space, rendered off screen by pyvista (extra ``viz``): smooth light, exact depth."""

from __future__ import annotations

import importlib
import os
import sys
from typing import Any

import numpy as np

from myobridge.bodies.space import View
from myobridge.bodies.surface import Surface
from myobridge.interfaces import Array

__all__ = ["paint_rendered"]


def paint_rendered(
    axis: Any,
    body: Surface,
    edges: Array | None,
    norm: Any,
    colours: str,
    *,
    view: View,
    flat: bool,
    frame: tuple[float, float, float, float],
    pixels: int = 900,
) -> None:
    """Paint `body` into `axis`, whose limits are `frame` (left, right, bottom, top) in mm, as an image."""
    image = _render(body, edges, norm, colours, view, flat, np.array(frame) * 1e-3, pixels)
    axis.imshow(image, extent=frame, interpolation="antialiased", zorder=2)


def _render(
    body: Surface, edges: Array | None, norm: Any, colours: str, view: View, flat: bool, frame: Array, pixels: int
) -> Array:
    # Without a display VTK tries X first and says so on the terminal.
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    pyvista = importlib.import_module("pyvista")  # an extra, not always there

    left, right, bottom, top = frame
    size = np.array([right - left, top - bottom])
    window = np.maximum((pixels * size / size.max()).astype(int), 16)
    plotter = pyvista.Plotter(off_screen=True, window_size=[int(n) for n in window])
    try:
        painted = ~body.blank
        for triangles, kept in ((body.triangles[painted], painted), (body.triangles[body.blank], None)):
            if not len(triangles):
                continue
            mesh = pyvista.PolyData.from_regular_faces(body.points, triangles)
            look: dict[str, Any] = {"color": "lightgrey"}
            if kept is not None:
                (mesh.cell_data if flat else mesh.point_data)["value"] = body.values[kept] if flat else body.values
                look = {"scalars": "value", "cmap": colours, "clim": [norm.vmin, norm.vmax], "show_scalar_bar": False}
            plotter.add_mesh(_smooth(mesh), ambient=0.45, diffuse=0.6, specular=0.05, **look)
        plotter.remove_all_lights()
        plotter.add_light(pyvista.Light(position=(-0.5, 0.7, 1.0), light_type="camera light"))
        if edges is not None:
            nearer = edges + 2e-3 * float(np.max(np.ptp(body.points, axis=0))) * view.eye
            plotter.add_mesh(_lines(nearer, pyvista), color="black", line_width=1.0, opacity=0.6, lighting=False)
        middle = 0.5 * (left + right) * view.right + 0.5 * (bottom + top) * view.up
        middle = middle + view.eye * float(np.mean(body.points @ view.eye))
        far = 10.0 * float(np.max(np.ptp(body.points, axis=0)))
        plotter.camera_position = [tuple(middle + far * view.eye), tuple(middle), tuple(view.up)]
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = 0.5 * float(size[1])
        plotter.enable_anti_aliasing("ssaa")
        plotter.renderer.ResetCameraClippingRange()
        return np.asarray(plotter.screenshot(None, transparent_background=True, return_img=True))
    finally:
        plotter.close()


def _smooth(mesh: Any) -> Any:
    """The mesh with one normal at each point, except at creases: faces come without common points."""
    merged = mesh.clean(tolerance=1e-9, absolute=False)
    return merged.compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=35.0, consistent_normals=False, auto_orient_normals=False
    )


def _lines(edges: Array, pyvista: Any) -> Any:
    count, length = edges.shape[:2]
    cells = np.column_stack([np.full(count, length), np.arange(count * length).reshape(count, length)])
    return pyvista.PolyData(edges.reshape(-1, 3), lines=cells.ravel())
