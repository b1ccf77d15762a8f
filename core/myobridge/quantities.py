"""Quantities of a running simulation that a row of the record can hold, and where each is read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

import numpy as np

from myobridge.interfaces import Array
from myobridge.simulation import Simulation

__all__ = ["QUANTITIES", "sources"]

QUANTITIES: Mapping[str, str] = {
    "stretch": "fibre stretch at the sites [-]",
    "stretch_rate": "its rate [1/s]",
    "tension": "nominal active stress of the mechanics stage [Pa]",
    "activation": "activation at the sites [-]",
    "moments": "Q0, Q1, Q2 of the population",
    "energy": "every entry of the ledger [J]",
    "reactions": "force of each support on the solid [N]",
    "displacement": "free displacements of the solid [m]",
    "momentum": "linear and angular momentum of the solid",
    "summary": "mean by volume, least and largest of stretch, tension and activation",
}


def _summary(simulation: Simulation) -> dict[str, Array]:
    volumes = simulation.solid.site_volumes
    found: dict[str, Array] = {}
    for name, values in _at_sites(simulation).items():
        found[f"mean/{name}"] = np.dot(volumes, values) / volumes.sum()
        found[f"least/{name}"], found[f"largest/{name}"] = values.min(), values.max()
    return found


def _at_sites(simulation: Simulation) -> dict[str, Array]:
    bus = simulation.bus
    if bus is None:
        return {"stretch": simulation.solid.stretch(simulation.motion.displacement, simulation.time)}
    return {"stretch": bus.stretch, "tension": bus.tension, "activation": bus.activation}


def sources(
    names: Collection[str], simulation: Simulation, columns: np.ndarray
) -> list[Callable[[], Mapping[str, Array]]]:
    """Functions that read the quantities `names` of the sites `columns`; what nobody wants is not computed."""
    solid, bus = simulation.solid, simulation.bus
    found: list[Callable[[], Mapping[str, Array]]] = [lambda: {"time": np.asarray(simulation.time)}]

    def add(name: str, source: Callable[[], Mapping[str, Array]]) -> None:
        if name in names:
            found.append(source)

    error = simulation.step_error
    if error is not None:
        found.append(lambda: {"step_length": np.asarray(error.dt), "step_error": np.asarray(error.estimate)})
    add("energy", lambda: {f"energy/{k}": np.asarray(v) for k, v in simulation.ledger.entries().items()})
    add("displacement", lambda: {"displacement": simulation.motion.displacement})
    add(
        "momentum",
        lambda: {
            "momentum": solid.momentum(simulation.motion),
            "angular_momentum": solid.angular_momentum(simulation.motion),
        },
    )

    def reactions() -> Mapping[str, Array]:
        tension = np.zeros(solid.n_sites) if bus is None else bus.tension
        forces = solid.reactions(simulation.motion, tension, simulation.time)
        return {f"reaction/{name}": value for name, value in forces.items()}

    add("reactions", reactions)
    if solid.n_sites:
        add("summary", lambda: _summary(simulation))
    if bus is None:
        add("stretch", lambda: {"stretch": _at_sites(simulation)["stretch"][columns]})
        return found
    add("stretch", lambda: {"stretch": bus.stretch[columns]})
    add("stretch_rate", lambda: {"stretch_rate": bus.stretch_rate[columns]})
    add("tension", lambda: {"tension": bus.tension[columns]})
    add("activation", lambda: {"activation": bus.activation[columns]})

    def moments() -> Mapping[str, Array]:
        values = bus.moments()[columns]
        return {f"Q{k}": values[:, k] for k in range(values.shape[1])}

    add("moments", moments)
    return found
