"""Discrete gradients and viscosity of chain, rope and spring: works to round-off, tangents against differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge.interfaces import AffineLaw
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.rope import Rope
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum
from myobridge_plugins.time_integrator.midpoint import Midpoint

COMMON = {"length": 0.3, "modulus": 2e4, "mass": 0.05, "dimension": "3", "left": "free", "right": "free"}
DT = 1e-3


def chain(viscosity=None):
    return Chain(springs=4, viscosity=viscosity, **COMMON)


def rope(viscosity=None):
    return Rope(elements=2, viscosity=viscosity, **COMMON)


def spring(viscosity=None):
    return Spring(stiffness=300.0, viscosity=viscosity)


SOLIDS = {"chain": chain, "rope": rope, "spring": spring}


def motions(solid, seed, size):
    """Two motions that differ by `size` of the element length."""
    random = np.random.default_rng(seed)
    start = random.normal(scale=0.01, size=solid.n_unknowns)
    change = size * random.normal(scale=0.01, size=solid.n_unknowns)
    zero = np.zeros(solid.n_unknowns)
    return mb.Motion(start, zero), mb.Motion(start + change, zero)


def law(solid, seed):
    random = np.random.default_rng(seed)
    n = solid.n_sites
    return AffineLaw(random.uniform(0.8, 1.2, n), random.uniform(-1e4, 7e4, n), random.uniform(0.0, 5e5, n))


@pytest.mark.parametrize("kind", sorted(SOLIDS))
@given(seed=st.integers(0, 2**32 - 1), decade=st.integers(-6, 0), viscosity=st.sampled_from([None, 0.0, 50.0]))
@settings(max_examples=40)
def test_the_work_of_a_step_is_the_change_of_energy(kind, seed, decade, viscosity):
    solid = SOLIDS[kind](viscosity)
    start, end = motions(solid, seed, 10.0**decade)
    frozen = law(solid, seed)
    force = solid.step_balance(start, end, frozen, (0.0, DT)).force
    works = solid.step_works(start, end, frozen, (0.0, DT))

    def energy(motion):
        potential = frozen.potential(solid.stretch(motion.displacement, 0.0))
        return solid.elastic_energy(motion.displacement) + float(solid.site_volumes @ potential)

    change = end.displacement - start.displacement
    size = solid.balance(start, frozen, 0.0).magnitude * np.linalg.norm(change)
    gained = energy(end) - energy(start)
    # Positions are rounded as the length is, which has a few elements: so well known is a stretch, and its energy.
    stretch = solid.stretch(start.displacement, 0.0)
    stress = np.abs(frozen.evaluate(stretch, 0.0 * stretch).tension) + 2e4
    noise = 16.0 * np.finfo(float).eps * float(solid.site_volumes @ (stress * stretch)) + 1e-15 * size
    assert abs(float(force @ change) - (gained - works.external + works.viscous)) <= noise
    # The spring answers half-way, where the viscous stress is not quite that of the mean strain rate.
    assert works.viscous >= 0.0
    if viscosity and kind != "spring":
        first, last = (solid.stretch(motion.displacement, 0.0) for motion in (start, end))
        strain = 0.5 * (last**2 - first**2)
        assert works.viscous == pytest.approx(viscosity / DT * float(solid.site_volumes @ strain**2), rel=1e-9)


@pytest.mark.parametrize("viscosity", [None, 50.0])
@pytest.mark.parametrize("rate_law", [False, True])
@pytest.mark.parametrize("kind", sorted(SOLIDS))
def test_the_tangent_of_a_step_is_the_derivative_of_its_force(kind, rate_law, viscosity):
    solid = SOLIDS[kind](viscosity)
    start, end = motions(solid, 3, 0.3)
    frozen = law(solid, 4)
    if rate_law:
        hill = Hill(force_velocity=True)
        state = hill.initial_state(solid.n_sites)
        ones = np.ones(solid.n_sites)
        frozen = hill.active_law(state, ones, ones).scaled(7e4 * ones)

    def force(displacement):
        return solid.step_balance(start, mb.Motion(displacement, end.velocity), frozen, (0.0, DT)).force

    found = solid.step_balance(start, end, frozen, (0.0, DT), tangent=True).stiffness
    found = found if isinstance(found, np.ndarray) else found.toarray()
    near = 1e-7
    columns = [
        (force(end.displacement + near * way) - force(end.displacement - near * way)) / (2.0 * near)
        for way in np.eye(solid.n_unknowns)
    ]
    np.testing.assert_allclose(found, np.array(columns).T, atol=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("kind", sorted(SOLIDS))
def test_damping_is_the_derivative_of_the_force_by_the_velocity(kind):
    solid = SOLIDS[kind](50.0)
    place, _ = motions(solid, 5, 1.0)
    velocity = np.random.default_rng(6).normal(size=solid.n_unknowns)

    def balance(displacement, moving, tangent=False):
        return solid.balance(mb.Motion(displacement, moving), None, 0.0, tangent=tangent)

    found = balance(place.displacement, velocity, tangent=True)
    # Linear in the velocity: one difference over a long way is exact; and the share of viscosity alone is known.
    assert found.damping is not None
    still = balance(place.displacement, np.zeros_like(velocity)).force
    np.testing.assert_allclose(found.damping @ velocity, found.force - still, atol=1e-10 * np.abs(found.force).max())
    share = solid.viscous_force(mb.Motion(place.displacement, velocity), 0.0)
    np.testing.assert_allclose(share, found.force - still, atol=1e-10 * np.abs(found.force).max())
    assert np.abs(share).max() > 1e-3


@pytest.mark.parametrize("kind", ["chain", "rope"])
def test_energy_and_momenta_of_a_tumbling_line(kind):
    """What the midpoint rule does not: the energy is not quadratic where segments turn."""
    solid = SOLIDS[kind]()
    velocity = np.random.default_rng(1).normal(scale=1.0, size=solid.n_unknowns)
    drift = {}
    for integrator in (EnergyMomentum(), Midpoint()):
        moving = type(solid)(
            **{**COMMON, **({"springs": 4} if kind == "chain" else {"elements": 2})}, velocity=tuple(velocity)
        )
        simulation = mb.Simulation(solid=moving, integrator=integrator, dt=5e-3)
        before, turning = simulation.ledger.total, moving.angular_momentum(simulation.motion)
        changes = []
        for _ in range(300):
            simulation.step()
            changes.append(abs(simulation.ledger.total - before))
        drift[type(integrator).__name__] = max(changes) / before
        after = moving.angular_momentum(simulation.motion)
        np.testing.assert_allclose(after, turning, atol=1e-10 * np.abs(turning).max())
    assert drift["EnergyMomentum"] <= 1e-11
    assert drift["Midpoint"] > 1e-5


@pytest.mark.parametrize(
    "integrator", [EnergyMomentum(), Midpoint(), BackwardEuler()], ids=lambda one: type(one).__name__
)
@pytest.mark.parametrize("kind", sorted(SOLIDS))
def test_viscosity_takes_what_the_ledger_says(kind, integrator):
    common = {"viscosity": 200.0, "velocity": 0.3} if kind == "spring" else {"viscosity": 200.0, **COMMON}
    if kind != "spring":
        common["velocity"] = tuple(np.random.default_rng(2).normal(scale=0.3, size=SOLIDS[kind]().n_unknowns))
        common |= {"springs": 4} if kind == "chain" else {"elements": 2}
    solid = {"chain": Chain, "rope": Rope, "spring": Spring}[kind](**common)
    simulation = mb.Simulation(solid=solid, integrator=integrator, dt=1e-3)
    start = simulation.ledger.total
    simulation.run(0.05)
    ledger = simulation.ledger
    assert ledger.viscous > 1e-3 * start
    if isinstance(integrator, EnergyMomentum):
        assert abs(ledger.drift) <= 1e-12
    assert ledger.total < start


def test_a_scene_that_does_not_call_for_viscosity_has_none():
    text = """
[scene]
effects = ["inertia"{}]
duration = 0.01
step = 1e-3
[solid]
plugin = "chain"
springs = 3
stretch_at_start = 1.1
{}
"""

    def run(scene):
        return mb.Plan.of(mb.Scene.from_toml(scene)).simulation().run(0.01).ledger

    with pytest.raises(mb.SceneError, match="viscosity"):
        mb.Plan.of(mb.Scene.from_toml(text.format("", "viscosity = 10.0")))
    without = run(text.format("", ""))
    thick = run(text.format(', "viscosity"', "viscosity = 10.0"))
    assert without.viscous == 0.0
    assert thick.viscous > 0.0
