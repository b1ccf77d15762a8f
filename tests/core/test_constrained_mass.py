"""Mass with constraint, accelerations, projections and the largest frequency, against whole matrices."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest
import scipy.linalg as linalg
import scipy.sparse as sparse

from myobridge.interfaces import Motion
from myobridge.solvers import (
    ConstrainedMass,
    UnsolvedSystem,
    accelerated,
    acceleration,
    constrained,
    constraint_at,
    constraint_rate,
    gradient_at,
    largest_frequency,
    onto_constraint,
    point_force,
    projected_displacement,
    projected_velocity,
)
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.sine import Sine


def body(cells=(6, 3), bulk_modulus=np.inf, **options):
    """Block of the thesis' tissue; 168 unknowns and 28 multipliers."""
    options.setdefault("support", (Support(boundary="left"),))
    material = MooneyRivlin(**MooneyRivlin.parameter_sets["thesis"])
    return FiniteElement(
        mesh=Block(size=(0.1, 0.025), cells=cells), material=material, bulk_modulus=bulk_modulus, **options
    )


def moving(solid, seed=0, size=2e-4):
    """A motion that has no symmetry."""
    random = np.random.default_rng(seed)
    start = solid.rest_motion()
    n = solid.n_unknowns
    return Motion(size * random.standard_normal(n), random.standard_normal(n), start.multiplier)


def whole(solid, first, second):
    mass = solid.mass_matrix.toarray()
    zero = np.zeros((first.shape[0],) * 2)
    return np.block([[mass, first.toarray().T], [second.toarray(), zero]])


@pytest.mark.parametrize("few", [150, 0], ids=["formed", "iterative"])
@pytest.mark.parametrize("gradients", ["one", "two"])
def test_mass_with_constraint_is_solved_as_the_whole_matrix_is(few, gradients, monkeypatch) -> None:
    monkeypatch.setattr(constrained, "_FEW", few)
    solid = body()
    motion = moving(solid)
    first = gradient_at(solid, motion.displacement, 0.0, motion.multiplier)
    second = first
    if gradients == "two":
        second = gradient_at(solid, 1.3 * motion.displacement, 0.0, motion.multiplier)
    random = np.random.default_rng(3)
    force, rate = random.standard_normal(solid.n_unknowns), 1e-3 * random.standard_normal(motion.multiplier.size)
    mass = ConstrainedMass(solid, second, first)
    x, p = mass.solve(force, rate)
    expected = np.linalg.solve(whole(solid, sparse.csr_array(first), sparse.csr_array(second)), np.append(force, rate))
    np.testing.assert_allclose(x, expected[: x.size], rtol=0.0, atol=1e-10 * np.abs(expected[: x.size]).max())
    np.testing.assert_allclose(p, expected[x.size :], rtol=0.0, atol=1e-9 * np.abs(expected[x.size :]).max())


def test_a_factor_of_another_shape_is_made_anew_for_the_one_system(monkeypatch) -> None:
    """With one iteration allowed the preconditioner of the start is given up at once."""
    monkeypatch.setattr(constrained, "_FEW", 0)
    solid = body()
    motion = moving(solid)
    gradient = gradient_at(solid, motion.displacement, 0.0, motion.multiplier)
    force = np.cos(np.arange(solid.n_unknowns))
    expected = ConstrainedMass(solid, gradient).solve(force)
    monkeypatch.setattr(constrained, "_MANY", 1)
    for found, wanted in zip(ConstrainedMass(solid, gradient).solve(force), expected, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-10 * np.abs(wanted).max())
    monkeypatch.setattr(constrained, "_TOO_MANY", 1)
    with pytest.raises(UnsolvedSystem, match="multipliers of 28 constraints"):
        ConstrainedMass(solid, gradient).solve(force)


@pytest.mark.parametrize("support", ["still", "moving"])
def test_acceleration_keeps_the_second_derivative_of_the_constraint_at_zero(support) -> None:
    """Along u + s v + s^2 a / 2 the constraint has no second derivative in s; and M a is what force is left."""
    held = Support(boundary="left")
    if support == "moving":
        held = Support(boundary="left", displacement=(2e-3, 0.0), scale=Sine(offset=0.2, amplitude=1.0, frequency=3.0))
    solid = body(support=(held,))
    motion = moving(solid, size=1e-4)
    time, dt = 0.04, 1e-3
    found = accelerated(solid, None, motion, time, dt=dt)
    u, v, a = motion.displacement, motion.velocity, found.acceleration
    second = {}
    for step in (2e-5, 1e-5):
        far = [constraint_at(solid, u + s * v + 0.5 * s * s * a, time + s)[0] for s in (-step, 0.0, step)]
        second[step] = (far[0] - 2.0 * far[1] + far[2]) / step**2
    # The rest of the difference is of the second order, so that two steps tell it.
    limit = (4.0 * second[1e-5] - second[2e-5]) / 3.0
    free = constraint_at(solid, u + 1e-5 * v, time + 1e-5)[0] + constraint_at(solid, u - 1e-5 * v, time - 1e-5)[0]
    free = (free - 2.0 * constraint_at(solid, u, time)[0]) / 1e-10
    assert np.linalg.norm(limit) < 2e-4 * np.linalg.norm(free)
    with_pressure = solid.balance(attrs.evolve(motion, multiplier=found.multiplier), None, time).force
    left = solid.mass_matrix @ a + with_pressure
    assert np.linalg.norm(left) < 1e-11 * np.linalg.norm(with_pressure)
    np.testing.assert_array_equal(acceleration(solid, None, motion, time) == a, support == "still")


