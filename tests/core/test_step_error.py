"""Steps controlled by their estimated error: the estimate is that of the true one, and runs resume bit-identically."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.run import Run, resume, start
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.midpoint import Midpoint

OMEGA = 20.0
SPRING = Spring(mass=1.0, stiffness=OMEGA**2, displacement=0.01)


def test_the_estimate_is_the_error_of_a_step():
    """Of the midpoint rule, -dt^3 u'''/12 in one step, of backward Euler -dt^2 u''/2: known for a spring."""
    for integrator, derivative in (
        (Midpoint(), lambda t: OMEGA**3 * np.sin(OMEGA * t) / 12.0),
        (BackwardEuler(), lambda t: OMEGA**2 * np.cos(OMEGA * t) / 2.0),
    ):
        dt = 1e-3
        simulation = mb.Simulation(solid=SPRING, integrator=integrator, dt=dt, tolerance=1.0)
        found, expected = [], []
        for _ in range(100):
            simulation.step()
            assert simulation.step_error is not None
            found.append(simulation.step_error.estimate)
            expected.append(abs(0.01 * derivative(simulation.time - 0.5 * dt)) * dt ** (integrator.order + 1))
        largest = max(expected)
        np.testing.assert_allclose(found[2:], expected[2:], atol=0.05 * largest)
        assert largest > 1e-9


def run(tolerance, dt=0.05):
    solid = attrs.evolve(SPRING, load=Sine(amplitude=1.0, frequency=5.0))
    simulation = mb.Simulation(solid=solid, integrator=Midpoint(), dt=dt, tolerance=tolerance)
    simulation.run(1.0)
    return simulation


def test_a_tenth_of_the_tolerance_gives_a_smaller_error_for_more_steps():
    reference = run(None, dt=1e-4).motion.displacement[0]
    errors, steps = [], []
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7):
        found = run(tolerance)
        errors.append(abs(found.motion.displacement[0] - reference))
        steps.append(found.steps)
    print("errors", errors, "steps", steps)
    assert np.all(np.diff(steps) > 0)
    # Order 2: the error of a step goes with the cube of its length, that of the end with the square.
    rate = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert -2.6 < rate < -1.4, f"observed {rate:.2f}"


def test_the_step_grows_back_where_nothing_happens():
    solid = Spring(mass=1.0, stiffness=OMEGA**2, viscosity=3e4, displacement=0.01)
    simulation = mb.Simulation(solid=solid, integrator=Midpoint(), dt=0.02, tolerance=1e-5)
    lengths = []
    while simulation.time < 3.0:
        simulation.step()
        assert simulation.step_error is not None
        lengths.append(simulation.step_error.dt)
    assert min(lengths) < 0.02
    assert lengths[-1] == pytest.approx(0.02)


SCENE = """
[scene]
effects = ["inertia"]
duration = 0.5
step = 0.02
tolerance = 1e-6
[solid]
plugin = "spring"
stiffness = 400.0
load = { plugin = "sine", amplitude = 1.0, frequency = 5.0 }
"""


def test_the_estimate_is_written_and_a_resumed_run_is_the_same(tmp_path):
    scene = mb.Scene.from_toml(SCENE)
    whole = Run(mb.Plan.of(scene).simulation(), scene.record).to(0.5)
    assert np.all(whole["step_error"] <= 1e-6)
    assert whole["step_error"].max() > 1e-8
    assert len(set(np.round(whole["step_length"][1:], 9))) > 1
    first = start(mb.Plan.of(scene), output=tmp_path / "part.h5")
    assert isinstance(first, Run)
    part = first.to(0.5, until=0.2)
    assert part["time"][-1] < 0.5
    continued, _ = resume(tmp_path / "part.h5")
    assert isinstance(continued, Run)
    resumed = continued.to(0.5)
    for name in whole.series:
        np.testing.assert_array_equal(resumed[name], whole[name], err_msg=name)


def test_a_tolerance_that_makes_no_sense_is_refused():
    with pytest.raises(mb.SceneError, match="tolerance"):
        mb.Simulation(solid=Spring(), integrator=Midpoint(), tolerance=-1.0)
    with pytest.raises(mb.SceneError, match="tolerance"):
        mb.Scene.from_toml(SCENE.replace("tolerance = 1e-6", "tolerance = 0.0"))
