r"""The discrete gradient of the finite-element solid: the work of a step is the change of energy, however large it is.

.. math:: f \cdot (u_1 - u_0) = \Delta W + \Delta \Psi - W_{external} - W_{active} + W_{viscous} - W_{numerical}
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from myobridge.compiled import LANES
from myobridge.interfaces import ActiveLaw, AffineLaw, LawValue, Motion
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.load.hanging_mass import HangingMass
from myobridge_plugins.load.pressure import Pressure
from myobridge_plugins.load.robin import Robin
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.forces import at_points, volume_change
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.guccione import Guccione
from myobridge_plugins.material.holzapfel_ogden import HolzapfelOgden
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.material.transversely_isotropic import TransverselyIsotropic
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum

ANY_SHAPE = pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
MATERIALS = {
    "mooney_rivlin": MooneyRivlin(),
    "transversely_isotropic": TransverselyIsotropic(c10=2e3, c01=3e3, fibre_modulus=50.0, fibre_exponent=43.373),
    "guccione": Guccione(),
    "holzapfel_ogden": HolzapfelOgden(),
}
LAWS = ("none", "affine", "hill")
# [m] Of random steps: strains of 1e-5 to several per cent.
SIZES = (1e-7, 1e-5, 3e-4)
SEEDS = st.integers(0, 2**32 - 1)
TIMES = (0.3, 0.302)


class Hill(ActiveLaw):
    """T = 8e3 lambda^2 + (30 + 4 lambda) lambda' [Pa]: depends on stretch and rate, and has no potential."""

    def evaluate(self, stretch, stretch_rate):
        tension = 8e3 * stretch**2 + (30.0 + 4.0 * stretch) * stretch_rate
        return LawValue(tension, 16e3 * stretch + 4.0 * stretch_rate, 30.0 + 4.0 * stretch)

    def scaled(self, factor):
        raise NotImplementedError


def make(distorted, shape, **changed):
    """A body with everything at once: dead and following loads, bedding, supports of which one moves, fibres."""
    flat = shape in ("triangle", "quadrilateral")
    d = 2 if flat else 3
    given = {
        "mesh": distorted(shape),
        "material": MooneyRivlin(),
        "fibres": Constant(direction=(1.0, 0.5, -0.3)[:d]),
        "support": (
            Support(boundary="left", components="x", displacement=2e-3, scale=Sine(amplitude=1.0, frequency=30.0)),
            Support(boundary="bottom", components="y"),
        ),
        "load": (
            Traction(boundary="right", traction=(3e3, 2e3, -1e3)[:d], scale=Sine(amplitude=1.0, frequency=20.0)),
            HangingMass(boundary="right", mass=0.02),
            Pressure(boundary="top", pressure=2e4),
            Robin(boundary="bottom", normal=1e6, tangential=4e5),
        ),
        "gravity": 9.81,
        "bulk_modulus": 3e5,
        "thickness": 0.7,
        "viscosity": 12.0,
    }
    return FiniteElement(**(given | changed))


def free(distorted, shape, **changed):
    """A body that nothing holds and nothing loads."""
    return make(distorted, shape, support=(), load=(), gravity=None, **changed)


def pair(solid, seed, amplitude):
    """Two random motions, the first deformed by some per cent, `amplitude` [m] apart."""
    generator = np.random.default_rng(seed)
    rest = solid.rest_motion()
    u = 3e-4 * generator.uniform(-1.0, 1.0, rest.displacement.size)
    du = amplitude * generator.uniform(-1.0, 1.0, u.size)
    p0, p1 = 1e4 * generator.uniform(-1.0, 1.0, (2, rest.multiplier.size))
    return Motion(u, 0.0 * u, p0), Motion(u + du, 0.0 * u, p1)


def law_of(name, solid, seed):
    generator = np.random.default_rng(seed + 5)
    parts = (generator.uniform(low, high, solid.n_sites) for low, high in ((0.9, 1.1), (0, 2e4), (0, 4e5)))
    return {"none": None, "affine": AffineLaw(*parts), "hill": Hill()}[name]


def stored(solid, motion, law, time):
    """Energy of the body and of a law that has one [J]."""
    fibres = 0.0
    if law is not None and law.has_potential:
        fibres = solid.site_volumes @ law.potential(solid.stretch(motion.displacement, time))
    return solid.elastic_energy(motion.displacement, time) + fibres


def difference(function, direction, step):
    """Fourth-order central difference of `function` of a displacement along `direction`."""
    values = [function(k * step * direction) for k in (-2.0, -1.0, 1.0, 2.0)]
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)


