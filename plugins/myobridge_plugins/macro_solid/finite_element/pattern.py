"""Sparse pattern: where the entry of every pair of nodes stands, worked out once for a mesh.

Rows of the stiffness come in groups of ``dim``, one group a node: row ``dim * a + i`` has one column block of width
``dim`` for every node that shares a cell with `a`. A kernel therefore needs one small number for a pair of nodes, its
place within the row, and not one for each of its ``dim * dim`` entries. The rows of the constraint's gradient are kept
in the same way. What supports hold is left out at the end, by one indexing of the data.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from myobridge.interfaces import Array
from myobridge_plugins.macro_solid.finite_element.discretisation import Discretisation

__all__ = ["FreePart", "Pattern", "pattern"]


@attrs.frozen(eq=False)
class FreePart:
    """Rows and columns of a sparse matrix that are free: which of its data stay, and the pattern that they have."""

    kept: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    shape: tuple[int, int]

    def matrix(self, data: Array) -> Any:
        """The free part of a matrix with the given data, as a CSR array."""
        import scipy.sparse as sparse

        return sparse.csr_array((data[self.kept], self.indices, self.indptr), shape=self.shape)


@attrs.frozen(eq=False)
class Pattern:
    """Pattern of stiffness and constraint gradient.

    Attributes
    ----------
    starts, gradient_starts : ndarray, (n_nodes + 1,) and (n_multipliers + 1,)
        First neighbour of each node, and of each multiplier.
    places, gradient_places : ndarray, (n_batches, pairs, LANES)
        Place of the pair (a, b), and of (multiplier, b), within the row.
    stiffness, gradient : FreePart
    size, gradient_size : int
        Entries before anything is left out.
    """

    starts: np.ndarray
    places: np.ndarray
    gradient_starts: np.ndarray
    gradient_places: np.ndarray
    stiffness: FreePart
    gradient: FreePart
    size: int
    gradient_size: int


def pattern(discretisation: Discretisation, free: np.ndarray, free_multipliers: np.ndarray) -> Pattern:
    """Pattern of a discretisation whose unknowns are the numbers `free` and `free_multipliers`."""
    nodes, multipliers = discretisation.nodes, discretisation.multipliers
    n_nodes, d = discretisation.n_nodes, discretisation.dimension
    starts, columns, places = _rows(nodes, nodes, n_nodes, n_nodes)
    if multipliers.shape[1]:
        rows = _rows(multipliers, nodes, discretisation.n_multipliers, n_nodes)
    else:
        rows = np.zeros(1, dtype=np.int32), np.zeros(0, dtype=np.int32), np.zeros((len(nodes), 0), dtype=np.int16)
    gradient_starts, gradient_columns, gradient_places = rows
    size, gradient_size = d * d * columns.size, d * gradient_columns.size
    if size >= 2**31:
        raise MemoryError(f"the stiffness matrix of {n_nodes:,} nodes has {size:,} entries; use a coarser mesh")
    return Pattern(
        starts,
        discretisation.batched(places),
        gradient_starts,
        discretisation.batched(gradient_places),
        _free_part(starts, columns, d, d, free, free, n_nodes),
        _free_part(gradient_starts, gradient_columns, 1, d, free_multipliers, free, n_nodes),
        size,
        gradient_size,
    )


def _rows(left: np.ndarray, right: np.ndarray, n_left: int, n_right: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row starts, sorted columns, and the place of every pair (cell, a * n + b) within its row."""
    keys = left[:, :, None].astype(np.int64) * n_right + right[:, None, :]
    found, inverse = np.unique(keys, return_inverse=True)
    rows = found // n_right
    starts = np.searchsorted(rows, np.arange(n_left + 1))
    inverse = inverse.reshape(len(left), -1)
    within = inverse - np.repeat(starts[left], right.shape[1], axis=1)
    return starts.astype(np.int32), (found % n_right).astype(np.int32), within.astype(np.int16)


def _free_part(
    starts: np.ndarray,
    columns: np.ndarray,
    row_width: int,
    column_width: int,
    free_rows: np.ndarray,
    free_columns: np.ndarray,
    n_nodes: int,
) -> FreePart:
    """Free part of the scalar matrix whose node pattern is given."""
    lengths = np.diff(starts)
    n_rows = row_width * lengths.size
    # Scalar columns of one row of each node, then that row `row_width` times.
    wide = (column_width * columns[:, None] + np.arange(column_width, dtype=np.int32)).ravel()
    if row_width == 1:
        rows = np.repeat(np.arange(n_rows), column_width * lengths)
    else:
        begin = np.repeat(column_width * starts[:-1], row_width)
        long = np.repeat(column_width * lengths, row_width)
        offset = np.concatenate([[0], np.cumsum(long)])
        rows = np.repeat(np.arange(n_rows), long)
        wide = wide[np.arange(offset[-1]) - np.repeat(offset[:-1], long) + np.repeat(begin, long)]
    new_row, new_column = np.full(n_rows, -1), np.full(column_width * n_nodes, -1)
    new_row[free_rows] = np.arange(free_rows.size)
    new_column[free_columns] = np.arange(free_columns.size)
    kept = np.flatnonzero((new_row[rows] >= 0) & (new_column[wide] >= 0))
    counts = np.bincount(new_row[rows[kept]], minlength=free_rows.size)
    indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    return FreePart(
        kept.astype(np.int32), indptr, new_column[wide[kept]].astype(np.int32), (free_rows.size, free_columns.size)
    )
