"""What happens on the elements of one batch, side by side on lanes: gather, geometry, gradients, deformation."""

from __future__ import annotations

from numba import njit

from myobridge.compiled import LANES
from myobridge_plugins.macro_solid.finite_element.point_kernels import INNER

__all__ = ["add_deformation", "gather", "identity", "shape_gradients", "volume_and_inverse"]

_L = LANES


@njit(**INNER)
def gather(n, dimension, n_nodes, nodes, field, local):
    """Nodal vectors of a batch in rows ``3 a + i`` of `local`; the third component of a plane field is zero."""
    for a in range(n_nodes):
        for i in range(dimension):
            row = (3 * a + i) * _L
            for lane in range(n):
                local[row + lane] = field[dimension * nodes[a, lane] + i]
        for i in range(dimension, 3):
            row = (3 * a + i) * _L
            for lane in range(n):
                local[row + lane] = 0.0


@njit(**INNER)
def volume_and_inverse(n, dimension, slopes, corners, inverse, volume):
    """Inverse Jacobian, d xi_m / d X_J in row ``3 m + J``, and the ratio of volumes, from the corners of the cells.

    A plane cell gets the third direction as its own.
    """
    jacobian = inverse
    for row in range(9):
        start = 1.0 if row == 8 and dimension == 2 else 0.0
        for lane in range(n):
            jacobian[row * _L + lane] = start
    for v in range(slopes.shape[0]):
        a, b, c = slopes[v, 0], slopes[v, 1], slopes[v, 2]
        x = corners[3 * v * _L : (3 * v + 3) * _L]
        for lane in range(n):
            jacobian[0 * _L + lane] += x[lane] * a
            jacobian[1 * _L + lane] += x[lane] * b
            jacobian[2 * _L + lane] += x[lane] * c
            jacobian[3 * _L + lane] += x[_L + lane] * a
            jacobian[4 * _L + lane] += x[_L + lane] * b
            jacobian[5 * _L + lane] += x[_L + lane] * c
            jacobian[6 * _L + lane] += x[2 * _L + lane] * a
            jacobian[7 * _L + lane] += x[2 * _L + lane] * b
            jacobian[8 * _L + lane] += x[2 * _L + lane] * c
    for lane in range(n):
        j00 = jacobian[0 * _L + lane]
        j01 = jacobian[1 * _L + lane]
        j02 = jacobian[2 * _L + lane]
        j10 = jacobian[3 * _L + lane]
        j11 = jacobian[4 * _L + lane]
        j12 = jacobian[5 * _L + lane]
        j20 = jacobian[6 * _L + lane]
        j21 = jacobian[7 * _L + lane]
        j22 = jacobian[8 * _L + lane]
        c00 = j11 * j22 - j12 * j21
        c01 = j12 * j20 - j10 * j22
        c02 = j10 * j21 - j11 * j20
        determinant = j00 * c00 + j01 * c01 + j02 * c02
        over = 1.0 / determinant
        volume[lane] = abs(determinant)
        inverse[0 * _L + lane] = c00 * over
        inverse[1 * _L + lane] = (j02 * j21 - j01 * j22) * over
        inverse[2 * _L + lane] = (j01 * j12 - j02 * j11) * over
        inverse[3 * _L + lane] = c01 * over
        inverse[4 * _L + lane] = (j00 * j22 - j02 * j20) * over
        inverse[5 * _L + lane] = (j02 * j10 - j00 * j12) * over
        inverse[6 * _L + lane] = c02 * over
        inverse[7 * _L + lane] = (j01 * j20 - j00 * j21) * over
        inverse[8 * _L + lane] = (j00 * j11 - j01 * j10) * over


@njit(**INNER)
def shape_gradients(n, n_nodes, slopes, inverse, gradients):
    """Gradients of the shape functions in the reference body, rows ``3 a + J``."""
    for a in range(n_nodes):
        x, y, z = slopes[a, 0], slopes[a, 1], slopes[a, 2]
        g = gradients[3 * a * _L : (3 * a + 3) * _L]
        for lane in range(n):
            g[lane] = x * inverse[0 * _L + lane] + y * inverse[3 * _L + lane] + z * inverse[6 * _L + lane]
            g[_L + lane] = x * inverse[1 * _L + lane] + y * inverse[4 * _L + lane] + z * inverse[7 * _L + lane]
            g[2 * _L + lane] = x * inverse[2 * _L + lane] + y * inverse[5 * _L + lane] + z * inverse[8 * _L + lane]


@njit(**INNER)
def identity(n, state):
    """F = 1 in rows 0-8."""
    for row in range(9):
        value = 1.0 if row % 4 == 0 else 0.0
        for lane in range(n):
            state[row * _L + lane] = value


@njit(**INNER)
def add_deformation(n, n_nodes, local, gradients, state):
    """Add the displacement gradient to rows 0-8."""
    for a in range(n_nodes):
        u = local[3 * a * _L : (3 * a + 3) * _L]
        g = gradients[3 * a * _L : (3 * a + 3) * _L]
        for lane in range(n):
            state[0 * _L + lane] += u[lane] * g[lane]
            state[1 * _L + lane] += u[lane] * g[_L + lane]
            state[2 * _L + lane] += u[lane] * g[2 * _L + lane]
            state[3 * _L + lane] += u[_L + lane] * g[lane]
            state[4 * _L + lane] += u[_L + lane] * g[_L + lane]
            state[5 * _L + lane] += u[_L + lane] * g[2 * _L + lane]
            state[6 * _L + lane] += u[2 * _L + lane] * g[lane]
            state[7 * _L + lane] += u[2 * _L + lane] * g[_L + lane]
            state[8 * _L + lane] += u[2 * _L + lane] * g[2 * _L + lane]
