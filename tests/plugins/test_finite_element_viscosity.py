r"""Viscosity of the finite-element solid (Kelvin and Voigt).

.. math:: S = \eta\,\dot E, \qquad f_v \cdot v = \int \eta\,\lVert \dot E \rVert^2 \ge 0
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge.interfaces import Motion
from myobridge.parameters import optional_effects
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

ANY_SHAPE = pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
SEEDS = st.integers(0, 2**32 - 1)
ETA = 25.0


def make(distorted, shape, **changed):
    given = {"mesh": distorted(shape), "material": MooneyRivlin(), "bulk_modulus": 3e5, "viscosity": ETA}
    return FiniteElement(**(given | changed))


def held(distorted, shape, **changed):
    """One end is shaken."""
    shaken = Support(boundary="left", displacement=2e-3, scale=Sine(amplitude=1.0, frequency=30.0))
    return make(distorted, shape, support=(shaken,), **changed)


def somewhere(solid, seed):
    """A random motion, deformed by some per cent."""
    generator = np.random.default_rng(seed)
    rest = solid.rest_motion()
    u, v = generator.uniform(-1.0, 1.0, (2, rest.displacement.size))
    return Motion(4e-4 * u, 0.1 * v, 1e4 * generator.uniform(-1.0, 1.0, rest.multiplier.size))


class Points:
    """Plain tensor algebra at the points of a solid."""

    def __init__(self, solid):
        body = solid._body
        grid, d = body.grid, body.grid.dimension
        corners = grid.mesh.p[:, grid.mesh.t[:, grid.order]]
        jacobian = np.einsum("xvc,qvm->cqxm", corners, grid.cell.map_slopes[:, :, :d])
        gradients = np.einsum("qam,cqmx->cqax", grid.cell.slopes[:, :, :d], np.linalg.inv(jacobian))
        self.gradients = gradients[grid.cell_of_point, grid.quadrature_of_point]
        self.nodes, self.body = grid.nodes[grid.cell_of_point], body

    def gradient(self, full):
        """Of a nodal vector, (n_points, dim, dim)."""
        return np.einsum("pai,paJ->piJ", full.reshape(-1, self.body.grid.dimension)[self.nodes], self.gradients)

    def force(self, stress):
        """Nodal force of a first Piola-Kirchhoff stress."""
        grid = self.body.grid
        found = np.zeros((grid.n_nodes, grid.dimension))
        np.add.at(found, self.nodes, np.einsum("p,piJ,paJ->pai", grid.volumes, stress, self.gradients))
        return found.ravel()


def symmetric(product):
    return 0.5 * (product + np.swapaxes(product, 1, 2))


def difference(function, direction, step):
    """Fourth-order central difference of `function` along `direction`."""
    values = [function(k * step * direction) for k in (-2.0, -1.0, 1.0, 2.0)]
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)


def close(found, expected, relative):
    assert np.linalg.norm(expected) > 0.0
    error = np.linalg.norm(found - expected) / np.linalg.norm(expected)
    assert error < relative, f"relative error {error:.2e}"


def test_it_is_an_effect():
    assert "viscosity" in optional_effects(FiniteElement)
    with pytest.raises(mb.ParameterError, match="viscosity"):
        FiniteElement(mesh=Block(size=(1.0, 1.0), cells=(1, 1)), material=MooneyRivlin(), viscosity=-1.0)


@ANY_SHAPE
def test_force_and_power_are_those_of_plain_tensor_algebra(shape, distorted):
    solid = held(distorted, shape)
    motion, time = somewhere(solid, 1), 0.01
    body, points = solid._body, Points(solid)
    f = np.eye(body.grid.dimension) + points.gradient(body.displacement(motion.displacement, time))
    full = body.velocity(motion.velocity, time)
    rate = symmetric(np.swapaxes(f, 1, 2) @ points.gradient(full))
    expected = points.force(ETA * f @ rate)
    assert np.linalg.norm(full[body.held.all_numbers]) > 0.0
    found = solid.viscous_force(motion, time)
    close(found, expected[body.free], 1e-13)
    power = ETA * body.grid.volumes @ np.einsum("pij,pij->p", rate, rate)
    assert expected @ full == pytest.approx(power, rel=1e-12)
    # In the balance, in the reactions, and nowhere without it.
    still = attrs.evolve(solid, viscosity=None)
    share = solid.balance(motion, None, time).force - still.balance(motion, None, time).force
    close(share, found, 1e-9)
    there, without = (one.reactions(motion, np.empty(0), time)["left"] for one in (solid, still))
    held_share = expected.reshape(-1, body.grid.dimension)[np.unique(body.held.numbers[0] // body.grid.dimension)]
    close(there - without, held_share.sum(axis=0), 1e-9)
    assert still.viscous_force(motion, time) is None
    assert np.array_equal(
        solid.balance(motion, None, time, rate=False).force, still.balance(motion, None, time, rate=False).force
    )


@ANY_SHAPE
@given(SEEDS)
@settings(max_examples=5)
def test_nothing_is_felt_by_a_body_that_flies_and_turns(shape, distorted, seed):
    """Any rigid velocity of any deformed body; any other one costs power."""
    solid = make(distorted, shape)
    motion = somewhere(solid, seed)
    d = solid._body.grid.dimension
    place = solid._body.grid.positions + motion.displacement.reshape(-1, d)
    generator = np.random.default_rng(seed)
    spin = generator.normal(size=(d, d))
    rigid = attrs.evolve(motion, velocity=(place @ (spin - spin.T) + generator.normal(size=d)).ravel())
    deforming = solid.viscous_force(motion, 0.0)
    assert np.abs(solid.viscous_force(rigid, 0.0)).max() < 1e-12 * np.abs(deforming).max()
    assert deforming @ motion.velocity > 0.0
    nodal, arm = np.zeros((2, len(place), 3))
    nodal[:, :d], arm[:, :d] = deforming.reshape(-1, d), place
    assert np.abs(nodal.sum(axis=0)).max() < 1e-13 * np.abs(nodal).sum()
    assert np.abs(np.cross(arm, nodal).sum(axis=0)).max() < 1e-13 * 0.03 * np.abs(nodal).sum()


@ANY_SHAPE
def test_tangents_are_derivatives(shape, distorted):
    """By velocity; and by displacement, where that leaves out how the rate of strain changes at a given velocity."""
    solid = held(distorted, shape, viscosity=2e3)
    motion, time = somewhere(solid, 2), 0.01
    still = attrs.evolve(solid, viscosity=None)
    du = np.random.default_rng(3).uniform(-1.0, 1.0, solid.n_unknowns)
    found = solid.balance(motion, None, time, tangent=True)
    assert found.symmetric
    for matrix in (found.stiffness, found.damping):
        assert abs(matrix - matrix.T).max() < 1e-13 * abs(matrix).max()

    def at(displacement=0.0, velocity=0.0):
        moved = Motion(motion.displacement + displacement, motion.velocity + velocity, motion.multiplier)
        return solid.viscous_force(moved, time)

    close(found.damping @ du, difference(lambda x: at(velocity=x), du, 1e-3), 1e-9)
    body, points = solid._body, Points(solid)
    f = np.eye(body.grid.dimension) + points.gradient(body.displacement(motion.displacement, time))
    moving = points.gradient(body.velocity(motion.velocity, time))
    change = np.zeros(body.n_full)
    change[body.free] = du
    left_out = 2e3 * f @ symmetric(np.swapaxes(points.gradient(change), 1, 2) @ moving)
    whole = difference(lambda x: at(displacement=x), du, 2e-7)
    expected = whole - points.force(left_out)[body.free]
    close(found.stiffness @ du - still.balance(motion, None, time, tangent=True).stiffness @ du, expected, 1e-8)
    assert np.linalg.norm(expected) > 1e-2 * np.linalg.norm(whole)
    statics = solid.balance(motion, None, time, rate=False, tangent=True)
    assert statics.damping is None


@ANY_SHAPE
def test_what_a_step_takes(shape, distorted):
    """Of a whole step: eta |E1 - E0|^2 / dt everywhere, where supports move too."""
    solid = held(distorted, shape)
    times = (0.01, 0.012)
    start, end = somewhere(solid, 4), somewhere(solid, 5)
    body, points = solid._body, Points(solid)
    strains = []
    for motion, time in zip((start, end), times, strict=True):
        f = np.eye(body.grid.dimension) + points.gradient(body.displacement(motion.displacement, time))
        strains.append(0.5 * np.swapaxes(f, 1, 2) @ f)
    change = strains[1] - strains[0]
    expected = ETA / 0.002 * body.grid.volumes @ np.einsum("pij,pij->p", change, change)
    assert solid.step_works(start, end, None, times).viscous == pytest.approx(expected, rel=1e-11)
    assert attrs.evolve(solid, viscosity=0.0).step_works(start, end, None, times).viscous == 0.0


@pytest.mark.parametrize("bulk_modulus", [np.inf, 3e5])
def test_a_shaken_body_calms_down_and_the_ledger_closes(bulk_modulus, distorted):
    """Work of the support that shakes it becomes energy that viscosity takes, to the last digit."""
    solid = held(distorted, "quadrilateral", bulk_modulus=bulk_modulus)
    simulation = mb.Simulation(solid=solid, integrator=EnergyMomentum(), dt=1e-3)
    residuals = []
    simulation.run(0.05, lambda simulation, _: residuals.append(abs(simulation.ledger.residual)))
    ledger = simulation.ledger
    assert ledger.viscous > 0.05 * ledger.largest
    assert ledger.external > ledger.viscous
    assert max(residuals) < 1e-10
    assert abs(ledger.numerical) < 1e-9 * ledger.largest
    assert simulation.iterations <= 5 * simulation.steps == 250


@pytest.mark.parametrize(
    "integrator", [BackwardEuler(), QuasiStatic(), EnergyMomentum()], ids=lambda one: type(one).__name__
)
def test_viscosity_is_in_every_implicit_method(integrator, distorted):
    """A viscous body follows its support later than one that is not, and the report says what was taken."""
    found = []
    for viscosity in (None, 300.0):
        solid = held(distorted, "triangle", viscosity=viscosity, bulk_modulus=np.inf)
        report, motion, memory = None, solid.rest_motion(), {}
        for step in range(4):
            motion, memory, report = integrator.step(solid, None, motion, memory, 1e-3 * step, 1e-3)
            assert report.converged, report.reason
        assert (report.viscous_work > 0.0) == bool(viscosity)
        found.append(motion.displacement)
    assert np.linalg.norm(found[1] - found[0]) > 1e-3 * np.linalg.norm(found[0])
