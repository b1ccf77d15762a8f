"""Forces, masses and works of the finite-element solid, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.interfaces import AffineLaw, Motion
from myobridge.testing import fitted_order
from myobridge_plugins.load.hanging_mass import HangingMass
from myobridge_plugins.load.pressure import Pressure
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.forces import total_force
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

ANY_SHAPE = pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
DENSITY, DEPTH = 1.2e3, 0.7


def flat(shape):
    return shape in ("triangle", "quadrilateral")


def block(shape, **given):
    """30 x 20 (x 20) mm, soft; a plane one is 0.7 m deep."""
    size = (0.03, 0.02) if flat(shape) else (0.03, 0.02, 0.02)
    cells = (3, 2) if flat(shape) else (2, 2, 2)
    defaults = {
        "mesh": Block(size=size, cells=cells, shape=shape),
        "material": MooneyRivlin(c10=4e3, c01=1e3),
        "support": (Support(boundary="left"),),
        "bulk_modulus": np.inf,
        "density": DENSITY,
        "thickness": DEPTH,
    }
    return FiniteElement(**(defaults | given))


def area(shape):
    """Of the right end [m^2]."""
    return 0.02 * (DEPTH if flat(shape) else 0.02)


def dead(shape):
    """Two dead loads and gravity, and their resultant [N] in closed form."""
    d = 2 if flat(shape) else 3
    traction, gravity = np.array([300.0, 200.0, -100.0])[:d], np.array([1.0, -9.81, 2.0])[:d]
    loads = (
        Traction(boundary="right", traction=tuple(traction)),
        HangingMass(boundary="top", mass=0.02, gravity=tuple(gravity)),
    )
    weight = (0.02 + DENSITY * 0.03 * area(shape)) * gravity
    return loads, tuple(gravity), traction * area(shape) + weight


@ANY_SHAPE
def test_reactions_are_minus_the_loads(shape, equilibrium):
    loads, gravity, resultant = dead(shape)
    solid = block(shape, load=loads, gravity=gravity)
    law = AffineLaw(np.ones(solid.n_sites), np.full(solid.n_sites, 2e3), np.zeros(solid.n_sites))
    motion = equilibrium(solid, law)
    assert np.abs(motion.displacement).max() > 5e-4
    found = solid.reactions(motion, np.full(solid.n_sites, 2e3), 0.0)
    assert list(found) == ["left"]
    assert np.abs(found["left"] + resultant).max() < 1e-10 * np.linalg.norm(resultant)
    external = solid.external_force(motion.displacement, 0.0).reshape(-1, resultant.size).sum(axis=0)
    assert external + solid.supported_load(0.0)["left"] == pytest.approx(resultant, rel=1e-12)


@ANY_SHAPE
def test_forces_and_moments_balance_under_pressure(shape, equilibrium):
    """Dead loads, a follower and tension: reactions and loads add up to nothing, about the deformed places too."""
    loads, gravity, _ = dead(shape)
    solid = block(shape, load=(*loads, Pressure(boundary="bottom", pressure=400.0)), gravity=gravity)
    tension = np.full(solid.n_sites, 2e3)
    motion = equilibrium(solid, AffineLaw(np.ones(solid.n_sites), tension, np.zeros(solid.n_sites)))
    body = solid._body
    full = body.displacement(motion.displacement, 0.0)
    d = body.grid.dimension
    place, reaction, load = np.zeros((3, body.grid.n_nodes, 3))
    place[:, :d] = body.grid.positions + full.reshape(-1, d)
    reaction[:, :d] = total_force(body, motion, tension, 0.0).reshape(-1, d)
    load[:, :d] = body.loading.external(full, 0.0).reshape(-1, d)
    assert np.abs(full).max() > 5e-4
    free = np.zeros(body.n_full, dtype=bool)
    free[body.free] = True
    largest = np.abs(reaction).sum()
    assert np.abs(reaction[:, :d].ravel()[free]).max() < 1e-11 * largest
    assert np.abs((reaction + load).sum(axis=0)).max() < 1e-12 * largest
    arm = 0.03 * largest
    assert np.abs(np.cross(place, load).sum(axis=0)).max() > 1e-3 * arm
    assert np.abs(np.cross(place, reaction + load).sum(axis=0)).max() < 1e-12 * arm


def test_a_number_held_twice_counts_for_the_first_support(equilibrium):
    supports = (Support(boundary="left"), Support(boundary="bottom", components="y"))
    loads, gravity, resultant = dead("triangle")
    solid = block("triangle", support=supports, load=loads, gravity=gravity)
    found = solid.reactions(equilibrium(solid), np.empty(0), 0.0)
    assert found["left"] + found["bottom"] == pytest.approx(-resultant, rel=1e-9)
    assert found["bottom"][0] == 0.0


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_thickness_scales_forces_and_energies_and_no_displacement(shape, equilibrium):
    loads = (Traction(boundary="right", traction=(300.0, 200.0)), Pressure(boundary="bottom", pressure=400.0))
    found = []
    for thickness in (1.0, 0.25):
        solid = block(shape, load=loads, thickness=thickness, gravity=9.81)
        motion = equilibrium(solid)
        reaction = solid.reactions(motion, np.empty(0), 0.0)["left"]
        energy = solid.elastic_energy(motion.displacement)
        mass, volume = solid.mass_matrix.sum(), solid.site_volumes.sum()
        found.append((motion, np.array([*reaction, energy, mass, volume])))
    assert np.abs(found[0][0].displacement - found[1][0].displacement).max() < 1e-12
    assert found[0][0].multiplier == pytest.approx(found[1][0].multiplier, rel=1e-7, abs=1e-6)
    assert found[1][1] == pytest.approx(0.25 * found[0][1], rel=1e-9)


@ANY_SHAPE
def test_mass_and_momenta(shape):
    """A free body that flies and spins: momentum m v, angular momentum r x m v + I w, energy m v^2 / 2."""
    d = 2 if flat(shape) else 3
    solid = block(shape, support=(), load=(HangingMass(boundary="right", mass=0.1),))
    mass, hung = DENSITY * 0.03 * area(shape), 0.1
    X = solid._body.grid.positions
    velocity = np.array([0.3, -0.2, 0.5])[:d]
    still = np.zeros(solid.n_unknowns)
    flying = Motion(still, np.tile(velocity, len(X)), solid.rest_motion().multiplier)
    assert solid.mass_matrix.shape == (solid.n_unknowns,) * 2
    assert solid.momentum(flying) == pytest.approx((mass + hung) * velocity, rel=1e-12)
    kinetic = 0.5 * flying.velocity @ (solid.mass_matrix @ flying.velocity)
    assert kinetic == pytest.approx(0.5 * (mass + hung) * velocity @ velocity, rel=1e-12)
    centre = np.array([0.015 * mass + 0.03 * hung, 0.01 * (mass + hung), 0.01 * (mass + hung)])[:d]
    arms, moving = np.zeros((2, 3))
    arms[:d], moving[:d] = centre, velocity
    assert solid.angular_momentum(flying) == pytest.approx(np.cross(arms, moving), rel=1e-11, abs=1e-15)
    # Spin about the axis z through the origin: I_zz of the box is m (a^2 + b^2) / 3, of its end m (a^2 + b^2 / 3).
    turning = np.zeros_like(X)
    turning[:, 0], turning[:, 1] = -7.0 * X[:, 1], 7.0 * X[:, 0]
    spinning = Motion(still, turning.ravel(), solid.rest_motion().multiplier)
    inertia = mass * (0.03**2 + 0.02**2) / 3.0 + hung * (0.03**2 + 0.02**2 / 3.0)
    assert solid.angular_momentum(spinning)[2] == pytest.approx(7.0 * inertia, rel=1e-12)
    eigenvalues = np.linalg.eigvalsh(solid.mass_matrix.toarray())
    assert eigenvalues[0] > 0.0


@ANY_SHAPE
def test_what_hangs_has_inertia_and_what_is_held_has_none(shape):
    """The hanging mass is spread over its boundary; the mass matrix of a held body is a part of the free one's."""
    with_mass, without = (
        block(shape, support=(), load=loads) for loads in ((HangingMass(boundary="right", mass=0.1),), ())
    )
    added = (with_mass.mass_matrix - without.mass_matrix).toarray()
    d = 2 if flat(shape) else 3
    on_right = np.repeat(np.isclose(with_mass._body.grid.positions[:, 0], 0.03), d)
    assert added.sum() == pytest.approx(d * 0.1, rel=1e-12)
    assert np.abs(added[~on_right]).max() < 1e-18
    held = block(shape)
    assert np.array_equal(
        held.mass_matrix.toarray(),
        block(shape, support=()).mass_matrix.toarray()[np.ix_(held._body.free, held._body.free)],
    )


@pytest.mark.parametrize("shape", ["triangle", "hexahedron"])
def test_the_work_of_a_moving_support_closes_the_ledger(shape):
    """Pulled by 20 % and sheared, quasi-statically: reactions are taken at the end of a step, so the order is 1."""
    d = 2 if flat(shape) else 3
    pulled = Support(boundary="right", displacement=(6e-3, 2e-3, 0.0)[:d], scale=Ramp(final=1.0, end=1.0))
    steps, drifts = [0.25, 0.125, 0.0625], []
    for dt in steps:
        solid = block(shape, support=(Support(boundary="left"), pulled), gravity=9.81, bulk_modulus=1e6)
        simulation = mb.Simulation(solid=solid, integrator=QuasiStatic(), dt=dt).run(1.0)
        ledger = simulation.ledger
        assert ledger.external == pytest.approx(ledger.elastic, rel=0.5)
        assert ledger.elastic > 1e-4
        drifts.append(abs(ledger.drift))
    order = fitted_order(steps, drifts)
    print(f"{shape}: drift of the ledger {drifts}, order {order:.3f}")
    assert order == pytest.approx(1.0, abs=0.1)
    assert drifts[-1] < 0.1