def close(found, expected, relative):
    assert np.linalg.norm(expected) > 0.0
    error = np.linalg.norm(found - expected) / np.linalg.norm(expected)
    assert error < relative, f"relative error {error:.2e}"


def gradients(solid):
    """Gradients of the shape functions at all points, (n_points, n_nodes, dim), by plain tensor algebra."""
    grid = solid._body.grid
    d = grid.dimension
    jacobian = np.einsum("xvc,qvm->cqxm", grid.mesh.p[:, grid.mesh.t[:, grid.order]], grid.cell.map_slopes[:, :, :d])
    found = np.einsum("qam,cqmx->cqax", grid.cell.slopes[:, :, :d], np.linalg.inv(jacobian))
    return found[grid.cell_of_point, grid.quadrature_of_point]


def deformation(solid, displacement, time):
    """F at all points, (n_points, 3, 3)."""
    body = solid._body
    d = body.grid.dimension
    nodal = body.displacement(displacement, time).reshape(-1, d)[body.grid.nodes[body.grid.cell_of_point]]
    found = np.tile(np.eye(3), (body.grid.n_points, 1, 1))
    found[:, :d, :d] += np.einsum("pai,paJ->piJ", nodal, gradients(solid))
    return found


# ---------------------------------------------------------------------- energy


@ANY_SHAPE
@pytest.mark.parametrize("amplitude", SIZES)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", MATERIALS)
def test_the_work_of_a_step_is_the_change_of_energy(shape, name, law, amplitude, distorted):
    """With everything at once, for random steps from next to nothing to several per cent, whatever multiplier acts."""
    bulk_modulus = (np.inf, 3e5, None)[(LAWS.index(law) + SIZES.index(amplitude)) % 3]
    solid = make(distorted, shape, material=MATERIALS[name], bulk_modulus=bulk_modulus)
    start, end = pair(solid, 11, amplitude)
    active = law_of(law, solid, 11)
    acting = 0.3 * start.multiplier + 0.7 * end.multiplier
    found = solid.step_balance(start, end, active, TIMES, multiplier=acting)
    works = solid.step_works(start, end, active, TIMES, multiplier=acting)
    before, after = stored(solid, start, active, TIMES[0]), stored(solid, end, active, TIMES[1])
    change = after - before - works.external - works.active + works.viscous - works.numerical
    work = found.force @ (end.displacement - start.displacement)
    scale = abs(before) + abs(after) + abs(works.external) + abs(works.viscous) + abs(works.numerical)
    assert abs(works.external) > 0.0
    assert abs(work - change) < 2e-14 * scale
    assert (works.active != 0.0) == (law == "hill")
    assert works.viscous > 0.0


@ANY_SHAPE
@given(SEEDS, st.floats(-9.0, -3.4))
@settings(max_examples=10)
def test_the_work_of_a_step_is_the_change_of_energy_at_any_size(shape, distorted, seed, size):
    """The same for random steps of any size: no threshold of the correction shows."""
    solid = free(distorted, shape, material=MATERIALS["transversely_isotropic"], viscosity=None, bulk_modulus=None)
    start, end = pair(solid, seed, 10.0**size)
    law = law_of("affine", solid, seed)
    work = solid.step_balance(start, end, law, TIMES).force @ (end.displacement - start.displacement)
    before, after = (stored(solid, motion, law, TIMES[0]) for motion in (start, end))
    assert abs(work - (after - before)) < 2e-14 * (abs(before) + abs(after))


@ANY_SHAPE
def test_steps_across_a_jump_of_the_tangent_conserve_too(shape, distorted):
    """Fibres that go slack within the step: the Gauss rule alone is wrong by a share of D^2."""
    solid = free(distorted, shape, material=MATERIALS["holzapfel_ogden"], viscosity=None, bulk_modulus=None)
    start, end = pair(solid, 3, 2e-6)
    start, end = (
        attrs.evolve(start, displacement=0.01 * start.displacement),
        attrs.evolve(end, displacement=0.01 * start.displacement + end.displacement - start.displacement),
    )
    crossed = (solid.stretch(start.displacement, 0.0) - 1.0) * (solid.stretch(end.displacement, 0.0) - 1.0) < 0.0
    assert crossed.sum() > 3
    work = solid.step_balance(start, end, None, TIMES).force @ (end.displacement - start.displacement)
    change = solid.elastic_energy(end.displacement) - solid.elastic_energy(start.displacement)
    volume = solid.site_volumes.sum()
    assert abs(work - change) < 1e-13 * solid._body.modulus * volume


