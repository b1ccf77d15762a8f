"""Half-explicit Euler and RATTLE: closed forms, orders, conservation, and the failures that theory predicts."""

from __future__ import annotations

import functools
from typing import Any, final

import attrs
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import myobridge as mb
from myobridge.equilibria import Equilibria
from myobridge.interfaces import Balance, Motion
from myobridge.results import Checkpoint
from myobridge.solvers import constraint_at, largest_frequency, projected_velocity
from myobridge.testing import fitted_order
from myobridge_plugins.continuation.natural import Natural
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.time_integrator.half_explicit import HalfExplicit
from myobridge_plugins.time_integrator.rattle import Rattle
from myobridge_plugins.time_integrator.stoermer_verlet import StoermerVerlet
from myobridge_plugins.time_integrator.symplectic_euler import SymplecticEuler

GRAVITY = 9.81
LEFT = (Support(boundary="left"),)


@final
@attrs.frozen
class Crane(mb.MacroSolid):
    """A mass on a rigid rod whose length the support winds: c = (|x|^2 - l(t)^2) / 2l; multiplier in N."""

    angle: float = 1.0
    length: float = 0.4
    mass: float = 2.0
    winding: float = 0.0

    n_unknowns = 2  # pyright: ignore[reportAssignmentType]
    n_sites = 0  # pyright: ignore[reportAssignmentType]
    site_volumes = np.empty(0)  # pyright: ignore[reportAssignmentType]

    @property
    def mass_matrix(self) -> np.ndarray:
        return np.full(2, self.mass)

    def place(self, angle: float, length: float) -> np.ndarray:
        return length * np.array([np.sin(angle), -np.cos(angle)])

    def rest_motion(self) -> Motion:
        towards = self.place(self.angle, 1.0)
        return Motion(np.zeros(2), 0.5 * np.array([-towards[1], towards[0]]) + self.winding * towards, np.zeros(1))

    def stretch(self, displacement, time):
        return np.empty(0)

    def stretch_rate(self, displacement, velocity, time):
        return np.empty(0)

    def external_force(self, displacement, time):
        return np.array([0.0, -self.mass * GRAVITY])

    def balance(self, motion: Motion, law: Any, time: float, *, rate: bool = True, tangent: bool = False) -> Balance:
        x = self.place(self.angle, self.length) + motion.displacement
        length, p = self.length + self.winding * time, motion.multiplier[0]
        return Balance(
            p * x / length - self.external_force(motion.displacement, time),
            stiffness=p / length * np.eye(2) if tangent else None,
            constraint=np.array([(x @ x - length**2) / (2.0 * length)]),
            constraint_gradient=x[None] / length if tangent else None,
            magnitude=1.0,
            constraint_magnitude=self.length,
        )


def walk(solid, integrator, duration, steps, motion=None, law=None):
    """Motions of `steps` equal steps, by the integrator alone."""
    motion, memory, dt = motion or solid.rest_motion(), {}, duration / steps
    path = [motion]
    for step in range(steps):
        motion, memory, report = integrator.step(solid, law, motion, memory, step * dt, dt)
        assert report.converged, f"step {step}: {report.reason}"
        path.append(motion)
    return path


def block(cells=(8, 2), size=(0.1, 0.025), support=LEFT, **options):
    options.setdefault("bulk_modulus", np.inf)
    material = MooneyRivlin(**MooneyRivlin.parameter_sets["thesis"])
    return FiniteElement(mesh=Block(size=size, cells=cells), material=material, support=support, **options)


@functools.cache
def stretched(cells, traction):
    """Block and the motion in which an end traction [Pa] holds it in equilibrium; the traction is gone."""
    loads = (Traction(boundary="right", traction=(traction, 0.0)),)
    problem = Equilibria(block(cells, load=loads), None, of="load")
    path = Natural().trace(problem, problem.start)
    assert path.completed, path.reason
    return block(cells), problem.motion(path.points[-1].unknowns)


def energy(solid, motion):
    velocity = motion.velocity
    return solid.elastic_energy(motion.displacement) + 0.5 * velocity @ (solid.mass_matrix @ velocity)


def volume_error(solid, motion):
    """Largest nodal J - 1, in the space of the multipliers."""
    return float(np.abs(solid._body.projection(constraint_at(solid, motion.displacement, 0.0)[0])).max())


