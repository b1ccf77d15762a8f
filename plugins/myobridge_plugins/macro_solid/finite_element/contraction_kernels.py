r"""Contraction of stress and tangent with the gradients of the shape functions, on lanes.

.. math:: R_{ai} = \int P_{iJ} G_{aJ}, \qquad K_{aibk} = \int G_{aJ}\,A_{iJkL}\,G_{bL}, \qquad
          B_{kai} = \int \psi_k\,\mathrm{cof} F_{iJ}\,G_{aJ}

Rows of `LANES` numbers. Node `a` has its gradient in rows ``3 a + J``; the pair of nodes (a, b), a <= b, has its block
in rows ``9 pair + 3 i + k``. The first step of K, :math:`w\,G_{aJ} A_{iJkL}`, is 27 vectors that stay in registers for
all `b`: what is written out is the 32 registers of the machine.
"""

from __future__ import annotations

from numba import njit

from myobridge_plugins.macro_solid.finite_element.lane_vectors import add_to, inlined, load, product_with, store
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER

__all__ = ["add_constraint", "add_dilation", "add_force", "add_stiffness", "add_whole_stiffness"]


@inlined
def _weighted(volume, slopes, a):
    """Gradient of a node times the volume."""
    w = load(volume, 0)
    return w * load(slopes, 3 * a), w * load(slopes, 3 * a + 1), w * load(slopes, 3 * a + 2)


@njit(**INNER)
def add_force(n_nodes, volume, slopes, stress, force):
    """Add ``P G`` of every node to rows ``3 a + i`` of `force`."""
    for a in range(n_nodes):
        g = _weighted(volume, slopes, a)
        add_to(force, 3 * a, product_with(g, stress, 0, 1, 2))
        add_to(force, 3 * a + 1, product_with(g, stress, 3, 4, 5))
        add_to(force, 3 * a + 2, product_with(g, stress, 6, 7, 8))


@njit(**INNER)
def add_dilation(volume, shapes, jacobian, constraint):
    """Add ``psi (J - 1)`` to the row of every multiplier."""
    change = load(volume, 0) * (load(jacobian, 0) - 1.0)
    for k in range(shapes.shape[0]):
        add_to(constraint, k, shapes[k] * change)


@njit(**INNER)
def add_constraint(n_nodes, volume, slopes, shapes, cofactor, gradient):
    """Add ``psi cof F G`` to rows ``3 (k n_nodes + a) + i`` of `gradient`."""
    for a in range(n_nodes):
        g = _weighted(volume, slopes, a)
        x, y, z = (
            product_with(g, cofactor, 0, 1, 2),
            product_with(g, cofactor, 3, 4, 5),
            product_with(g, cofactor, 6, 7, 8),
        )
        for k in range(shapes.shape[0]):
            row, psi = 3 * (k * n_nodes + a), shapes[k]
            add_to(gradient, row, psi * x)
            add_to(gradient, row + 1, psi * y)
            add_to(gradient, row + 2, psi * z)


@njit(**INNER)
def add_stiffness(n_nodes, volume, slopes, tangent, half, stiffness):
    """Add ``G A G`` of every pair of nodes a <= b to the blocks of `stiffness`; `half` is scratch of 27 rows."""
    pair = 0
    for a in range(n_nodes):
        g = _weighted(volume, slopes, a)
        store(half, 0, product_with(g, tangent, 9, 10, 11))
        store(half, 1, product_with(g, tangent, 10, 18, 19))
        store(half, 2, product_with(g, tangent, 11, 19, 26))
        store(half, 3, product_with(g, tangent, 12, 20, 27))
        store(half, 4, product_with(g, tangent, 13, 21, 28))
        store(half, 5, product_with(g, tangent, 14, 22, 29))
        store(half, 6, product_with(g, tangent, 15, 23, 30))
        store(half, 7, product_with(g, tangent, 16, 24, 31))
        store(half, 8, product_with(g, tangent, 17, 25, 32))
        store(half, 9, product_with(g, tangent, 12, 13, 14))
        store(half, 10, product_with(g, tangent, 20, 21, 22))
        store(half, 11, product_with(g, tangent, 27, 28, 29))
        store(half, 12, product_with(g, tangent, 33, 34, 35))
        store(half, 13, product_with(g, tangent, 34, 39, 40))
        store(half, 14, product_with(g, tangent, 35, 40, 44))
        store(half, 15, product_with(g, tangent, 36, 41, 45))
        store(half, 16, product_with(g, tangent, 37, 42, 46))
        store(half, 17, product_with(g, tangent, 38, 43, 47))
        store(half, 18, product_with(g, tangent, 15, 16, 17))
        store(half, 19, product_with(g, tangent, 23, 24, 25))
        store(half, 20, product_with(g, tangent, 30, 31, 32))
        store(half, 21, product_with(g, tangent, 36, 37, 38))
        store(half, 22, product_with(g, tangent, 41, 42, 43))
        store(half, 23, product_with(g, tangent, 45, 46, 47))
        store(half, 24, product_with(g, tangent, 48, 49, 50))
        store(half, 25, product_with(g, tangent, 49, 51, 52))
        store(half, 26, product_with(g, tangent, 50, 52, 53))
        _add_blocks(a, n_nodes, pair, slopes, half, stiffness)
        pair += n_nodes - a


@njit(**INNER)
def add_whole_stiffness(n_nodes, volume, slopes, whole, half, stiffness):
    """Add ``G A G`` of every pair of nodes where A has no symmetry: all 81 entries in, all pairs ``a n_nodes + b`` out.

    Row ``9 (3 i + J) + 3 k + L`` of `whole` has A; `half` is scratch of 27 rows.
    """
    for a in range(n_nodes):
        g = _weighted(volume, slopes, a)
        for i in range(3):
            for c in range(27 * i, 27 * i + 9):
                store(half, c - 18 * i, product_with(g, whole, c, c + 9, c + 18))
        _add_blocks(0, n_nodes, a * n_nodes, slopes, half, stiffness)


@njit(**INNER)
def _add_blocks(first, last, pair, slopes, half, stiffness):
    """Second step of K for one `a` and the nodes b from `first` to before `last`; the blocks begin at `pair`."""
    h0, h1, h2 = _nine(half, 0), _nine(half, 9), _nine(half, 18)
    for b in range(first, last):
        g = load(slopes, 3 * b), load(slopes, 3 * b + 1), load(slopes, 3 * b + 2)
        _add_row(g, h0, stiffness, 9 * pair)
        _add_row(g, h1, stiffness, 9 * pair + 3)
        _add_row(g, h2, stiffness, 9 * pair + 6)
        pair += 1


@inlined
def _nine(rows, at):
    return (
        *(load(rows, at), load(rows, at + 1), load(rows, at + 2)),
        *(load(rows, at + 3), load(rows, at + 4), load(rows, at + 5)),
        *(load(rows, at + 6), load(rows, at + 7), load(rows, at + 8)),
    )


@inlined
def _add_row(g, h, stiffness, row):
    add_to(stiffness, row, g[0] * h[0] + g[1] * h[1] + g[2] * h[2])
    add_to(stiffness, row + 1, g[0] * h[3] + g[1] * h[4] + g[2] * h[5])
    add_to(stiffness, row + 2, g[0] * h[6] + g[1] * h[7] + g[2] * h[8])