@ANY_SHAPE
def test_numerical_work_of_the_multipliers(shape, distorted):
    """Where the constraint holds at both ends, the end-point one takes |p1 - p0|^2 / 2 kappa, the mean nothing."""
    solid = make(distorted, shape)
    start, end = pair(solid, 4, 2e-4)
    body = solid._body

    def obeying(motion, time):
        change = volume_change(body, body.displacement(motion.displacement, time))
        return attrs.evolve(motion, multiplier=3e5 * body.projection(change))

    start, end = obeying(start, TIMES[0]), obeying(end, TIMES[1])
    jump = end.multiplier - start.multiplier
    expected = -0.5 / 3e5 * jump @ (body.multiplier_mass @ jump)
    assert solid.step_works(start, end, None, TIMES).numerical == pytest.approx(expected, rel=1e-9)
    assert expected < 0.0
    mean = solid.step_works(start, end, None, TIMES, multiplier=end.multiplier - 0.5 * jump).numerical
    assert abs(mean) < 1e-12 * abs(expected)


def test_which_constraint_is_stiff(distorted):
    for bulk_modulus, stiff in ((np.inf, True), (1e9, True), (1.1e6, True), (1e6, False), (3e5, False)):
        assert make(distorted, "triangle", bulk_modulus=bulk_modulus).stiff_constraint == stiff


# ---------------------------------------------------------------------- force and tangent


@ANY_SHAPE
@pytest.mark.parametrize("law", LAWS)
def test_short_steps_are_the_balance(shape, law, distorted):
    """As the step shrinks at a given velocity, force and constraint become those of the point, at order 1."""
    solid = make(distorted, shape)
    start, _ = pair(solid, 5, 0.0)
    active = law_of(law, solid, 5)
    v = np.random.default_rng(6).uniform(-0.1, 0.1, solid.n_unknowns)
    point = solid.balance(attrs.evolve(start, velocity=v), active, TIMES[0])
    errors = []
    for dt in (2e-6, 1e-6):
        end = attrs.evolve(start, displacement=start.displacement + dt * v)
        found = solid.step_balance(start, end, active, (TIMES[0], TIMES[0] + dt))
        errors.append(np.linalg.norm(found.force - point.force) / np.linalg.norm(point.force))
        close(found.constraint, point.constraint, 1e-2)
        assert found.constraint_magnitude == point.constraint_magnitude
    assert errors[0] < 1e-2
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.05), f"observed order of {errors}"


@ANY_SHAPE
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("name", "amplitude"), [(name, 3e-4) for name in MATERIALS] + [("mooney_rivlin", 1e-6)])
def test_tangent_is_the_derivative(shape, name, amplitude, law, distorted):
    """By displacement and multiplier at the end, along random directions; with and without the correction."""
    solid = make(distorted, shape, material=MATERIALS[name])
    start, end = pair(solid, 7, amplitude)
    active = law_of(law, solid, 7)
    generator = np.random.default_rng(8)
    du, dp = (generator.uniform(-1.0, 1.0, x.size) for x in (end.displacement, end.multiplier))

    def at(shift):
        moved = attrs.evolve(end, displacement=end.displacement + shift)
        return solid.step_balance(start, moved, active, TIMES, multiplier=end.multiplier)

    found = solid.step_balance(start, end, active, TIMES, tangent=True)
    assert not found.symmetric
    close(found.force, at(0.0).force, 1e-13)  # two compiled functions of the material: the same to round-off
    assert found.damping is None
    # Steps so short that no fibre goes slack within the difference.
    close(found.stiffness @ du, difference(lambda x: at(x).force, du, 1e-8), 1e-6)
    close(found.constraint_gradient @ du, difference(lambda x: at(x).constraint, du, 2e-7), 1e-8)
    moved = attrs.evolve(end, multiplier=end.multiplier + dp)
    close(found.acting_gradient.T @ dp, solid.step_balance(start, moved, active, TIMES).force - found.force, 1e-8)
    softer = solid.step_balance(start, moved, active, TIMES).constraint - found.constraint
    close(found.constraint_compliance @ dp, -softer, 1e-6)


