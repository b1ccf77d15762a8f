"""Discretisation: numbering of cells, nodes and points, in the order in which the kernels walk through them.

Cells are sorted by region, then along a space-filling curve, and nodes by the cell that touches them first: neighbours
in space are neighbours in memory, which halves the time of an assembly.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import attrs
import numpy as np

from myobridge.compiled import LANES
from myobridge.interfaces import Array
from myobridge_plugins.macro_solid.finite_element.element_pairs import ReferenceCell

__all__ = ["Discretisation", "discretise"]

# Batches of cells that one thread works on in one go.
_BLOCK = 12


@attrs.frozen(eq=False)
class Discretisation:
    """Numbered mesh.

    Attributes
    ----------
    mesh : skfem.Mesh
    cell : ReferenceCell
    order : ndarray, (n_cells,)
        Cell of the mesh that stands at each place.
    nodes, multipliers : ndarray, (n_cells, n_nodes) and (n_cells, n_multipliers)
        In the order above.
    positions : ndarray, (n_nodes, dim)
        Reference positions of the displacement nodes [m].
    n_multipliers : int
    sizes, starts : ndarray, (n_batches,)
        Cells of a batch and the number of its first point.
    first_cell : ndarray, (n_batches,)
        Place of the first cell of a batch.
    region_batches : sequence of (int, int)
        First and last batch of each region.
    """

    mesh: Any
    cell: ReferenceCell
    order: np.ndarray
    nodes: np.ndarray
    multipliers: np.ndarray
    positions: Array
    n_multipliers: int
    sizes: np.ndarray
    starts: np.ndarray
    first_cell: np.ndarray
    region_batches: Sequence[tuple[int, int]]

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.positions.shape[1]

    @property
    def n_cells(self) -> int:
        return self.order.size

    @property
    def n_nodes(self) -> int:
        return self.positions.shape[0]

    @property
    def n_points(self) -> int:
        """Quadrature points of all cells."""
        return self.n_cells * self.cell.weights.size

    @cached_property
    def corners(self) -> Array:
        """Corner positions in batches, (n_batches, 3 * n_corners * LANES)."""
        found = self.mesh.p[:, self.mesh.t[:, self.order]]  # (dim, n_corners, n_cells)
        full = np.zeros((3, found.shape[1], self.n_cells))
        full[: found.shape[0]] = found
        rows = full.transpose(2, 1, 0).reshape(self.n_cells, -1)
        return np.ascontiguousarray(self.batched(rows)).reshape(len(self.sizes), -1)

    def batched(self, rows: np.ndarray) -> np.ndarray:
        """Rows of the cells (n_cells, k) as (n_batches, k, LANES); lanes without a cell repeat the last one."""
        lanes = np.minimum(np.arange(LANES), self.sizes[:, None] - 1)
        return np.ascontiguousarray(rows[self.first_cell[:, None] + lanes].transpose(0, 2, 1))

    @cached_property
    def cell_of_point(self) -> np.ndarray:
        """Place of the cell of each point, (n_points,)."""
        n_q = self.cell.weights.size
        batch = np.repeat(np.arange(self.sizes.size), self.sizes * n_q)
        within = np.arange(self.n_points) - self.starts[batch]
        return self.first_cell[batch] + within % self.sizes[batch]

    @cached_property
    def quadrature_of_point(self) -> np.ndarray:
        """Number of the quadrature point within its cell, (n_points,)."""
        batch = np.repeat(np.arange(self.sizes.size), self.sizes * self.cell.weights.size)
        return (np.arange(self.n_points) - self.starts[batch]) // self.sizes[batch]

    @cached_property
    def volumes(self) -> Array:
        """Reference volume that each point stands for (2D: area), (n_points,)."""
        jacobian = np.einsum(
            "xvc,qvm->cqxm", self.mesh.p[:, self.mesh.t[:, self.order]], self.cell.map_slopes[:, :, : self.dimension]
        )
        of_cells = np.abs(np.linalg.det(jacobian)) * self.cell.weights
        return of_cells[self.cell_of_point, self.quadrature_of_point]

    @cached_property
    def point_positions(self) -> Array:
        """Reference position of each point [m], (n_points, dim)."""
        found = np.einsum("cax,qa->cqx", self.positions[self.nodes], self.cell.values)
        return found[self.cell_of_point, self.quadrature_of_point]

    def blocks(self, region: int) -> tuple[np.ndarray, np.ndarray]:
        """Blocks of batches (n_blocks, 2) of a region, sorted by colour, and where each colour begins."""
        first, last = self.region_batches[region]
        starts = np.arange(first, last, _BLOCK)
        ends = np.minimum(starts + _BLOCK, last)
        cells = np.append(self.first_cell, self.n_cells)
        colour = _colours([np.unique(self.nodes[cells[a] : cells[b]]) for a, b in zip(starts, ends, strict=True)])
        order = np.argsort(colour, kind="stable")
        bounds = np.searchsorted(colour[order], np.arange(colour.max() + 2)) if colour.size else np.zeros(1)
        return np.stack([starts, ends], axis=1)[order].astype(np.int32), bounds.astype(np.int32)


def discretise(mesh: Any, cell: ReferenceCell, regions: Sequence[np.ndarray]) -> Discretisation:
    """Number a mesh whose cells are divided into `regions` (numbers of cells, each cell once)."""
    from skfem.assembly.dofs import Dofs

    centres = mesh.p[:, mesh.t].mean(axis=1)
    order = np.concatenate([cells[np.argsort(_curve(centres, cells), kind="stable")] for cells in regions])
    dofs = Dofs(mesh, cell.element)
    nodes, n_nodes = _renumbered(dofs.element_dofs.T[order])
    assert n_nodes == dofs.N
    positions = np.empty((n_nodes, mesh.p.shape[0]))
    corner_values = _corner_values(mesh, cell.element.doflocs)
    positions[nodes] = np.einsum("xvc,av->cax", mesh.p[:, mesh.t[:, order]], corner_values)
    multipliers, n_multipliers = _multipliers(mesh, cell, order)
    sizes = [_sizes(len(cells)) for cells in regions]
    bounds = np.cumsum([0, *(len(part) for part in sizes)])
    lanes = np.concatenate(sizes).astype(np.int32)
    first = np.concatenate([[0], np.cumsum(lanes)[:-1]])
    return Discretisation(
        mesh,
        cell,
        order,
        nodes.astype(np.int32),
        multipliers.astype(np.int32),
        positions,
        n_multipliers,
        lanes,
        (first * cell.weights.size).astype(np.int32),
        first,
        [(int(a), int(b)) for a, b in itertools.pairwise(bounds)],
    )


def _sizes(n_cells: int) -> np.ndarray:
    full, rest = divmod(n_cells, LANES)
    return np.array([LANES] * full + [rest] * (rest > 0))


def _renumbered(table: np.ndarray) -> tuple[np.ndarray, int]:
    """The same table with numbers given in the order of first appearance."""
    found, first, inverse = np.unique(table, return_index=True, return_inverse=True)
    rank = np.empty(found.size, dtype=np.int64)
    rank[np.argsort(first)] = np.arange(found.size)
    return rank[inverse].reshape(table.shape), found.size


def _multipliers(mesh: Any, cell: ReferenceCell, order: np.ndarray) -> tuple[np.ndarray, int]:
    n_shapes, n_cells = cell.shapes.shape[1], order.size
    if cell.multiplier == "P1":
        return _renumbered(mesh.t.T[order])
    return np.arange(n_cells * n_shapes).reshape(n_cells, n_shapes), n_cells * n_shapes


def _corner_values(mesh: Any, places: Array) -> Array:
    corner = mesh.elem()
    return np.stack([corner.lbasis(places.T, v)[0] for v in range(len(corner.doflocs))], axis=1)


def _curve(centres: Array, cells: np.ndarray) -> np.ndarray:
    """Place of the given cells along a Morton curve: interleaved bits of their coordinates."""
    found = centres[:, cells]
    extent = np.ptp(found, axis=1).max() if cells.size else 1.0
    steps = ((found - found.min(axis=1, keepdims=True)) / (extent or 1.0) * 1023.0).astype(np.int64)
    key = np.zeros(cells.size, dtype=np.int64)
    for bit in range(10):
        for axis, step in enumerate(steps):
            key |= ((step >> bit) & 1) << (bit * len(steps) + axis)
    return key


def _colours(touched: Sequence[np.ndarray]) -> np.ndarray:
    """Smallest colour of each block that no block with a common node has."""
    n_nodes = max((int(nodes.max()) + 1 for nodes in touched if nodes.size), default=0)
    used = np.zeros(n_nodes, dtype=np.int64)  # bit c: a block of colour c touches the node
    colours = np.empty(len(touched), dtype=np.int64)
    for block, nodes in enumerate(touched):
        taken = int(np.bitwise_or.reduce(used[nodes])) if nodes.size else 0
        colour = 0
        while taken >> colour & 1:
            colour += 1
        colours[block] = colour
        used[nodes] |= 1 << colour
    return colours
