"""Momenta of a body, and the motions that deform nothing."""

from __future__ import annotations

from typing import Any

import numpy as np

from myobridge.interfaces import Array, Motion
from myobridge_plugins.macro_solid.finite_element.body import Body

__all__ = ["angular_momentum", "node_momentum", "rigid_motions"]


def node_momentum(body: Body, mass: Any, motion: Motion) -> Array:
    """Momentum of each node [kg m/s], (n_nodes, dim); what is held counts as at rest."""
    full = np.zeros(body.n_full)
    full[body.free] = motion.velocity
    return mass @ full.reshape(-1, body.grid.dimension)


def angular_momentum(body: Body, mass: Any, motion: Motion) -> Array:
    """Angular momentum about the origin [kg m^2/s], (3,)."""
    grid = body.grid
    place, momentum = np.zeros((2, grid.n_nodes, 3))
    moved = body.displacement(motion.displacement, 0.0).reshape(-1, grid.dimension)
    place[:, : grid.dimension] = grid.positions + moved
    momentum[:, : grid.dimension] = node_momentum(body, mass, motion)
    return np.cross(place, momentum).sum(axis=0)


def rigid_motions(body: Body) -> Array:
    """Translations and infinitesimal rotations of the free numbers, (n_unknowns, 3 or 6)."""
    positions = body.grid.positions - body.grid.positions.mean(axis=0)
    n, d = positions.shape
    found = [np.tile(row, n) for row in np.eye(d)]
    for i in range(d):
        for k in range(i + 1, d):
            turn = np.zeros((n, d))
            turn[:, i], turn[:, k] = -positions[:, k], positions[:, i]
            found.append(turn.ravel())
    return np.ascontiguousarray(np.stack(found, axis=1)[body.free])