@ANY_SHAPE
@pytest.mark.parametrize("elements", ["with multiplier", "without"])
def test_force_is_that_of_plain_tensor_algebra(shape, elements, distorted):
    """No lanes, no batches, no pattern: every entry of the force, from the equations as they are written."""
    bulk = np.inf if elements == "with multiplier" else None
    solid = make(distorted, shape, load=(), gravity=None, bulk_modulus=bulk, material=MATERIALS["guccione"])
    start, end = pair(solid, 9, 3e-4)
    law, body = law_of("affine", solid, 9), solid._body
    grid, material = body.grid, solid.material
    f0, f1 = deformation(solid, start.displacement, TIMES[0]), deformation(solid, end.displacement, TIMES[1])
    c0, c1 = (np.swapaxes(f, 1, 2) @ f for f in (f0, f1))
    strain = 0.5 * (c1 - c0)

    def ask(function, f, rows):
        found = np.empty((grid.n_points, rows))
        for point in range(grid.n_points):
            state, out = np.zeros((15, LANES)), np.zeros((54, LANES))
            state[:12, 0] = [*f[point].ravel(), *body.fibre[:, point]]
            state, out = state.ravel(), out.ravel()
            function(1, state, out, material.constants)
            found[point] = out.reshape(54, LANES)[:rows, 0]
        return found

    stress = np.zeros_like(f0)
    for sign in (-1.0, 1.0):
        u = np.swapaxes(np.linalg.cholesky(0.5 * (c0 + c1) + sign / np.sqrt(3.0) * strain), 1, 2)
        stress += 0.5 * np.linalg.inv(u) @ ask(material.functions().stress, u, 9).reshape(-1, 3, 3)
    energies = [ask(material.functions().energy, f, 1)[:, 0] for f in (f0, f1)]
    gap = energies[1] - energies[0] - np.einsum("pij,pij->p", stress, strain)
    stress += (gap / np.einsum("pij,pij->p", strain, strain))[:, None, None] * strain
    stress += 12.0 / (TIMES[1] - TIMES[0]) * strain
    normal = body.fibre.T
    l0, l1 = (np.sqrt(np.einsum("pi,pij,pj->p", normal, c, normal)) for c in (c0, c1))
    tension = at_points(body, law.evaluate(0.5 * (l0 + l1), 0.0 * l0).tension)
    stress += (2.0 * tension / (l0 + l1))[:, None, None] * np.einsum("pi,pj->pij", normal, normal)
    if bulk is not None:
        cofactors = [np.linalg.det(c)[:, None, None] * np.linalg.inv(c) for c in (c0, 0.5 * (c0 + c1), c1)]
        mean = (cofactors[0] + 4.0 * cofactors[1] + cofactors[2]) / 6.0
        cells = grid.multipliers[grid.cell_of_point]
        shapes = grid.cell.shapes[grid.quadrature_of_point]
        pressure = np.einsum("pk,pk->p", body.pressure(end.multiplier)[cells], shapes)
        jacobians = np.linalg.det(f0) + np.linalg.det(f1)
        stress += (2.0 * pressure / jacobians)[:, None, None] * mean
    nodal = np.einsum(
        "p,pij,pjk,pak->pai",
        grid.volumes,
        0.5 * (f0 + f1),
        stress,
        np.pad(gradients(solid), ((0, 0), (0, 0), (0, 3 - grid.dimension))),
    )[:, :, : grid.dimension]
    expected = np.zeros((grid.n_nodes, grid.dimension))
    np.add.at(expected, grid.nodes[grid.cell_of_point], nodal)
    expected = expected.ravel()[body.free]
    found = solid.step_balance(start, end, law, TIMES).force
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@ANY_SHAPE
def test_cells_in_another_order_give_the_same_forces(shape, distorted):
    found = []
    for shuffled in (False, True):
        solid = free(distorted, shape, mesh=distorted(shape, shuffled=shuffled), bulk_modulus=None)
        body = solid._body
        x = body.grid.positions
        order = np.lexsort(np.round(x, 9).T)
        start, end = (
            Motion(amount * np.sin(300.0 * x[:, ::-1] + phase).ravel(), np.zeros(x.size))
            for amount, phase in ((3e-4, 0.2), (5e-4, 1.0))
        )
        law = AffineLaw(*np.array([[1.0], [8e3], [4e4]]) * np.ones(solid.n_sites))
        found.append(solid.step_balance(start, end, law, TIMES).force.reshape(x.shape)[order])
        assert found[0].shape == found[-1].shape
    assert np.abs(found[0] - found[1]).max() < 1e-12 * np.abs(found[0]).max()


def test_threads_change_no_bit():
    """Blocks of one colour share no node: the order of every sum is fixed."""
    found = []
    for threads in (1, 2):
        mesh = Block(size=(0.03, 0.02, 0.02), cells=(7, 6, 6), shape="tetrahedron")
        solid = FiniteElement(mesh=mesh, material=MooneyRivlin(), bulk_modulus=np.inf, threads=threads)
        assert solid._body.grid.n_cells > 1000
        start, end = pair(solid, 1, 1e-4)
        balance = solid.step_balance(start, end, law_of("affine", solid, 1), TIMES, tangent=True)
        found.append((balance.force, balance.stiffness.data, balance.acting_gradient.data))
    for one, other in zip(*found, strict=True):
        assert np.array_equal(one, other)


