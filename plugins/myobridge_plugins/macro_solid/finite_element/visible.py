"""What a finite-element body looks like: its cells in VTK's order, and its fields."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from myobridge.interfaces import Array, VisibleMesh
from myobridge_plugins.macro_solid.finite_element.assembly import Kinematics
from myobridge_plugins.macro_solid.finite_element.body import Body

__all__ = ["cell_means", "fields", "visible_mesh"]

_KINDS = {
    ("RefTri", 3): "triangle",
    ("RefTri", 6): "triangle6",
    ("RefTet", 4): "tetra",
    ("RefTet", 10): "tetra10",
    ("RefQuad", 9): "quad9",
    ("RefHex", 27): "hexahedron27",
}

# Local coordinates of the nodes in VTK's order, doubled so that they are whole numbers.
_HEX = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
_HEX += [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2)]
_HEX += [(0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]
_HEX += [(0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)]
_PLACES = {
    "RefTri": [(0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)],
    "RefTet": [
        *((0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)),
        *((1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    ],
    "RefQuad": [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)],
    "RefHex": _HEX,
}


def visible_mesh(body: Body) -> VisibleMesh:
    """Nodes and cells of the body; a cell that is numbered the other way round is turned over."""
    grid = body.grid
    reference = grid.mesh.elem.refdom.__name__
    width = grid.nodes.shape[1]
    places = np.array(_PLACES[reference][:width], dtype=float) / 2.0
    right = _matching(places, grid.cell.element.doflocs)
    left = _matching(places[:, [1, 0, *range(2, places.shape[1])]], grid.cell.element.doflocs)
    jacobian = np.einsum(
        "xvc,vm->cxm", grid.mesh.p[:, grid.mesh.t[:, grid.order]], grid.cell.map_slopes[0, :, : grid.dimension]
    )
    turned = np.linalg.det(jacobian) < 0.0
    cells = np.where(turned[:, None], grid.nodes[:, left], grid.nodes[:, right])
    points = np.zeros((grid.n_nodes, 3))
    points[:, : grid.dimension] = grid.positions
    return VisibleMesh(points, cells, _KINDS[reference, width])


def fields(body: Body, displacement: Array, pressure: Array, kinematics: Kinematics) -> Mapping[str, Array]:
    """Displacement [m] at nodes, pressure [Pa] at nodes or on cells, stretch, J and fibre direction on cells."""
    grid = body.grid
    moved = np.zeros((grid.n_nodes, 3))
    moved[:, : grid.dimension] = displacement.reshape(-1, grid.dimension)
    found: dict[str, Any] = {"displacement": moved}
    if grid.n_multipliers:
        if body.enclosed:  # only differences mean anything: the mean is zero
            levels = grid.multipliers[:, :1] if grid.cell.multiplier == "P1disc" else grid.multipliers
            cells = np.bincount(levels.ravel(), minlength=grid.n_multipliers)
            pressure = pressure - np.average(pressure, weights=cells) * (cells > 0)
        # Hydrostatic pressure is positive in compression, the multiplier in tension.
        found["pressure"] = -_at_nodes(body, pressure) if grid.cell.multiplier == "P1" else -_on_cells(body, pressure)
    fibre = np.stack([cell_means(body, component) for component in body.fibre], axis=1)
    return found | {
        "stretch": cell_means(body, kinematics.stretch),
        "J": cell_means(body, kinematics.jacobian),
        "fibre": fibre / np.maximum(np.linalg.norm(fibre, axis=1, keepdims=True), 1e-300),
    }


def cell_means(body: Body, values: Array) -> Array:
    """Mean over each cell of values at the first points; NaN in cells that have none of them."""
    grid, n = body.grid, values.size
    cells, volumes = grid.cell_of_point[:n], grid.volumes[:n]
    total = np.bincount(cells, weights=volumes, minlength=grid.n_cells)
    sums = np.bincount(cells, weights=volumes * values, minlength=grid.n_cells)
    return np.divide(sums, total, out=np.full(grid.n_cells, np.nan), where=total > 0.0)


def _matching(places: Array, doflocs: Array) -> np.ndarray:
    """Number of the node of scikit-fem's element that stands at each place."""
    return np.linalg.norm(places[:, None] - doflocs[None], axis=2).argmin(axis=1)


def _at_nodes(body: Body, pressure: Array) -> Array:
    """Linear pressure at all displacement nodes."""
    grid = body.grid
    corner = grid.mesh.elem()
    places = grid.cell.element.doflocs.T
    values = np.stack([corner.lbasis(places, v)[0] for v in range(len(corner.doflocs))], axis=1)
    found = np.empty(grid.n_nodes)
    found[grid.nodes] = pressure[grid.multipliers] @ values.T
    return found


def _on_cells(body: Body, pressure: Array) -> Array:
    """Mean of a discontinuous pressure in each cell."""
    grid = body.grid
    weights = grid.cell.weights / grid.cell.weights.sum()
    return pressure[grid.multipliers] @ (weights @ grid.cell.shapes)
