"""Masses of a body, and the motion in which it starts."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.errors import ParameterError
from myobridge_plugins.load.hanging_mass import HangingMass
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.time_integrator.rattle import Rattle

SHAPES = {
    "triangle": ("P2", "P1"),
    "quadrilateral": ("Q2",),
    "tetrahedron": ("P2", "P1"),
    "hexahedron": ("Q2",),
}
KINDS = [(shape, pair) for shape, pairs in SHAPES.items() for pair in pairs]


def body(shape="triangle", pair=None, **options):
    deep = shape in ("tetrahedron", "hexahedron")
    size, cells = ((0.1, 0.02, 0.03), (3, 2, 2)) if deep else ((0.1, 0.02), (4, 2))
    mesh = Block(size=size, cells=cells, shape=shape)
    return FiniteElement(mesh=mesh, material=NeoHooke(shear_modulus=1e4), elements=pair, thickness=0.03, **options)


@pytest.mark.parametrize(("shape", "pair"), KINDS)
def test_a_lumped_mass_is_positive_and_keeps_the_total_and_the_centre(shape, pair) -> None:
    consistent, lumped = (body(shape, pair, mass=kind, density=2e3) for kind in ("consistent", "lumped"))
    matrix, diagonal = consistent.mass_matrix.toarray(), lumped.mass_matrix
    d = consistent.momentum(consistent.rest_motion()).size
    assert diagonal.shape == (consistent.n_unknowns,)
    assert diagonal.min() > 0.0
    total = 2e3 * 0.1 * 0.02 * 0.03
    np.testing.assert_allclose(diagonal.reshape(-1, d).sum(axis=0), total, rtol=1e-13)
    np.testing.assert_allclose(matrix.reshape(-1, d, matrix.shape[0]).sum(axis=(0, 2)), total, rtol=1e-12)
    places = consistent._body.grid.positions
    np.testing.assert_allclose(diagonal[::d] @ places / total, [0.05, 0.01, 0.015][:d], rtol=1e-12)


@pytest.mark.parametrize("mass", ["consistent", "lumped"])
def test_a_mass_that_hangs_on_the_body_is_in_both(mass) -> None:
    solid = body(
        load=(HangingMass(boundary="right", mass=0.5, gravity=(0.0, 0.0)),), mass=mass, velocity_at_start=(2.0, 0.0)
    )
    start = solid.rest_motion()
    np.testing.assert_allclose(solid.momentum(start), [2.0 * (0.5 + 1.1e3 * 0.1 * 0.02 * 0.03), 0.0], atol=1e-14)


def test_a_lumped_mass_lets_an_explicit_method_step_further() -> None:
    limits = []
    for mass in ("consistent", "lumped"):
        solid = body(mass=mass, bulk_modulus=np.inf, support=(Support(boundary="left"),))
        limits.append(Rattle().largest_step(solid, None, solid.rest_motion(), 0.0))
    assert limits[1] > 1.3 * limits[0]


def test_a_lumped_body_swings_at_almost_the_same_frequency() -> None:
    """Kinetic energy follows the mass matrix, so that the energy of a run is kept as well as with the other."""
    ends = []
    for mass in ("consistent", "lumped"):
        solid = body(mass=mass, support=(Support(boundary="left"),), velocity_at_start=(0.2, 0.0))
        simulation = mb.Simulation(
            solid=solid, integrator=mb.registry().find("time_integrator", "midpoint").cls(), dt=5e-4
        )
        simulation.run(0.01)
        ends.append(simulation.motion.displacement)
        ledger = simulation.ledger
        start = 0.5 * float(solid.rest_motion().velocity @ _times(solid.mass_matrix, solid.rest_motion().velocity))
        assert ledger.kinetic + ledger.elastic == pytest.approx(start, rel=0.02)
    assert np.linalg.norm(ends[1] - ends[0]) < 0.1 * np.linalg.norm(ends[0])
    assert np.linalg.norm(ends[1] - ends[0]) > 1e-6 * np.linalg.norm(ends[0])


def _times(mass, vector):
    return mass * vector if mass.ndim == 1 else mass @ vector


@pytest.mark.parametrize("shape", ["triangle", "tetrahedron"])
def test_a_free_body_starts_stretched_about_its_middle_and_turns_about_its_centre_of_mass(shape) -> None:
    d = 2 if shape == "triangle" else 3
    factors, velocity = (1.2, 0.9, 1.1)[:d], (0.5, -0.3, 0.2)[:d]
    spin = 4.0 if d == 2 else (1.0, 2.0, 3.0)
    solid = body(shape, stretch_at_start=factors, velocity_at_start=velocity, spin_at_start=spin)
    start = solid.rest_motion()
    places = solid._body.grid.positions
    middle = np.array([0.05, 0.01, 0.015][:d])
    now = places + start.displacement.reshape(-1, d)
    np.testing.assert_allclose(now, middle + np.array(factors) * (places - middle), atol=1e-15)
    total = 1.1e3 * 0.1 * 0.02 * 0.03
    momentum = solid.momentum(start)
    np.testing.assert_allclose(momentum, total * np.array(velocity), rtol=1e-12)
    omega = np.array([0.0, 0.0, spin]) if d == 2 else np.array(spin)
    moving = start.velocity.reshape(-1, d) - np.array(velocity)
    arms = np.zeros((len(now), 3))
    arms[:, :d] = now - middle
    np.testing.assert_allclose(moving, np.cross(omega, arms)[:, :d], atol=1e-14)
    # About its centre a box turns with m (a^2 + b^2) / 12 about each axis.
    edges = np.array(factors) * np.array([0.1, 0.02, 0.03][:d])
    squares = np.zeros(3)
    squares[:d] = edges**2
    expected = total / 12.0 * (squares.sum() - squares) * omega
    orbital = np.cross(np.append(middle, 0.0)[:3], np.append(momentum, 0.0)[:3])
    np.testing.assert_allclose(solid.angular_momentum(start) - orbital, expected, rtol=1e-10, atol=1e-15)


def test_what_is_held_stays_where_the_support_has_it() -> None:
    support = Support(boundary="left", displacement=(1e-3, 0.0))
    solid = body(support=(support,), stretch_at_start=(1.3, 1.0 / 1.3), velocity_at_start=(1.0, 0.0))
    start = solid.rest_motion()
    full = solid._body.displacement(start.displacement, 0.0).reshape(-1, 2)
    places = solid._body.grid.positions
    left = places[:, 0] == 0.0
    np.testing.assert_array_equal(full[left], [[1e-3, 0.0]] * left.sum())
    np.testing.assert_allclose(full[~left, 0], 0.3 * places[~left, 0], atol=1e-15)
    np.testing.assert_allclose(full[~left, 1], (1.0 / 1.3 - 1.0) * (places[~left, 1] - 0.01), atol=1e-15)
    assert start.velocity.size == solid.n_unknowns


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("stretch_at_start", (1.1,), "has 1 values; expected 2, one for each axis"),
        ("velocity_at_start", (1.0, 0.0, 0.0), "has 3 values; expected 2"),
        ("spin_at_start", (1.0, 2.0), "has 2 values; expected 1, about the normal of the plane"),
        ("stretch_at_start", (1.1, 0.0), r"expected .* in \(0, inf\)"),
        ("mass", "lumpy", "consistent, lumped. Did you mean 'lumped'"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_key(key, value, said) -> None:
    with pytest.raises(ParameterError, match=said) as refusal:
        body(**{key: value}).rest_motion()
    assert refusal.value.key.startswith(key)


def test_without_spin_no_mass_is_asked_for(monkeypatch) -> None:
    import myobridge_plugins.macro_solid.finite_element.masses as masses

    monkeypatch.setattr(masses, "node_mass", None)
    start = body(stretch_at_start=(1.1, 1.0)).rest_motion()
    assert start.displacement.any()
    with pytest.raises(TypeError):
        attrs.evolve(body(), spin_at_start=1.0).rest_motion()