# ---------------------------------------------------------------------- momenta


@pytest.mark.parametrize(("shape", "steps"), [("quadrilateral", 100), ("tetrahedron", 15)])
def test_free_flight_conserves(shape, steps, distorted):
    """Strictly incompressible, stretched by a quarter and sheared, thrown with spin: energy and momenta stay."""
    solid = free(distorted, shape, bulk_modulus=np.inf, viscosity=None)
    d = solid._body.grid.dimension
    x = solid._body.grid.positions
    stretch = np.diag([1.25, 0.8, 1.0][:d])  # keeps the volume
    stretch[0, 1] = 0.1
    rest = solid.rest_motion()
    spin = np.array([[0.0, -12.0, 5.0], [12.0, 0.0, -3.0], [-5.0, 3.0, 0.0]])[:d, :d]
    velocity = x @ stretch.T @ spin.T + np.array([0.3, -0.2, 0.1])[:d]
    motion = attrs.evolve(rest, displacement=(x @ stretch.T - x).ravel(), velocity=velocity.ravel())
    law = AffineLaw(*np.array([[1.0], [2e4], [3e5]]) * np.ones(solid.n_sites))

    def energies(motion):
        return 0.5 * motion.velocity @ (solid.mass_matrix @ motion.velocity), stored(solid, motion, law, 0.0)

    first, energy, memory, integrator = motion, [], {}, EnergyMomentum()
    for step in range(steps + 1):
        energy.append(energies(motion))
        change = volume_change(solid._body, motion.displacement)
        assert np.linalg.norm(change) < 1e-10 * solid._body.constraint_magnitude
        if step < steps:
            motion, memory, report = integrator.step(solid, law, motion, memory, 1e-3 * step, 1e-3)
            assert report.converged, report.reason
    kinetic, held = np.array(energy).T
    assert np.ptp(kinetic) > 0.2 * kinetic[0]
    total = kinetic + held
    assert np.abs(total - total[0]).max() < 1e-10 * (kinetic[0] + solid.elastic_energy(first.displacement))
    for momentum in (solid.momentum, solid.angular_momentum):
        assert np.linalg.norm(momentum(first)) > 0.0
        assert np.linalg.norm(momentum(motion) - momentum(first)) < 1e-10 * np.linalg.norm(momentum(first))
    assert np.linalg.norm(motion.displacement - first.displacement) > 0.1 * np.linalg.norm(x)


@ANY_SHAPE
@pytest.mark.parametrize("law", LAWS)
@given(SEEDS)
@settings(max_examples=3)
def test_no_net_force_and_no_torque_about_the_middle(shape, law, distorted, seed):
    """Of a free body: linear and angular momentum do not change, whatever the step."""
    solid = free(distorted, shape, material=MATERIALS["guccione"])
    start, end = pair(solid, seed, 4e-4)
    d = solid._body.grid.dimension
    force, place = np.zeros((2, solid.n_unknowns // d, 3))
    force[:, :d] = solid.step_balance(start, end, law_of(law, solid, seed), TIMES).force.reshape(-1, d)
    place[:, :d] = solid._body.grid.positions + 0.5 * (start.displacement + end.displacement).reshape(-1, d)
    largest = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-13 * largest
    assert np.abs(np.cross(place, force).sum(axis=0)).max() < 1e-13 * 0.03 * largest


@ANY_SHAPE
@given(SEEDS, st.floats(-7.0, 7.0))
@settings(max_examples=10)
def test_a_body_that_turns_by_any_angle_feels_nothing(shape, distorted, seed, angle):
    """From rest: no force, half a turn included. The midpoint rule would see a body that shrinks."""
    solid = free(distorted, shape)
    d = solid._body.grid.dimension
    axis = np.random.default_rng(seed).normal(size=3) if d == 3 else np.array([0.0, 0.0, 1.0])
    axis /= np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis)
    turn = (np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)[:d, :d]
    x = solid._body.grid.positions
    start = solid.rest_motion()
    end = attrs.evolve(start, displacement=(x @ turn.T - x).ravel())
    law = AffineLaw(*np.array([[1.0], [0.0], [4e4]]) * np.ones(solid.n_sites))
    found = solid.step_balance(start, end, law, TIMES)
    assert np.linalg.norm(found.force) < 1e-12 * found.magnitude
    assert np.linalg.norm(found.constraint) < 1e-13 * found.constraint_magnitude
    assert solid.step_works(start, end, law, TIMES).viscous < 1e-20
