"""The implicit stage with a constraint, on bodies of two and four unknowns: a pendulum and an incompressible quad."""

from __future__ import annotations

from typing import Any, final

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from myobridge.interfaces import (
    Balance,
    KeptTangent,
    LinearSystem,
    MacroSolid,
    Motion,
    NewtonMethod,
    NewtonProblem,
    NewtonResult,
)
from myobridge.solvers import Ordinary
from myobridge.testing import fitted_order
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.bathe import Bathe
from myobridge_plugins.time_integrator.bdf2 import BDF2
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum
from myobridge_plugins.time_integrator.generalised_alpha import GeneralisedAlpha
from myobridge_plugins.time_integrator.midpoint import Midpoint
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

GRAVITY = 9.81
IMPLICIT = (EnergyMomentum(), Midpoint(), BackwardEuler(), BDF2(), Bathe(), GeneralisedAlpha())


class Toy(MacroSolid):
    """What the toys share: no fibres."""

    @property
    def n_sites(self) -> int:
        return 0

    @property
    def site_volumes(self) -> np.ndarray:
        return np.empty(0)

    def stretch(self, displacement: np.ndarray, time: float) -> np.ndarray:
        return np.empty(0)

    def stretch_rate(self, displacement: np.ndarray, velocity: np.ndarray, time: float) -> np.ndarray:
        return np.empty(0)


@final
@attrs.frozen
class Pendulum(Toy):
    """A mass on a rigid rod: c = (|x|^2 - l^2) / 2l, multiplier the force in the rod [N]."""

    gravity: float = GRAVITY
    angle: float = 1.0
    speed: float = 0.5
    length: float = 0.4
    mass: float = 2.0

    @property
    def n_unknowns(self) -> int:
        return 2

    @property
    def mass_matrix(self) -> np.ndarray:
        return np.full(2, self.mass)

    @property
    def multiplier_scale(self) -> float:
        return 50.0

    def place(self, angle: float) -> np.ndarray:
        return self.length * np.array([np.sin(angle), -np.cos(angle)])

    def rest_motion(self) -> Motion:
        direction = np.array([np.cos(self.angle), np.sin(self.angle)])
        return Motion(np.zeros(2), self.speed * direction, np.zeros(1))

    def external_force(self, displacement: np.ndarray, time: float) -> np.ndarray:
        return np.array([0.0, -self.mass * self.gravity])

    def balance(self, motion: Motion, law: Any, time: float, *, rate: bool = True, tangent: bool = False) -> Balance:
        x = self.place(self.angle) + motion.displacement
        force = motion.multiplier[0] * x / self.length - self.external_force(motion.displacement, time)
        return Balance(
            force,
            stiffness=motion.multiplier[0] / self.length * np.eye(2) if tangent else None,
            constraint=np.array([(x @ x - self.length**2) / (2.0 * self.length)]),
            constraint_gradient=x[None] / self.length if tangent else None,
            magnitude=self.mass * self.gravity + abs(float(motion.multiplier[0])),
            constraint_magnitude=self.length,
        )


