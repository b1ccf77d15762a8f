"""Stiff cross-bridges on a soft spring: what holds, and what fails as theory predicts (numerics of the coupling)."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.coupling import Corrected, Monolithic, Splitting, Staggered
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

LENGTH, AREA = 0.1, 1e-4


def soft_spring(model: mb.CrossBridgeModel, ratio: float, reaches: float = 0.5) -> Spring:
    """Passive spring `ratio` times softer than the isometric heads; a 5 Hz load swings it by so many reaches."""
    law = model.active_law(model.initial_state(1), np.ones(1), np.ones(1)).evaluate(np.ones(1), np.zeros(1))
    stiffness = float(law.stiffness[0]) * model.p_max * AREA / LENGTH / ratio
    force = float(law.tension[0]) * model.p_max * AREA
    swing = reaches * stiffness * LENGTH / model.gear
    return Spring(
        stiffness=stiffness, length=LENGTH, area=AREA, load=Sine(offset=force, amplitude=swing, frequency=5.0)
    )


def run(coupling: mb.CouplingScheme, ratio: float, dt: float, end: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Times and displacements [reach] of a quasi-static run."""
    model = Huxley()
    simulation = mb.Simulation(
        solid=soft_spring(model, ratio), cross_bridges=model, integrator=QuasiStatic(), coupling=coupling, dt=dt
    )
    times, moved = [], []

    def keep(state: mb.Simulation, _report: mb.StepReport) -> None:
        times.append(state.time)
        moved.append(state.motion.displacement[0] * model.gear / LENGTH)

    simulation.run(end, keep)
    return np.array(times), np.array(moved)


@pytest.fixture(scope="module")
def fine() -> dict[float, tuple[np.ndarray, np.ndarray]]:
    return {ratio: run(Monolithic(), ratio, 1e-4) for ratio in (5.0, 20.0)}


@pytest.mark.parametrize("ratio", [5.0, 20.0])
@pytest.mark.parametrize(
    ("coupling", "bound"),
    [(Splitting(), 0.35), (Corrected(), 0.02), (Monolithic(), 0.05)],
    ids=["splitting", "corrected", "monolithic"],
)
def test_stable_schemes_stay_near_the_fine_solution(fine, coupling, bound, ratio):
    """At a step of 10 ms, a twentieth of the load's period."""
    times, moved = run(coupling, ratio, 1e-2)
    exact = np.interp(times, *fine[ratio])
    error = np.abs(moved - exact).max() / np.abs(fine[ratio][1]).max()
    print(f"{type(coupling).__name__}, r = {ratio:g}: error {error:.2e}")
    assert np.abs(fine[ratio][1]).max() > 0.02
    assert error <= bound


@pytest.mark.parametrize("ratio", [5.0, 20.0])
@pytest.mark.parametrize("dt", [1e-3, 1e-5])
def test_staggering_amplifies_by_minus_the_ratio_of_stiffnesses(ratio, dt):
    """Frozen heads: an error of the displacement comes back -r times larger in each step, however small the step."""
    model = Liouville()
    spring = soft_spring(model, ratio, reaches=0.005)
    simulation = mb.Simulation(solid=spring, cross_bridges=model, integrator=QuasiStatic(), coupling=Staggered(), dt=dt)
    positions = [float(simulation.motion.displacement[0])]
    for _ in range(5):
        simulation.step()
        positions.append(float(simulation.motion.displacement[0]))
    # The load moves on by a little each step: differences of differences leave the amplification alone.
    changes = np.diff(positions)
    growth = changes[3:] / changes[2:-1]
    print(f"r = {ratio:g}, dt = {dt:g}: amplification {growth}")
    assert growth == pytest.approx(-ratio, rel=0.05)


@pytest.mark.parametrize("dt", [1e-2, 1e-3])
def test_staggering_fails_with_huxley_too_and_worse_at_a_smaller_step(fine, dt):
    try:
        times, moved = run(Staggered(), 20.0, dt)
    except mb.StepFailed:
        return  # thrown beyond zero length: failed, as predicted
    error = np.abs(moved - np.interp(times, *fine[20.0])).max() / np.abs(fine[20.0][1]).max()
    assert error > 10.0


@pytest.mark.parametrize("coupling", [Splitting(), Corrected()], ids=["splitting", "corrected"])
def test_recorded_tension_balances_the_solid(coupling):
    """The tension that is kept is that of the mechanics stage: passive force and active force carry the load."""
    model = Huxley()
    spring = soft_spring(model, 20.0)
    simulation = mb.Simulation(solid=spring, cross_bridges=model, integrator=QuasiStatic(), coupling=coupling, dt=5e-3)
    for _ in range(10):
        simulation.step()
        load = spring.external_force(simulation.motion.displacement, simulation.time)[0]
        carried = spring.stiffness * simulation.motion.displacement[0] + AREA * simulation.bus.tension[0]
        assert carried == pytest.approx(load, rel=1e-11)
    # It is not the tension of the population at the end of the step, which has reacted on or was redone meanwhile.
    after = simulation.bus.active_law_at_rest().evaluate(simulation.bus.stretch, np.zeros(1)).tension
    assert abs(after[0] - simulation.bus.tension[0]) > 1e-9 * model.p_max
