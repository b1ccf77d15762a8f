"""Chain and rope as solids: geometry at the start, forces against energies, supports, statics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.rope import Rope
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

KINDS = [(Chain, {"springs": 4}), (Chain, {"springs": 150}), (Rope, {"elements": 3})]


def line(kind, size, **more):
    return kind(length=0.2, modulus=1e4, mass=0.02, **size, **more)


@pytest.mark.parametrize(("kind", "size"), KINDS)
@pytest.mark.parametrize("ends", [("fixed", "free"), ("fixed", "fixed"), ("free", "free")])
@pytest.mark.parametrize("dimension", ["1", "3"])
def test_uniform_stretch_at_the_start(kind, size, ends, dimension):
    solid = line(kind, size, left=ends[0], right=ends[1], dimension=dimension, stretch_at_start=1.07)
    assert solid.stretch(solid.rest_motion().displacement, 0.0) == pytest.approx(1.07, rel=1e-12)
    assert solid.site_volumes.sum() == pytest.approx(0.2 * 1e-4, rel=1e-12)


@pytest.mark.parametrize(("kind", "size"), KINDS)
@pytest.mark.parametrize("dimension", ["1", "3"])
@given(seed=st.integers(0, 2**32 - 1))
def test_force_is_the_derivative_of_energy_and_tangent_of_force(kind, size, dimension, seed):
    solid = line(kind, size, dimension=dimension, stretch_at_start=1.1)
    random = np.random.default_rng(seed)
    spacing = 0.2 / solid.n_sites
    motion = solid.rest_motion()
    at = motion.displacement + 0.1 * spacing * random.uniform(-1, 1, motion.displacement.size)
    stretch = solid.stretch(at, 0.0)
    law = mb.AffineLaw(stretch, random.uniform(0, 1e3, stretch.size), random.uniform(0, 1e4, stretch.size))
    direction = random.normal(size=at.size)
    direction /= np.linalg.norm(direction)
    step = 1e-5 * spacing

    def energy(u):
        return solid.elastic_energy(u) + float(solid.site_volumes @ law.potential(solid.stretch(u, 0.0)))

    def force(u):
        return solid.balance(mb.Motion(u, motion.velocity), law, 0.0).force

    balance = solid.balance(mb.Motion(at, motion.velocity), law, 0.0, tangent=True)
    slope = (energy(at + step * direction) - energy(at - step * direction)) / (2 * step)
    scale = np.linalg.norm(balance.stiffness @ direction) * spacing
    assert abs(slope - balance.force @ direction) <= 1e-6 * scale
    change = (force(at + step * direction) - force(at - step * direction)) / (2 * step)
    assert np.linalg.norm(change - balance.stiffness @ direction) <= 1e-5 * np.linalg.norm(
        balance.stiffness @ direction
    )


@pytest.mark.parametrize(("kind", "size"), KINDS)
def test_dense_and_sparse_agree_with_the_mass(kind, size):
    solid = line(kind, size, dimension="3", left="free", right="free")
    velocity = np.tile([1.0, 2.0, 3.0], solid.n_unknowns // 3)
    momentum = solid.momentum(mb.Motion(solid.rest_motion().displacement, velocity))
    assert momentum == pytest.approx(0.02 * np.array([1.0, 2.0, 3.0]), rel=1e-12)


def test_isometric_chain_pulls_on_both_ends():
    """Fixed at both ends and active: reactions of p_max A, opposite, the middle at rest."""
    solid = line(Chain, {"springs": 4}, right="fixed", stretch_at_start=1.0)
    simulation = mb.Simulation(solid=solid, integrator=QuasiStatic(), cross_bridges=Huxley(), dt=1e-3)
    simulation.run(0.01)
    found = solid.reactions(simulation.motion, simulation.bus.tension, simulation.time)
    assert found["left"] == pytest.approx([-73e3 * 1e-4], rel=1e-9)
    assert found["right"] == pytest.approx([73e3 * 1e-4], rel=1e-9)


def test_slack_chain_in_statics_is_refused():
    slack = line(Chain, {"springs": 4}, dimension="3")
    with pytest.raises(mb.SceneError, match=r"4 of 4 segments are slack.*stretch_at_start"):
        mb.Simulation(solid=slack, integrator=QuasiStatic())
    taut = line(Chain, {"springs": 4}, dimension="3", right="fixed")
    simulation = mb.Simulation(solid=taut, integrator=QuasiStatic(), cross_bridges=Prescribed(p_max=1e3))
    simulation.step()
    assert simulation.bus.tension == pytest.approx(1e3)


@pytest.mark.parametrize(("kind", "size"), [*KINDS, (Chain, {"springs": 2})])
@pytest.mark.parametrize("right", ["free", "fixed"])
def test_supports_carry_the_whole_weight(kind, size, right):
    """Statics: reactions, weight and load sum to zero, the share of a node on its support included."""
    from myobridge_plugins.signal.constant import Constant

    load = Constant(level=0.3) if right == "free" else None
    solid = line(kind, size, right=right, gravity=9.81, load=load)
    simulation = mb.Simulation(solid=solid, integrator=QuasiStatic())
    simulation.step()
    total = sum(float(force[0]) for force in solid.reactions(simulation.motion, np.zeros(solid.n_sites), 0.0).values())
    assert total == pytest.approx(-(0.02 * 9.81 + (0.3 if load else 0.0)), rel=1e-10)


@pytest.mark.parametrize("kind", [Chain, Rope])
def test_a_load_of_several_values_is_refused(kind):
    from myobridge_plugins.signal.constant import Constant

    with pytest.raises(mb.ParameterError, match="load: has 2 values"):
        kind(load=Constant(level=(1.0, 2.0)))
