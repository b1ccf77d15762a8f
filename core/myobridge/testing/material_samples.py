"""Deformation gradients and fibre directions on which the checks of a material run."""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array

__all__ = ["random_deformations", "random_rotations"]


def random_rotations(generator: np.random.Generator, n: int) -> Array:
    """Rotations, uniformly spread, shape (n, 3, 3)."""
    q, r = np.linalg.qr(generator.standard_normal((n, 3, 3)))
    q = q * np.sign(np.einsum("nii->ni", r))[:, None, :]
    return q * np.linalg.det(q)[:, None, None]


def random_deformations(
    generator: np.random.Generator, n: int, low: float = 0.75, high: float = 1.35, gap: float = 0.0
) -> tuple[Array, Array]:
    r"""Deformation gradients and fibre directions.

    .. math:: F = R\,diag(s_1, s_2, s_3)\,Q, \qquad low \le s_i \le high

    with random rotations R and Q, shape (n, 3, 3), and random unit vectors N, shape (n, 3). Where fibres are within
    `gap` of their length, abs(I4 - 1) < gap, the point is stretched beyond: laws that switch there have a kink.
    """
    stretches = generator.uniform(low, high, (n, 3))
    gradient = random_rotations(generator, n) * stretches[:, None, :] @ random_rotations(generator, n)
    direction = generator.standard_normal((n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    fourth = np.einsum("nij,nj->ni", gradient, direction)
    near = np.abs(np.sum(fourth**2, axis=1) - 1.0) < gap
    return gradient * np.where(near, 1.0 + 2.0 * gap, 1.0)[:, None, None], direction
