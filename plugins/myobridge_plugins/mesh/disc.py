"""Mesh of the unit disc by quadrilaterals: a square in the middle, a ring of cells around it."""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array

__all__ = ["INNER", "disc"]

INNER = 0.55
"""Half diagonal of the square in the middle."""

# How far the sides of the square bulge towards the circle: the worst angles are best here.
_BULGE = 0.35


def disc(across: int) -> tuple[Array, np.ndarray]:
    """Nodes (2, n_nodes) and quadrilaterals (4, n_cells), anticlockwise; the circle carries ``4 across`` edges.

    The square has `across` by `across` cells, the ring half as many layers, at least one.
    """
    layers = max(round(across / 2), 1)
    steps = np.linspace(-1.0, 1.0, across + 1)
    x, y = (item.ravel() for item in np.meshgrid(steps, steps))
    ring = _ring(across)
    # Rings of the square: shares of the way from its centre, straight inside and bulging towards its rim.
    size = np.maximum(np.abs(x), np.abs(y))
    angle = np.where(size > 0.0, _angle(x, y), 0.0)
    square = INNER * np.stack([x, y]) / np.sqrt(2.0)
    circle = INNER * size * np.stack([np.cos(angle), np.sin(angle)])
    inner = square + _BULGE * size * (circle - square)
    rim = inner[:, ring]
    angles = _angle(x[ring], y[ring])
    outer = np.stack([np.cos(angles), np.sin(angles)])
    shares = np.arange(1, layers + 1) / layers
    around = rim[:, None, :] + shares[None, :, None] * (outer - rim)[:, None, :]
    points = np.hstack([inner, around.reshape(2, -1)])

    numbers = np.arange((across + 1) ** 2).reshape(across + 1, across + 1)
    inside = [numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]]
    rows = np.vstack([ring, (across + 1) ** 2 + np.arange(layers * 4 * across).reshape(layers, -1)])
    turned = np.roll(rows, -1, axis=1)
    between = [rows[:-1], rows[1:], turned[1:], turned[:-1]]
    return points, np.hstack([np.stack([item.ravel() for item in part]) for part in (inside, between)])


def _ring(across: int) -> np.ndarray:
    """Nodes of the rim of the square, anticlockwise from its lower left corner."""
    numbers = np.arange((across + 1) ** 2).reshape(across + 1, across + 1)
    return np.concatenate([numbers[0, :-1], numbers[:-1, -1], numbers[-1, :0:-1], numbers[:0:-1, 0]])


def _angle(x: Array, y: Array) -> Array:
    """Angle on the circle for a place on the square: equal steps along a side are equal angles."""
    size = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.finfo(float).tiny)
    flat = np.abs(x) >= np.abs(y)
    share = np.where(flat, y, x) / size
    quarter = 0.25 * np.pi * share
    beside = np.where(x >= 0.0, quarter, np.pi - quarter)
    above = np.where(y >= 0.0, 0.5 * np.pi - quarter, -0.5 * np.pi + quarter)
    return np.where(flat, beside, above)
