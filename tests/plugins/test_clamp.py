"""The length clamp: a path that jumps, and heads with mass on a path that curves."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.coupling import Corrected, Splitting
from myobridge_plugins.cross_bridge.discrete import Discrete
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.macro_solid.clamp import Clamp
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.signal.steps import Steps
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic


def clamped(path: mb.Signal, model: mb.CrossBridgeModel, dt: float, **more) -> mb.Simulation:
    return mb.Simulation(solid=Clamp(path=path), cross_bridges=model, integrator=QuasiStatic(), dt=dt, **more)


@pytest.mark.parametrize("coupling", [Corrected(), Splitting()], ids=["corrected", "splitting"])
@pytest.mark.parametrize("dt", [2e-3, 5e-4, 1.3e-3])
def test_a_jump_acts_when_it_happens_and_at_once(dt, coupling):
    """1 % shortening at 6 ms: nothing before; then the tension of the slid population, whatever the step."""
    model = Huxley()
    path = Steps(times=(0.0, 0.006), values=(1.0, 0.99), interpolation="hold")
    simulation = clamped(path, model, dt, coupling=coupling)
    simulation.run(0.006)
    assert simulation.time == pytest.approx(0.006, rel=1e-12)
    assert simulation.bus.tension == pytest.approx(model.p_max, rel=1e-9)
    # One step beyond the jump, as long as it may be, against a run of many: a ramp over that step would differ.
    simulation.step()
    fine = clamped(path, model, 2e-5, coupling=coupling)
    fine.run(simulation.time)

    def tension(run: mb.Simulation) -> float:
        return float(run.bus.active_law_at_rest().evaluate(run.bus.stretch, np.zeros(1)).tension[0])

    assert tension(fine) < 0.5 * model.p_max
    assert tension(simulation) == pytest.approx(tension(fine), abs=5e-3 * model.p_max)
    assert abs(simulation.ledger.drift) <= 1e-12


@pytest.mark.parametrize("stop", [0.004, 0.00425])
def test_heads_with_mass_feel_the_acceleration_of_the_path(stop):
    """Inertance times the path's second derivative, from the first step on and at steps of any length."""
    model = Discrete(head_mass=1e-9)
    path = Sine(offset=1.0, amplitude=0.01, frequency=10.0, phase=np.pi / 2.0)
    simulation = clamped(path, model, 1e-3)
    simulation.stop_at([stop])

    def check(state: mb.Simulation, _report: mb.StepReport) -> None:
        law = state.bus.active_law_at_rest()
        massless = law.evaluate(state.bus.stretch, np.zeros(1)).tension
        curve = -0.01 * (20.0 * np.pi) ** 2 * np.cos(20.0 * np.pi * state.time)
        assert abs(law.inertance[0] * curve) > 1e-3 * model.p_max
        assert state.bus.tension - massless == pytest.approx(law.inertance * curve, rel=1e-3)

    simulation.run(0.01, check)


def test_hill_on_a_clamp_is_its_formula_at_the_time_of_the_row():
    """Activation, stretch and rate are those of the end of the step, not means over it."""
    model = Hill(force_velocity=True)
    path, activation = Sine(offset=1.0, amplitude=0.01, frequency=5.0), Sine(offset=0.5, amplitude=0.4, frequency=8.0)
    simulation = clamped(path, model, 2e-3, activation=activation)
    simulation.run(0.033)
    time = simulation.time
    law = model.active_law(np.empty((1, 0)), np.array([activation.value(time)]), np.array([path.value(time)]))
    tension = law.evaluate(np.array([path.value(time)]), np.array([path.rate(time)])).tension
    assert simulation.bus.tension == pytest.approx(model.p_max * tension, rel=1e-9)
