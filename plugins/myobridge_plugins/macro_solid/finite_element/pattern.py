"""Sparse pattern: where the entry of every pair of nodes stands, worked out once for a mesh.

Only rows and columns of free numbers exist: what supports hold is never stored. The free rows of one node have the same
columns, in which the free numbers of a neighbour stand side by side. A kernel therefore needs one small number for a
pair of nodes, the place of the first of them within the row, and not one for each of its ``dim * dim`` entries. The
rows of the constraint's gradient are kept in the same way.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from myobridge.interfaces import Array
from myobridge_plugins.macro_solid.finite_element.discretisation import Discretisation

__all__ = ["Pattern", "SparseRows", "pattern"]


@attrs.frozen(eq=False)
class SparseRows:
    """Pattern of one matrix in compressed rows, and where the kernels find their entries.

    Attributes
    ----------
    rows : ndarray
        First entry of the row of every number; -1 for those that are held.
    places : ndarray, (n_batches, pairs, LANES)
        Place of the first column of the pair (left node, right node) within the row.
    indptr, indices, shape :
        The pattern of the free part, as `scipy.sparse` has it.
    """

    rows: np.ndarray
    places: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    shape: tuple[int, int]

    @property
    def size(self) -> int:
        """Entries."""
        return self.indices.size

    def matrix(self, data: Array) -> Any:
        """The matrix with the given data, which it keeps, as a CSR array."""
        import scipy.sparse as sparse

        return sparse.csr_array((data, self.indices, self.indptr), shape=self.shape)


@attrs.frozen(eq=False)
class Pattern:
    """Pattern of stiffness and constraint gradient.

    Attributes
    ----------
    stiffness, gradient : SparseRows
    lengths : ndarray, (n_nodes,)
        Entries in a row of each node whose numbers are all free; 0 for the other nodes.
    """

    stiffness: SparseRows
    gradient: SparseRows
    lengths: np.ndarray


def pattern(discretisation: Discretisation, free: np.ndarray, free_multipliers: np.ndarray) -> Pattern:
    """Pattern of a discretisation whose unknowns are the sorted numbers `free` and `free_multipliers`."""
    nodes, multipliers, d = discretisation.nodes, discretisation.multipliers, discretisation.dimension
    moving, kept = np.zeros((discretisation.n_nodes, d), dtype=bool), np.zeros(discretisation.n_multipliers, dtype=bool)
    moving.flat[free] = True
    kept[free_multipliers] = True
    stiffness, lengths = _sparse_rows(discretisation, nodes, moving, moving)
    gradient, _ = _sparse_rows(discretisation, multipliers, kept[:, None], moving)
    return Pattern(stiffness, gradient, np.where(moving.all(axis=1), lengths, 0).astype(np.int32))


def _sparse_rows(
    discretisation: Discretisation, left: np.ndarray, free_left: np.ndarray, free_right: np.ndarray
) -> tuple[SparseRows, np.ndarray]:
    """Rows of the numbers of `left` (n_cells, ...) against those of all nodes, and the length of each one's rows.

    `free_left` and `free_right`, (n, numbers of each), tell which numbers are free.
    """
    right, shape = discretisation.nodes, (int(free_left.sum()), int(free_right.sum()))
    starts, columns, pairs = _neighbours(left, right, len(free_left), len(free_right))
    widths = free_right.sum(axis=1)[columns]
    ends = np.concatenate([[0], np.cumsum(widths)])
    lengths = np.diff(ends[starts])
    of_numbers = np.where(free_left, lengths[:, None], 0).ravel()
    bounds = np.concatenate([[0], np.cumsum(of_numbers)])
    if bounds[-1] >= 2**31:
        raise MemoryError(f"a matrix of {shape[0]:,} rows has {bounds[-1]:,} entries; use a coarser mesh")
    within = (ends[pairs] - np.repeat(ends[starts[left]], right.shape[1], axis=1)).astype(np.int16)
    # Free columns of the rows of each node, and those of every free row.
    number = np.cumsum(free_right).reshape(free_right.shape) - 1
    of_nodes = number[columns][free_right[columns]].astype(np.int32)
    owner = np.flatnonzero(free_left) // free_left.shape[1]
    long = lengths[owner]
    indptr = np.concatenate([[0], np.cumsum(long)])
    indices = of_nodes[np.arange(indptr[-1]) + np.repeat(ends[starts[owner]] - indptr[:-1], long)]
    rows = np.where(free_left.ravel(), bounds[:-1], -1).astype(np.int32)
    return SparseRows(rows, discretisation.batched(within), indptr.astype(np.int32), indices, shape), lengths


def _neighbours(
    left: np.ndarray, right: np.ndarray, n_left: int, n_right: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First neighbour of each row (n_left + 1,), sorted neighbours, and the one of each pair (cell, a * n + b)."""
    keys = left[:, :, None].astype(np.int64) * n_right + right[:, None, :]
    found, inverse = np.unique(keys, return_inverse=True)
    starts = np.searchsorted(found // n_right, np.arange(n_left + 1))
    return starts, found % n_right, inverse.reshape(len(left), -1)
