"""Momenta of a body, and the motions that deform nothing."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from myobridge.interfaces import Array, Motion
from myobridge_plugins.macro_solid.finite_element.body import Body
from myobridge_plugins.macro_solid.finite_element.loading import stores
from myobridge_plugins.macro_solid.finite_element.masses import node_momentum

__all__ = ["angular_momentum", "rigid_freedom", "rigid_motions"]


def angular_momentum(body: Body, mass: Any, motion: Motion) -> Array:
    """Angular momentum about the origin [kg m^2/s], (3,)."""
    grid = body.grid
    place, momentum = np.zeros((2, grid.n_nodes, 3))
    moved = body.displacement(motion.displacement, 0.0).reshape(-1, grid.dimension)
    place[:, : grid.dimension] = grid.positions + moved
    momentum[:, : grid.dimension] = node_momentum(body, mass, motion.velocity)
    return np.cross(place, momentum).sum(axis=0)


def rigid_freedom(body: Body) -> str:
    """In a sentence, what leaves the body free to move without deforming; empty where supports or bedding hold it."""
    loads = body.loading.loads
    if any(stores(load) for load in loads):
        return ""
    whole = _rigid(body)
    held = whole[body.held.all_numbers] / np.linalg.norm(whole, axis=0)
    scale = np.sqrt(max(body.n_full, 1))
    rank = int(np.sum(np.linalg.svd(scale * held, compute_uv=False) > 1e-6)) if held.size else 0
    missing = whole.shape[1] - rank
    if not missing:
        return ""
    named = ", ".join(f"'{support.boundary}'" for support in body.held.supports) or "none"
    ways = "one way" if missing == 1 else f"{missing} ways"
    return (
        f"can move as a rigid body in {ways}, so that it has no unique equilibrium (supports: {named}); hold more of "
        "its boundary, or bed it elastically (load 'robin')"
    )


@functools.lru_cache(maxsize=8)
def rigid_motions(body: Body) -> Array:
    """Translations and infinitesimal rotations of the free numbers, (n_unknowns, 3 or 6)."""
    return np.ascontiguousarray(_rigid(body)[body.free])


def _rigid(body: Body) -> Array:
    """The same of all numbers, about the centre of the nodes."""
    positions = body.grid.positions - body.grid.positions.mean(axis=0)
    n, d = positions.shape
    found = [np.tile(row, n) for row in np.eye(d)]
    for i in range(d):
        for k in range(i + 1, d):
            turn = np.zeros((n, d))
            turn[:, i], turn[:, k] = -positions[:, k], positions[:, i]
            found.append(turn.ravel())
    return np.stack(found, axis=1)
