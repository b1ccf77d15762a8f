"""A free chain in space keeps its momenta to round-off, active or not, whatever integrator claims to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.rope import Rope

CLAIMS = {
    item.name: item.cls
    for item in mb.registry()
    if item.family == "time_integrator" and "momentum" in item.cls.conserves
}


def free_line(kind: type[mb.MacroSolid], seed: int) -> mb.MacroSolid:
    size = {"springs": 5} if kind is Chain else {"elements": 3}
    common = {"length": 0.3, "modulus": 2e4, "mass": 0.05, "dimension": "3", "left": "free", "right": "free", **size}
    unknowns = kind(**common).n_unknowns
    velocity = np.random.default_rng(seed).normal(scale=0.3, size=unknowns)
    return kind(**common, stretch_at_start=1.05, velocity=tuple(velocity))


@pytest.mark.parametrize("kind", [Chain, Rope])
@pytest.mark.parametrize("name", sorted(CLAIMS))
@given(seed=st.integers(0, 2**32 - 1), active=st.booleans())
@settings(max_examples=8)
def test_momenta_of_a_free_line(name, kind, seed, active):
    solid = free_line(kind, seed)
    simulation = mb.Simulation(
        solid=solid,
        integrator=CLAIMS[name](),
        cross_bridges=Huxley(p_max=1e3, bins=8) if active else None,
        dt=2e-4,
    )
    start = simulation.motion
    linear, angular = solid.momentum(start), solid.angular_momentum(start)
    simulation.run(0.02)
    moved = solid.positions(simulation.motion.displacement) - solid.positions(start.displacement)
    assert np.abs(moved).max() > 1e-3
    scale = np.abs(solid.mass_matrix).max() * np.abs(start.velocity).max() * solid.n_unknowns
    assert np.abs(solid.momentum(simulation.motion) - linear).max() <= 1e-13 * scale * 100
    if "angular_momentum" in CLAIMS[name].conserves:
        drift = np.abs(solid.angular_momentum(simulation.motion) - angular).max()
        assert drift <= 1e-13 * scale * 100 * solid.length


def test_backward_euler_does_not_keep_the_angular_momentum():
    """What is not claimed is not kept: the check above can fail."""
    from myobridge_plugins.time_integrator.backward_euler import BackwardEuler

    solid = free_line(Chain, 1)
    simulation = mb.Simulation(solid=solid, integrator=BackwardEuler(), dt=2e-3)
    before = solid.angular_momentum(simulation.motion)
    simulation.run(0.2)
    after = solid.angular_momentum(simulation.motion)
    assert np.abs(after - before).max() > 1e-2 * np.abs(before).max()


def test_midpoint_keeps_the_energy_of_a_linear_problem_to_round_off():
    """Spring and attached heads (Model 3.12): a linear system; 10^4 steps."""
    from myobridge_plugins.macro_solid.spring import Spring
    from myobridge_plugins.time_integrator.midpoint import Midpoint

    solid = Spring(mass=0.05, stiffness=500.0, displacement=1e-3)
    simulation = mb.Simulation(solid=solid, integrator=Midpoint(), cross_bridges=Liouville(), dt=1e-3)
    before = simulation.ledger.total
    kinetic = []
    for _ in range(10_000):
        simulation.step()
        kinetic.append(simulation.ledger.kinetic)
    assert max(kinetic) > 1e-3 * before
    assert abs(simulation.ledger.total - before) <= 1e-11 * before