def test_a_constraint_with_compliance_acts_like_a_spring() -> None:
    """Its multiplier is C^-1 c, and the acceleration is that of the whole force; strictly taken it is another."""
    solid = body(bulk_modulus=1e6)
    motion = moving(solid)
    at = point_force(solid, None, motion, 0.0)
    assert at.gradient is None
    balance = solid.balance(attrs.evolve(motion, multiplier=at.multiplier), None, 0.0)
    assert balance.constraint is not None
    assert np.abs(balance.constraint).max() < 1e-14 * np.abs(at.multiplier).max()
    found = accelerated(solid, None, motion, 0.0)
    force = solid.mass_matrix @ found.acceleration + balance.force
    assert np.linalg.norm(force) < 1e-11 * np.linalg.norm(balance.force)
    strict = accelerated(solid, None, motion, 0.0, strict=True)
    stiff = accelerated(body(), None, motion, 0.0)
    np.testing.assert_allclose(strict.multiplier, stiff.multiplier, rtol=1e-9)
    assert np.abs(strict.multiplier - found.multiplier).max() > 0.1 * np.abs(found.multiplier).max()


def test_largest_frequency_is_that_of_the_constrained_pencil() -> None:
    for bulk_modulus in (np.inf, 1e7):
        solid = body(bulk_modulus=bulk_modulus)
        motion = attrs.evolve(moving(solid, size=5e-5), multiplier=np.full(solid.rest_motion().multiplier.size, 2e4))
        strict = np.isinf(bulk_modulus)
        at = motion if strict else attrs.evolve(motion, multiplier=point_force(solid, None, motion, 0.0).multiplier)
        balance: Any = solid.balance(at, None, 0.0, tangent=True)
        stiffness, mass = balance.stiffness.toarray(), solid.mass_matrix.toarray()
        gradient = balance.constraint_gradient.toarray()
        if strict:
            ways = linalg.null_space(gradient)
            stiffness, mass = ways.T @ stiffness @ ways, ways.T @ mass @ ways
        else:
            stiffness = stiffness + gradient.T @ np.linalg.solve(balance.constraint_compliance.toarray(), gradient)
        expected = np.sqrt(linalg.eigh(stiffness, mass, eigvals_only=True)[-1])
        found = largest_frequency(solid, None, motion, 0.0)
        assert expected * (1.0 - 1e-9) <= found.omega <= expected * 1.01
        again = largest_frequency(solid, None, motion, 0.0, start=found.shape, accuracy=1e-6, most=100)
        assert abs(again.omega / expected - 1.0) < 1e-5


def test_largest_frequency_of_a_spring() -> None:
    assert largest_frequency(Spring(mass=2.0, stiffness=8.0), None, Spring().rest_motion(), 0.0).omega == 2.0


def test_projections_are_the_nearest_in_the_norm_of_the_mass() -> None:
    """The correction of u is M^-1 B(u)^T mu with the gradient where it ends, that of v likewise."""
    solid = body()
    motion = moving(solid, size=3e-4)
    found = projected_displacement(solid, motion.displacement, motion.multiplier, 0.0)
    assert not found.reason
    violated, size = constraint_at(solid, motion.displacement, 0.0)
    assert np.linalg.norm(violated) > 1e-2 * size
    assert np.linalg.norm(constraint_at(solid, found.displacement, 0.0)[0]) < 1e-14 * size
    gradient = gradient_at(solid, found.displacement, 0.0, motion.multiplier)
    impulse = solid.mass_matrix @ (found.displacement - motion.displacement)
    rest = np.linalg.lstsq(gradient.toarray().T, impulse)[0] @ gradient - impulse
    assert np.linalg.norm(rest) < 1e-6 * np.linalg.norm(impulse)
    velocity = projected_velocity(solid, motion.velocity, motion.multiplier, found.displacement, 0.0, 1e-3)
    assert np.linalg.norm(gradient @ velocity) < 1e-12 * np.linalg.norm(gradient @ motion.velocity)
    impulse = solid.mass_matrix @ (velocity - motion.velocity)
    rest = np.linalg.lstsq(gradient.toarray().T, impulse)[0] @ gradient - impulse
    assert np.linalg.norm(rest) < 1e-12 * np.linalg.norm(impulse)


def test_a_displacement_far_from_the_constraint_is_not_brought_onto_it_with_a_gradient_of_elsewhere() -> None:
    solid = body()
    start = solid.rest_motion()
    near = ConstrainedMass(solid, gradient_at(solid, start.displacement, 0.0, start.multiplier))
    far = moving(solid, size=5e-3).displacement
    found = onto_constraint(solid, near, far, 0.0)
    assert "J - 1 is still" in found.reason


def test_supports_that_move_give_the_constraint_a_rate() -> None:
    held = Support(boundary="left", displacement=(1e-3, 0.0), scale=Sine(offset=0.0, amplitude=1.0, frequency=5.0))
    solid = body(support=(held,))
    u, time = moving(solid).displacement, 0.013
    step = 1e-5
    expected = (constraint_at(solid, u, time + step)[0] - constraint_at(solid, u, time - step)[0]) / (2.0 * step)
    found = constraint_rate(solid, u, time, 1e-4)
    assert np.linalg.norm(expected) > 0.0
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())
    assert not constraint_rate(body(), u, time, 1e-4).any()
