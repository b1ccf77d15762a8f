"""Very many steps: the energy error of symplectic integrators stays bounded, and does not drift."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler

BOUNDED = {
    item.name: item.cls
    for item in mb.registry()
    if item.family == "time_integrator" and "bounded_energy" in item.cls.conserves
}


def energies(integrator: mb.TimeIntegrator, steps: int) -> np.ndarray:
    """Energy over time of a spring of 0.2 rad a step, relative to the start."""
    spring = Spring(mass=1.0, stiffness=400.0, displacement=0.01)
    simulation = mb.Simulation(solid=spring, integrator=integrator, dt=0.01)
    start = simulation.ledger.total
    found = np.empty(steps)
    for step in range(steps):
        simulation.step()
        found[step] = simulation.ledger.total / start
    return found


@pytest.mark.parametrize("steps", [20_000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", sorted(BOUNDED))
def test_energy_error_is_bounded_over_many_steps(name, steps):
    energy = energies(BOUNDED[name](), steps)
    error = np.abs(energy - 1.0)
    first, last = error[: steps // 10].max(), error[-steps // 10 :].max()
    print(f"{name}: energy error {first:.3e} in the first tenth, {last:.3e} in the last")
    assert first > 1e-3  # it is an error, and it is seen
    assert last <= 1.001 * first
    assert first < 0.15


def test_backward_euler_loses_its_energy():
    energy = energies(BackwardEuler(), 500)
    assert energy[-1] < 1e-3
    assert np.all(np.diff(energy) < 0.0)
