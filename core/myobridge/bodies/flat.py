"""Flat bodies: triangles of one state in the plane, with matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np

from myobridge.bodies.surface import Surface
from myobridge.interfaces import Array

__all__ = ["paint_flat"]


def paint_flat(axis: Any, body: Surface, edges: Array | None, norm: Any, colours: str, *, flat: bool) -> None:
    """Paint `body` into `axis`, in mm; smooth over the cells, or one colour a cell."""
    from matplotlib.collections import LineCollection, PolyCollection

    x, y = 1e3 * body.points[:, 0], 1e3 * body.points[:, 1]
    kept = body.triangles[~body.blank]
    if len(kept):
        if flat:
            # Smoothed borders of triangles would shine through between them.
            axis.tripcolor(
                x, y, kept, facecolors=body.values[~body.blank], cmap=colours, norm=norm, antialiased=False, linewidth=0
            )
        else:
            # Points of blank cells only are not painted, and must be numbers all the same.
            values = np.nan_to_num(body.values, nan=norm.vmin)
            axis.tripcolor(x, y, kept, values, cmap=colours, norm=norm, shading="gouraud")
    if body.blank.any():
        places = 1e3 * body.points[body.triangles[body.blank]][:, :, :2]
        axis.add_collection(PolyCollection([*places], facecolors="0.8", linewidths=0, antialiaseds=False))
    if edges is not None:
        axis.add_collection(LineCollection([*(1e3 * edges[:, :, :2])], colors="black", linewidths=0.35, alpha=0.55))