# ---------------------------------------------------------------------- orders, without and with a constraint


@pytest.mark.parametrize("winding", [0.0, 0.1])
@pytest.mark.parametrize(
    "integrator",
    [Rattle(), HalfExplicit(), HalfExplicit(sequence="symplectic")],
    ids=["rattle", "textbook", "symplectic"],
)
def test_order_of_a_pendulum_on_a_rod_that_is_wound(integrator, winding) -> None:
    r"""l phi'' + 2 l' phi' + g sin phi = 0."""
    crane, duration = Crane(winding=winding), 0.6

    def rate(t, y):
        length = crane.length + winding * t
        return [y[1], -(2.0 * winding * y[1] + GRAVITY * np.sin(y[0])) / length]

    start = [crane.angle, 0.5 / crane.length]
    angle = solve_ivp(rate, (0.0, duration), start, rtol=1e-12, atol=1e-12).y[0, -1]
    expected = crane.place(angle, crane.length + winding * duration) - crane.place(crane.angle, crane.length)
    counts = [100, 200, 400]
    ends = [walk(crane, integrator, duration, n)[-1] for n in counts]
    errors = [float(np.linalg.norm(end.displacement - expected)) for end in ends]
    order = fitted_order([duration / n for n in counts], errors)
    assert abs(order - integrator.order) < 0.15, f"observed order {order:.3f}, errors {errors}"
    kept = abs(constraint_at(crane, ends[0].displacement, duration)[0][0])
    if isinstance(integrator, Rattle):
        assert kept < 1e-15
    else:
        assert kept > 1e-6  # it is the velocity alone that these look at


