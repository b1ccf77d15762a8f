"""A stiffness in blocks of three by three, one row and column of blocks a node of a body in space.

Supports leave nodes with one number or two. What rows belong together shows itself in the rigid motions, whose first
three are the translations: a node's numbers follow each other. Numbers that are missing become equations of their own,
``1 x = 0``, which nothing couples to the rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from myobridge.interfaces import Array

__all__ = ["in_node_blocks"]

SIZE = 3
"""Numbers of a node."""


def in_node_blocks(matrix: Any, rigid_motions: Array) -> tuple[Any, Array, Array]:
    """The matrix in blocks, the rigid motions to it, and the place of each row in them.

    Parameters
    ----------
    matrix : sparse matrix (CSR), shape (n, n)
    rigid_motions : ndarray, shape (n, 6)
        Three translations first, whose entries are 0 or 1.

    Returns
    -------
    blocks : sparse matrix (BSR), shape (3 m, 3 m)
    motions : ndarray, shape (3 m, 6)
    places : ndarray of int, shape (n,)
        ``blocks[places][:, places]`` is the matrix.
    """
    import scipy.sparse as sparse

    n = matrix.shape[0]
    component = np.argmax(np.abs(rigid_motions[:, :SIZE]), axis=1)
    node = np.concatenate([[0], np.cumsum(np.diff(component) <= 0)])
    places = SIZE * node + component
    whole = SIZE * (int(node[-1]) + 1)
    if whole == n:
        return matrix.tobsr((SIZE, SIZE)), rigid_motions, places
    motions = np.zeros((whole, rigid_motions.shape[1]))
    motions[places] = rigid_motions
    missing = np.setdiff1d(np.arange(whole), places)
    # Scaled like the rest, so that no smoother sees them as strange.
    diagonal = np.full(missing.size, float(np.abs(matrix.diagonal()).max()))
    entries = matrix.tocoo()
    rows = np.concatenate([places[entries.row], missing])
    columns = np.concatenate([places[entries.col], missing])
    padded: Any = sparse.csr_matrix((np.concatenate([entries.data, diagonal]), (rows, columns)), shape=(whole, whole))
    return padded.tobsr((SIZE, SIZE)), motions, places
