"""Order of the coupling schemes with Huxley's population on the spring (with and without inertia)."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.coupling import Corrected, Monolithic, Splitting
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.midpoint import Midpoint
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

MODEL = Huxley(bins=512, low=-2.0, high=4.0)
LENGTH, AREA = 0.1, 1e-4
ACTIVE = MODEL.gear * MODEL.p_max * 2.0 * AREA / LENGTH  # isometric stiffness: Q0 / Q1 = 2
RATIO = 5.0


def trajectory(coupling: mb.CouplingScheme, dt: float, *, inertia: bool, end: float = 0.1) -> np.ndarray:
    """Displacement in reaches at every 10 ms; a load of 5 Hz swings about the isometric one."""
    stiffness = ACTIVE / RATIO
    load = Sine(offset=MODEL.p_max * AREA, amplitude=0.5 * stiffness * LENGTH / MODEL.gear, frequency=5.0, phase=0.0)
    mass = (stiffness + ACTIVE) / (2.0 * np.pi * 20.0) ** 2
    simulation = mb.Simulation(
        solid=Spring(mass=mass, stiffness=stiffness, length=LENGTH, area=AREA, load=load),
        cross_bridges=MODEL,
        integrator=Midpoint() if inertia else QuasiStatic(),
        coupling=coupling,
        dt=dt,
    )
    marks = np.arange(1, 11) * end / 10
    positions = []
    for mark in marks:
        simulation.run(mark)
        positions.append(simulation.motion.displacement[0] * MODEL.gear / LENGTH)
    return np.array(positions)


@pytest.mark.parametrize(
    ("coupling", "inertia", "least"),
    [
        (Splitting(), True, 1.85),
        (Splitting(), False, 0.95),
        (Corrected(), False, 1.85),
        (Monolithic(), False, 1.85),
        (Corrected(), True, 1.85),
    ],
    ids=["splitting-inertia", "splitting-static", "corrected-static", "monolithic-static", "corrected-inertia"],
)
def test_order_of_the_coupling(coupling, inertia, least):
    steps = np.array([4e-3, 2e-3, 1e-3, 5e-4]) / (2.0 if inertia else 1.0) * 1.25
    reference = trajectory(Monolithic() if not inertia else coupling, steps[-1] / 8, inertia=inertia)
    errors = np.array([np.abs(trajectory(coupling, dt, inertia=inertia) - reference).max() for dt in steps])
    rate = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    print(f"{type(coupling).__name__}, inertia {inertia}: observed order {rate:.2f}, errors {errors}")
    assert np.abs(reference).max() > 0.05
    assert rate >= least


@pytest.mark.parametrize(
    "coupling", [Splitting(), Corrected(), Monolithic()], ids=["splitting", "corrected", "monolithic"]
)
def test_order_with_an_activation_that_changes(coupling):
    """A tension that follows the activation alone: the law has to see the activation of the integrator's stage."""

    def final(dt: float) -> np.ndarray:
        simulation = mb.Simulation(
            solid=Spring(mass=0.05, stiffness=3e3, length=LENGTH, area=AREA),
            cross_bridges=Prescribed(),
            integrator=Midpoint(),
            coupling=coupling,
            activation=Sine(offset=0.5, amplitude=0.4, frequency=9.0, phase=0.3),
            dt=dt,
        )
        simulation.run(0.05)
        return np.array([simulation.motion.displacement[0], 1e-3 * simulation.motion.velocity[0]])

    steps = np.array([1e-3, 5e-4, 2.5e-4, 1.25e-4])
    reference = final(1e-5)
    errors = np.array([np.linalg.norm(final(dt) - reference) for dt in steps])
    rate = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    print(f"{type(coupling).__name__}, activation that changes: observed order {rate:.2f}, errors {errors}")
    assert rate >= 1.85


@pytest.mark.parametrize(
    "coupling", [Splitting(), Corrected(), Monolithic()], ids=["splitting", "corrected", "monolithic"]
)
def test_statics_see_the_activation_of_the_moment(coupling):
    """Without inertia the equilibrium at t has the activation at t: no lag at all."""
    activation = Sine(offset=0.5, amplitude=0.4, frequency=9.0)
    simulation = mb.Simulation(
        solid=Spring(stiffness=3e3, length=LENGTH, area=AREA),
        cross_bridges=Prescribed(),
        integrator=QuasiStatic(),
        coupling=coupling,
        activation=activation,
        dt=5e-3,
    )
    simulation.run(0.045)
    expected = -73e3 * AREA * float(activation.value(simulation.time)) / 3e3
    assert simulation.motion.displacement[0] == pytest.approx(expected, rel=1e-9)