@pytest.mark.parametrize(
    ("mine", "classical"),
    [(Rattle(), StoermerVerlet()), (HalfExplicit(sequence="symplectic"), SymplecticEuler())],
    ids=["rattle", "symplectic"],
)
def test_without_constraint_they_are_the_classical_methods(mine, classical) -> None:
    velocity = tuple(0.3 * np.cos(np.arange(9.0)))
    chain = Chain(springs=3, length=0.3, modulus=2e4, mass=0.3, dimension="3", velocity=velocity)
    ends = []
    for integrator in (mine, classical):
        model = Liouville(p_max=2e3)
        simulation = mb.Simulation(solid=chain, cross_bridges=model, integrator=integrator, dt=2e-4).run(0.02)
        ends.append((simulation.motion, simulation.ledger))
    np.testing.assert_allclose(ends[0][0].displacement, ends[1][0].displacement, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(ends[0][0].velocity, ends[1][0].velocity, rtol=1e-12, atol=1e-14)
    assert ends[0][1].kinetic == pytest.approx(ends[1][1].kinetic, rel=1e-12)
    assert np.abs(ends[0][0].displacement).max() > 1e-3


def test_textbook_euler_on_a_spring_grows_as_the_closed_form_says() -> None:
    """Each step multiplies the amplitude by sqrt(1 + omega^2 dt^2)."""
    spring, dt, steps = Spring(mass=2.0, stiffness=200.0, displacement=0.01), 1e-3, 200
    end = walk(spring, HalfExplicit(), steps * dt, steps)[-1]
    amplitude = np.hypot(end.displacement[0], end.velocity[0] / 10.0)
    assert amplitude == pytest.approx(0.01 * (1.0 + (10.0 * dt) ** 2) ** (steps / 2), rel=1e-12)


# ---------------------------------------------------------------------- incompressible bodies


def test_half_explicit_euler_in_the_order_of_the_textbook_grows_at_the_rate_predicted() -> None:
    """omega^2 dt / 2 of the highest frequency that is there, within 10 %: 1000/s at a step of 10 us."""
    solid, dt, steps = block(), 1e-5, 200
    rest = solid.rest_motion()
    found = largest_frequency(solid, None, rest, 0.0)
    shape = 1e-4 * found.shape / np.abs(found.shape).max()
    start = Motion(rest.displacement, found.omega * shape, rest.multiplier)
    path = walk(solid, HalfExplicit(), steps * dt, steps, start)
    growth = 0.5 * np.log(energy(solid, path[-1]) / energy(solid, path[0])) / (steps * dt)
    predicted = 0.5 * found.omega**2 * dt
    print(f"half-explicit Euler grows at {growth:.0f}/s, predicted {predicted:.0f}/s")
    assert growth == pytest.approx(predicted, rel=0.1)
    other = walk(solid, HalfExplicit(sequence="symplectic"), steps * dt, steps, start)
    assert energy(solid, other[-1]) == pytest.approx(energy(solid, other[0]), rel=0.1)


def test_the_symplectic_order_survives_a_release_and_drifts_from_the_constraint() -> None:
    solid, start = stretched((8, 2), 1.1e5)
    # Half the limit of the constrained frequencies.
    dt = 0.5 * Rattle().largest_step(solid, None, start, 0.0)
    path = walk(solid, HalfExplicit(sequence="symplectic"), 250 * dt, 250, start)
    energies = np.array([energy(solid, motion) for motion in path])
    assert energies.max() < 1.5 * energies[0]
    drift = [volume_error(solid, motion) for motion in path]
    print(f"J - 1 drifts to {max(drift):.3f}")
    assert drift[0] < 1e-10
    assert drift[-1] > 1e-2


def test_rattle_keeps_volume_and_bounds_the_energy_in_a_release() -> None:
    """The reference block of numerics, 30 % release: stable at 6e-5 s, below 2 / omega_max = 6.6e-5 s."""
    solid, start = stretched((16, 4), 1.12e5)
    stretch = solid.visible_fields(start, 0.0)["displacement"][:, 0].max() / 0.1
    assert 0.25 < stretch < 0.35
    rattle, dt = Rattle(limit="ignore"), 6e-5
    limit = rattle.largest_step(solid, None, start, 0.0)
    assert dt < limit < 1e-4
    path = walk(solid, rattle, 60 * dt, 60, start)
    energies = np.array([energy(solid, motion) for motion in path])
    assert np.abs(energies / energies[0] - 1.0).max() < 2e-3
    assert max(volume_error(solid, motion) for motion in path) < 1e-13
    assert solid.elastic_energy(path[-1].displacement) < 0.97 * energies[0]  # and it did let go


def test_rattle_fails_beyond_its_limit_and_halves_where_it_may() -> None:
    solid, start = stretched((16, 4), 1.12e5)
    motion, memory, rattle = start, {}, Rattle(limit="ignore")
    for step in range(30):
        motion, memory, report = rattle.step(solid, None, motion, memory, step * 1e-4, 1e-4)
        if not report.converged:
            break
    else:
        pytest.fail("a step of 1e-4 s went well for 30 steps")
    guarded = Rattle()
    motion, memory, report = guarded.step(solid, None, start, {}, 0.0, 1e-4)
    assert not report.converged
    assert "beyond the stability limit 2 / omega_max = 6.6" in report.reason
    assert motion is start


def test_a_simulation_with_rattle_halves_to_the_limit_and_resumes_bit_by_bit() -> None:
    solid, dt = block((4, 2)), 8e-4

    def simulation():
        made = mb.Simulation(solid=solid, integrator=Rattle(), dt=dt)
        velocity = 0.1 * np.sin(np.arange(solid.n_unknowns))
        rest = made.motion
        velocity = projected_velocity(solid, velocity, rest.multiplier, rest.displacement, 0.0, dt)
        made.motion = attrs.evolve(rest, velocity=velocity)
        return made

    whole = simulation()
    limit = Rattle().largest_step(solid, None, whole.motion, 0.0)
    assert limit < dt
    times = [0.0]
    for _ in range(80):
        whole.step()
        times.append(whole.time)
    assert 0.5 * limit < np.diff(times).max() < limit
    interrupted = simulation()
    for _ in range(41):
        interrupted.step()
    continued = simulation()
    Checkpoint.take(interrupted).restore(continued)
    for _ in range(39):
        continued.step()
    np.testing.assert_array_equal(continued.motion.displacement, whole.motion.displacement)
    np.testing.assert_array_equal(continued.motion.velocity, whole.motion.velocity)


def test_cross_bridges_lower_the_limit_of_rattle() -> None:
    solid = block((4, 2))
    rest = solid.rest_motion()
    limits = []
    for scale in (0.0, 1.0):
        law = Liouville(p_max=7.3e4).active_law
        state = Liouville(p_max=7.3e4).initial_state(solid.n_sites)
        frozen = law(state, np.ones(solid.n_sites), np.ones(solid.n_sites)).scaled(
            np.full(solid.n_sites, scale * 7.3e4)
        )
        limits.append(Rattle().largest_step(solid, frozen, rest, 0.0))
    assert limits[1] < 0.8 * limits[0]


def test_rattle_in_free_flight_keeps_both_momenta() -> None:
    solid = block((4, 2), support=())
    rest = solid.rest_motion()
    place = solid._body.grid.positions
    bend = np.stack([0.3 - 2.0 * place[:, 1], 0.1 + 8.0 * np.sin(60.0 * place[:, 0])], axis=1).ravel()
    velocity = projected_velocity(solid, bend, rest.multiplier, rest.displacement, 0.0, 1e-4)
    path = walk(solid, Rattle(), 0.015, 200, attrs.evolve(rest, velocity=velocity))
    first, last = path[0], path[-1]
    momentum, turning = solid.momentum(first), solid.angular_momentum(first)[2]
    assert np.linalg.norm(solid.momentum(last) - momentum) < 1e-12 * np.linalg.norm(momentum)
    assert abs(solid.angular_momentum(last)[2] / turning - 1.0) < 1e-11
    energies = np.array([energy(solid, motion) for motion in path])
    assert np.abs(energies / energies[0] - 1.0).max() < 2e-2
    elastic = max(solid.elastic_energy(motion.displacement) for motion in path)
    assert elastic > 0.1 * energies[0]  # it swings while it flies


def test_external_work_is_booked() -> None:
    """A load that pulls: kinetic and elastic energy are its work, but for what the method swings about it."""
    load = (Traction(boundary="right", traction=(5e3, 1e3), scale=Ramp(initial=0.0, final=1.0, end=5e-3)),)
    solid = block((4, 2), load=load)
    simulation = mb.Simulation(solid=solid, integrator=Rattle(), dt=5e-5).run(0.01)
    ledger = simulation.ledger
    assert ledger.external > 1e-4
    assert ledger.kinetic + ledger.elastic == pytest.approx(ledger.external, rel=1e-3)
    assert ledger.kinetic > 0.05 * ledger.external


@pytest.mark.parametrize("integrator", [Rattle(), HalfExplicit(sequence="symplectic")], ids=["rattle", "symplectic"])
def test_a_constraint_with_compliance_is_followed_like_a_spring(integrator) -> None:
    """Volume may change: pressure is kappa (J - 1), and the energy stored in it is in the balance."""
    solid = block((4, 2), bulk_modulus=1e6, support=LEFT)
    rest = solid.rest_motion()
    velocity = 0.5 * np.sin(40.0 * np.arange(solid.n_unknowns))
    path = walk(solid, integrator, 2e-3, 200, attrs.evolve(rest, velocity=velocity))
    energies = np.array([energy(solid, motion) for motion in path])
    assert np.abs(energies / energies[0] - 1.0).max() < 0.05
    pressures = solid._body.projection(constraint_at(solid, path[-1].displacement, 0.0)[0]) * 1e6
    if isinstance(integrator, Rattle):
        np.testing.assert_allclose(path[-1].multiplier, pressures, rtol=1e-9)
    assert np.abs(pressures).max() > 1e3


@pytest.mark.parametrize(
    "integrator", [StoermerVerlet(), SymplecticEuler()], ids=["stoermer_verlet", "symplectic_euler"]
)
def test_methods_that_keep_no_constraint_refuse_a_strict_one_and_take_one_with_compliance(integrator) -> None:
    with pytest.raises(mb.SceneError, match=r"keeps no constraint, and FiniteElement has a strict one; use rattle"):
        mb.Simulation(solid=block((4, 2)), integrator=integrator)
    solid = block((4, 2), bulk_modulus=1e5, velocity_at_start=(0.3, 0.2))
    simulation = mb.Simulation(solid=solid, integrator=integrator, dt=2e-5)
    energy_before = simulation.ledger.kinetic
    simulation.run(4e-3)
    ledger = simulation.ledger
    assert ledger.kinetic + ledger.elastic == pytest.approx(energy_before, rel=0.05)
    assert ledger.elastic > 0.1 * energy_before
