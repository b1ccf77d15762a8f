"""What happens on the elements of one batch, side by side on lanes: gather, geometry, gradients, deformation."""

from __future__ import annotations

from numba import njit

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.lane_vectors import absolute, load, spread, store
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER

__all__ = ["deformation", "gather", "gather_scalars", "shape_gradients", "volume_and_inverse"]

_L = LANES


@njit(**INNER)
def gather(dimension, n_nodes, nodes, field, local):
    """Nodal vectors of a batch in rows ``3 a + i`` of `local`; the third component of a plane field is zero."""
    for a in range(n_nodes):
        for i in range(3):
            row = (3 * a + i) * _L
            for lane in range(_L):
                local[row + lane] = field[dimension * nodes[a, lane] + i] if i < dimension else 0.0


@njit(**INNER)
def gather_scalars(numbers, field, local):
    """Numbers of a batch in the rows of `local`."""
    for k in range(numbers.shape[0]):
        for lane in range(_L):
            local[k * _L + lane] = field[numbers[k, lane]]


@njit(**INNER)
def volume_and_inverse(dimension, slopes, corners, inverse, volume):
    """Inverse Jacobian, d xi_m / d X_J in row ``3 m + J``, and the ratio of volumes, from the corners of the cells.

    A plane cell gets the third direction as its own.
    """
    j00 = j01 = j02 = j10 = j11 = j12 = j20 = j21 = spread(0.0)
    j22 = spread(1.0 if dimension == 2 else 0.0)
    for v in range(slopes.shape[0]):
        a, b, c = slopes[v, 0], slopes[v, 1], slopes[v, 2]
        x, y, z = load(corners, 3 * v), load(corners, 3 * v + 1), load(corners, 3 * v + 2)
        j00, j01, j02 = j00 + x * a, j01 + x * b, j02 + x * c
        j10, j11, j12 = j10 + y * a, j11 + y * b, j12 + y * c
        j20, j21, j22 = j20 + z * a, j21 + z * b, j22 + z * c
    c00 = j11 * j22 - j12 * j21
    c01 = j12 * j20 - j10 * j22
    c02 = j10 * j21 - j11 * j20
    determinant = j00 * c00 + j01 * c01 + j02 * c02
    over = 1.0 / determinant
    store(volume, 0, absolute(determinant))
    store(inverse, 0, c00 * over)
    store(inverse, 1, (j02 * j21 - j01 * j22) * over)
    store(inverse, 2, (j01 * j12 - j02 * j11) * over)
    store(inverse, 3, c01 * over)
    store(inverse, 4, (j00 * j22 - j02 * j20) * over)
    store(inverse, 5, (j02 * j10 - j00 * j12) * over)
    store(inverse, 6, c02 * over)
    store(inverse, 7, (j01 * j20 - j00 * j21) * over)
    store(inverse, 8, (j00 * j11 - j01 * j10) * over)


@njit(**INNER)
def shape_gradients(n_nodes, slopes, inverse, gradients):
    """Gradients of the shape functions in the reference body, rows ``3 a + J``."""
    for a in range(n_nodes):
        x, y, z = slopes[a, 0], slopes[a, 1], slopes[a, 2]
        for J in range(3):
            found = x * load(inverse, J) + y * load(inverse, 3 + J) + z * load(inverse, 6 + J)
            store(gradients, 3 * a + J, found)


@njit(**INNER)
def deformation(one, n_nodes, local, gradients, state):
    """Gradient of a nodal field plus `one` on the diagonal, in rows 0-8: F with 1, its change with 0."""
    f01 = f02 = f10 = f12 = f20 = f21 = spread(0.0)
    f00 = f11 = f22 = spread(one)
    for a in range(n_nodes):
        u, v, w = load(local, 3 * a), load(local, 3 * a + 1), load(local, 3 * a + 2)
        x, y, z = load(gradients, 3 * a), load(gradients, 3 * a + 1), load(gradients, 3 * a + 2)
        f00, f01, f02 = f00 + u * x, f01 + u * y, f02 + u * z
        f10, f11, f12 = f10 + v * x, f11 + v * y, f12 + v * z
        f20, f21, f22 = f20 + w * x, f21 + w * y, f22 + w * z
    store(state, 0, f00)
    store(state, 1, f01)
    store(state, 2, f02)
    store(state, 3, f10)
    store(state, 4, f11)
    store(state, 5, f12)
    store(state, 6, f20)
    store(state, 7, f21)
    store(state, 8, f22)
