"""Quantities of interest of a study: what is compared, and where a running simulation tells it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from myobridge.errors import MyobridgeError, nearest
from myobridge.interfaces import Array
from myobridge.ledger import FLOWS, STORED
from myobridge.simulation import Simulation

__all__ = ["QUANTITIES", "Quantity", "available", "reader", "usual"]

Reader = Callable[[Simulation], Any]

QUANTITIES: Mapping[str, str] = {
    "tension": "mean over the volume of the active tension [Pa]",
    "stretch": "mean over the volume of the fibre stretch [-]",
    "moments": "means over the volume of Q0, Q1, Q2 of the population",
    "tip": "displacement of the end that is farthest along the first axis [m]",
    "energy": "stored energy, all kinds [J]",
    "pressure": "mean over the body of the hydrostatic pressure [Pa]",
    **{f"energy/{name}": f"entry '{name.replace('_', ' ')}' of the ledger [J]" for name in (*STORED, *FLOWS)},
    "reaction/...": "force of the support of that name on the solid [N]",
}
"""What can be compared, in words; ``reaction/left`` and the like by the names of the supports."""


@attrs.frozen
class Quantity:
    """Quantity of interest.

    Attributes
    ----------
    name : str
        One of `QUANTITIES`, or any name with a `function`.
    function : callable, optional
        From a simulation after a step to a number or an array of fixed shape. For workers it must be importable, or
        small enough to travel with the study.
    """

    name: str
    function: Reader | None = None

    @classmethod
    def of(cls, given: Quantity | str) -> Quantity:
        """The quantity, or that of a name."""
        return given if isinstance(given, Quantity) else cls(given)


def reader(quantity: Quantity, simulation: Simulation) -> Reader:
    """How the quantity is read from this simulation.

    Raises
    ------
    MyobridgeError
        If there is no such quantity here.
    """
    if quantity.function is not None:
        return quantity.function
    found = available(simulation)
    if quantity.name not in found:
        raise MyobridgeError(f"quantities: the scene has no '{quantity.name}'. {nearest(quantity.name, found)}")
    return found[quantity.name]


def usual(simulation: Simulation) -> tuple[Quantity, ...]:
    """What is compared where nobody says: tension and tip, as far as there are any."""
    found = available(simulation)
    return tuple(Quantity(name) for name in ("tension", "tip") if name in found) or (Quantity("energy"),)


def available(simulation: Simulation) -> dict[str, Reader]:
    """Quantities of this simulation by name."""
    solid, found = simulation.solid, dict[str, Reader]()
    volumes = solid.site_volumes
    weights = volumes / volumes.sum() if volumes.size else volumes
    bus = simulation.bus
    if bus is not None:
        found["tension"] = lambda now: float(weights @ bus.tension)
        found["moments"] = lambda now: weights @ bus.moments()
        found["stretch"] = lambda now: float(weights @ bus.stretch)
    elif solid.n_sites:
        found["stretch"] = lambda now: float(weights @ solid.stretch(now.motion.displacement, now.time))
    if solid.n_unknowns:
        found["tip"] = _tip(simulation)
    found["energy"] = lambda now: now.ledger.total
    for name in (*STORED, *FLOWS):
        found[f"energy/{name}"] = lambda now, name=name: getattr(now.ledger, name)
    if solid.visible_mesh() is not None and "pressure" in solid.visible_fields(simulation.motion, simulation.time):
        found["pressure"] = lambda now: float(np.mean(solid.visible_fields(now.motion, now.time)["pressure"]))
    for name in _reactions(simulation):
        found[f"reaction/{name}"] = lambda now, name=name: _reactions(now)[name]
    return found


def _tip(simulation: Simulation) -> Reader:
    """Displacement of the far end: its mean over the nodes there, or that of the last node of a line."""
    solid, mesh = simulation.solid, simulation.solid.visible_mesh()
    if mesh is None:
        dimension = solid.momentum(simulation.motion).size
        return lambda now: now.motion.displacement[-dimension:].copy()
    along = np.asarray(mesh.points)[:, 0]
    there = along >= along.max() - 1e-6 * float(np.ptp(along))
    return lambda now: _displacement(now)[there].mean(axis=0)


def _displacement(simulation: Simulation) -> Array:
    return simulation.solid.visible_fields(simulation.motion, simulation.time)["displacement"]


def _reactions(simulation: Simulation) -> Mapping[str, Array]:
    bus, solid = simulation.bus, simulation.solid
    tension = np.zeros(solid.n_sites) if bus is None else bus.tension
    return solid.reactions(simulation.motion, tension, simulation.time)