@final
@attrs.frozen
class Quad(Toy):
    """Four corners, the left two held, edges and diagonals springs; c = area - 1 - p / kappa, one multiplier.

    Dashpots lie along the springs' unknowns, and a dead load grows with time.
    """

    bulk_modulus: float = np.inf
    stiffness: float = 300.0
    damping: float = 2.0
    load: tuple[float, float, float, float] = (30.0, 20.0, 10.0, 40.0)

    @property
    def n_unknowns(self) -> int:
        return 4

    @property
    def mass_matrix(self) -> np.ndarray:
        return np.array([1.0, 1.0, 1.5, 1.5])

    @property
    def multiplier_scale(self) -> float:
        return self.stiffness

    def rest_motion(self) -> Motion:
        return Motion(np.zeros(4), np.zeros(4), np.zeros(1))

    def external_force(self, displacement: np.ndarray, time: float) -> np.ndarray:
        return time * np.array(self.load)

    def area(self, displacement: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Area, its gradient and its second derivative: corners (0,0), (1,0)+u, (1,1)+w, (0,1)."""
        twice = np.zeros((4, 4))
        twice[0, 3], twice[1, 2] = 1.0, -1.0
        twice = twice + twice.T  # x1 y2 - y1 x2
        linear = np.array([0.0, 0.0, 1.0, 0.0])  # x2 y3 - y2 x3 with corner 3 at (0, 1)
        x = np.array([1.0, 0.0, 1.0, 1.0]) + displacement
        return 0.5 * float(0.5 * x @ twice @ x + linear @ x), 0.5 * (twice @ x + linear), 0.5 * twice

    def balance(self, motion: Motion, law: Any, time: float, *, rate: bool = True, tangent: bool = False) -> Balance:
        u, p = motion.displacement, float(motion.multiplier[0])
        springs = self.stiffness * (2.0 * np.eye(4) - np.eye(4, k=2) - np.eye(4, k=-2))
        cubic = self.stiffness * u**3  # so that Newton has something to do
        area, gradient, second = self.area(u)
        external = self.external_force(u, time)
        damping = self.damping * np.eye(4)
        force = springs @ u + cubic + p * gradient + damping @ motion.velocity - external
        softness = None if np.isinf(self.bulk_modulus) else np.array([[1.0 / self.bulk_modulus]])
        return Balance(
            force,
            stiffness=springs + np.diag(3.0 * self.stiffness * u**2) + p * second if tangent else None,
            damping=damping if tangent else None,
            constraint=np.array([area - 1.0 - p / self.bulk_modulus]),
            constraint_gradient=gradient[None] if tangent else None,
            constraint_compliance=softness if tangent else None,
            magnitude=float(np.linalg.norm(external)) + abs(p),
            constraint_magnitude=1.0,
        )


@final
@attrs.frozen
class Checked(NewtonMethod):
    """The ordinary method, after a look at the tangent where it starts: differences of the residual, 4th order."""

    def solve(self, problem: NewtonProblem, start: np.ndarray, kept: KeptTangent | None = None) -> NewtonResult:
        x = start + 0.01 * np.cos(np.arange(start.size))
        tangent = problem.tangent(x)
        assert isinstance(tangent, LinearSystem)
        step = 1e-3
        columns = []
        for direction in np.eye(start.size):
            near = [problem.residual(x + k * step * direction)[0] for k in (1, -1, 2, -2)]
            columns.append((8.0 * (near[0] - near[1]) - (near[2] - near[3])) / (12.0 * step))
        expected = np.array(columns).T
        found = tangent.matrix().toarray()
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
        vector = np.arange(1.0, start.size + 1.0)
        np.testing.assert_allclose(tangent.times(vector), expected @ vector, atol=1e-8 * np.abs(expected).max())
        assert tangent.symmetric == bool(np.abs(found - found.T).max() < 1e-12 * np.abs(found).max())
        return Ordinary().solve(problem, start)


def run(solid: MacroSolid, integrator: Any, duration: float, steps: int) -> list[Motion]:
    motion, memory, dt = solid.rest_motion(), {}, duration / steps
    path = [motion]
    for step in range(steps):
        motion, memory, report = integrator.step(solid, None, motion, memory, step * dt, dt)
        assert report.converged, report.reason
        path.append(motion)
    return path


@pytest.mark.parametrize("integrator", IMPLICIT, ids=lambda one: type(one).__name__)
def test_the_rod_keeps_its_length_at_the_end_of_every_step(integrator: Any) -> None:
    pendulum = Pendulum()
    path = run(pendulum, integrator, 1.0, 50)
    places = pendulum.place(pendulum.angle) + np.array([motion.displacement for motion in path])
    assert np.abs(np.linalg.norm(places, axis=1) / pendulum.length - 1.0).max() < 1e-12
    assert np.ptp(places[:, 0]) > 0.3  # and it did swing


@pytest.mark.parametrize("integrator", IMPLICIT, ids=lambda one: type(one).__name__)
def test_order_of_a_pendulum(integrator: Any) -> None:
    pendulum, duration = Pendulum(), 0.6
    exact = solve_ivp(
        lambda _, y: [y[1], -pendulum.gravity / pendulum.length * np.sin(y[0])],
        (0.0, duration),
        [pendulum.angle, pendulum.speed / pendulum.length],
        rtol=1e-12,
        atol=1e-12,
    ).y[0, -1]
    expected = pendulum.place(exact) - pendulum.place(pendulum.angle)
    counts = [40, 80, 160]
    errors = [float(np.linalg.norm(run(pendulum, integrator, duration, n)[-1].displacement - expected)) for n in counts]
    order = fitted_order([duration / n for n in counts], errors)
    assert abs(order - integrator.order) < 0.15, f"observed order {order:.3f}, errors {errors}"


@pytest.mark.parametrize("integrator", [EnergyMomentum(), Midpoint()], ids=lambda one: type(one).__name__)
def test_a_rod_under_tension_only_carries_its_centripetal_force(integrator: Any) -> None:
    """Without gravity: speed and angular momentum stay to round-off, the rod pulls with m v^2 / l."""
    pendulum = Pendulum(gravity=0.0)
    steps = 200
    path = run(pendulum, integrator, 1.0, steps)
    places = pendulum.place(pendulum.angle) + np.array([motion.displacement for motion in path])
    velocities = np.array([motion.velocity for motion in path])
    turning = places[:, 0] * velocities[:, 1] - places[:, 1] * velocities[:, 0]
    assert np.abs(turning / turning[0] - 1.0).max() < 1e-12
    np.testing.assert_allclose(-path[-1].multiplier[0], -pendulum.mass * 0.5**2 / 0.4, rtol=1e-4)


def test_the_energy_of_a_swinging_pendulum_stays_to_round_off() -> None:
    pendulum = Pendulum()

    def energy(motion: Motion) -> float:
        height = (pendulum.place(pendulum.angle) + motion.displacement)[1]
        return 0.5 * pendulum.mass * float(motion.velocity @ motion.velocity) + pendulum.mass * GRAVITY * height

    energies = np.array([energy(motion) for motion in run(pendulum, EnergyMomentum(), 10.0, 500)])
    assert np.abs(energies - energies[0]).max() <= 1e-12 * pendulum.mass * GRAVITY * pendulum.length


@pytest.mark.parametrize("bulk_modulus", [np.inf, 1e4])
@pytest.mark.parametrize("integrator", [QuasiStatic, *(type(one) for one in IMPLICIT)])
def test_the_quad_keeps_its_area_and_the_tangent_is_exact(integrator: Any, bulk_modulus: float) -> None:
    quad = Quad(bulk_modulus=bulk_modulus)
    path = run(quad, integrator(newton=Checked()), 1.0, 10)
    for motion in path:
        pressure = float(motion.multiplier[0])
        assert abs(quad.area(motion.displacement)[0] - 1.0 - pressure / bulk_modulus) < 1e-12
    assert np.abs(path[-1].displacement).max() > 0.01
    assert abs(path[-1].multiplier[0]) > 1.0


@settings(max_examples=30)
@given(load=st.tuples(*[st.floats(-60.0, 60.0)] * 4), logarithm=st.floats(2.0, 9.0))
def test_equilibrium_of_the_quad_under_any_load(load: tuple[float, ...], logarithm: float) -> None:
    quad = Quad(bulk_modulus=10.0**logarithm, load=load)  # pyright: ignore[reportArgumentType]
    motion = run(quad, QuasiStatic(), 1.0, 1)[-1]
    balance = quad.balance(motion, None, 1.0)
    assert balance.constraint is not None
    assert np.linalg.norm(balance.force) <= 1e-10 * max(balance.magnitude, 1.0)
    assert abs(balance.constraint[0]) < 1e-11


@pytest.mark.parametrize("integrator", IMPLICIT, ids=lambda one: type(one).__name__)
def test_a_step_a_million_times_too_short_is_solved(integrator: Any) -> None:
    """Mass over the step squared beside the rod's direction: unscaled, the tangent's condition is above 1e18."""
    pendulum, dt = Pendulum(), 1e-9
    motion = run(pendulum, integrator, 3 * dt, 3)[-1]
    start = pendulum.rest_motion()
    np.testing.assert_allclose(motion.displacement, 3 * dt * start.velocity, rtol=1e-6)
