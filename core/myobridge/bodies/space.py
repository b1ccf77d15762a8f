r"""Bodies in space, with matplotlib alone: triangles seen along a direction, lit, painted from far to near.

.. math:: (\xi, \eta) = (e_r \cdot x, \; e_u \cdot x), \qquad \text{depth} = d \cdot x

with `d` towards the eye, :math:`e_r` to the right and :math:`e_u` upwards: a parallel projection.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from myobridge.bodies.surface import Surface
from myobridge.interfaces import Array

__all__ = ["View", "paint_space"]


class View(NamedTuple):
    """Direction of a parallel projection: towards the eye, to the right, upwards; each (3,)."""

    eye: Array
    right: Array
    up: Array

    @classmethod
    def of(cls, azimuth: float, elevation: float) -> View:
        """View from `azimuth` (about z, from x) and `elevation` (above the x-y plane), in degrees."""
        a, e = np.radians(azimuth), np.radians(elevation)
        eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return cls(eye, right, np.cross(eye, right))

    def flattened(self, points: Array) -> Array:
        """Projection (..., 2) of points (..., 3)."""
        return points @ np.stack([self.right, self.up], axis=1)


def paint_space(
    axis: Any, body: Surface, edges: Array | None, norm: Any, colours: str, *, view: View, flat: bool
) -> None:
    """Paint `body` into `axis`, in mm."""
    from matplotlib import colormaps
    from matplotlib.collections import PolyCollection

    place = body.points[body.triangles]
    normals = np.cross(place[:, 1] - place[:, 0], place[:, 2] - place[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    # The skin is closed: what looks away is hidden.
    front = normals @ view.eye > 0.0
    values = body.values if flat else body.values[body.triangles].mean(axis=1)
    colour = colormaps[colours](norm(np.nan_to_num(values[front], nan=norm.vmin)))
    colour[body.blank[front]] = (0.8, 0.8, 0.8, 1.0)
    light = view.eye - 0.5 * view.right + 0.7 * view.up
    lit = np.clip(normals[front] @ (light / np.linalg.norm(light)), 0.0, 1.0)
    colour[:, :3] *= (0.55 + 0.45 * lit)[:, None]
    shapes = [*(1e3 * view.flattened(place[front]))]
    depth = place[front].mean(axis=1) @ view.eye
    # Smoothed borders of triangles would shine through between them; edges are smooth.
    lines, smoothed = np.full(len(shapes), 0.3), np.zeros(len(shapes), dtype=bool)
    border = colour
    if edges is not None:
        # Between the triangles, by depth, nearer than those beside: an edge behind the body stays behind it.
        pieces = np.stack([edges[:, :-1], edges[:, 1:]], axis=2).reshape(-1, 2, 3)
        deep = place[front] @ view.eye
        hair = float(np.max(deep.max(axis=1) - deep.mean(axis=1), initial=0.0))
        shapes += [*(1e3 * view.flattened(pieces))]
        depth = np.concatenate([depth, pieces.mean(axis=1) @ view.eye + hair])
        lines = np.concatenate([lines, np.full(len(pieces), 0.35)])
        smoothed = np.concatenate([smoothed, np.ones(len(pieces), dtype=bool)])
        border = np.concatenate([colour, np.tile([0.0, 0.0, 0.0, 0.55], (len(pieces), 1))])
        colour = np.concatenate([colour, np.zeros((len(pieces), 4))])
    order = np.argsort(depth)
    axis.add_collection(
        PolyCollection(
            [shapes[i] for i in order],
            facecolors=colour[order],
            edgecolors=border[order],
            linewidths=lines[order],
            antialiaseds=smoothed[order],
            closed=False,
        )
    )
