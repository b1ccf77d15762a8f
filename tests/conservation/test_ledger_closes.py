"""The energy ledger closes: nothing is created or lost that is not booked."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.cross_bridge.discrete import Discrete
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.time_integrator.midpoint import Midpoint
from myobridge_plugins.time_integrator.stoermer_verlet import StoermerVerlet

STEPS = 1000


def oscillator(model: mb.CrossBridgeModel, integrator: mb.TimeIntegrator) -> mb.Simulation:
    """A spring of some 12 Hz, pulled 2 reaches out and let go; heads attach and detach meanwhile."""
    spring = Spring(mass=20.0, stiffness=2e4, length=0.1, area=1e-4, displacement=-4e-4, velocity=0.05)
    return mb.Simulation(solid=spring, cross_bridges=model, integrator=integrator, dt=5e-4)


@pytest.mark.parametrize(
    "model", [Huxley(), DistributedMoment(), Liouville(), Discrete()], ids=lambda model: type(model).__name__
)
def test_spring_with_splitting_and_midpoint_closes_to_round_off(model):
    simulation = oscillator(model, Midpoint())
    start = simulation.ledger.entries()
    stretch_before = simulation.bus.stretch.copy()
    residuals, stretches = [], []
    for _ in range(STEPS):
        simulation.step()
        residuals.append(abs(simulation.ledger.residual))
        stretches.append(simulation.bus.stretch[0])
    end = simulation.ledger
    print(f"largest residual {max(residuals):.1e}, drift {end.drift:.1e}")
    assert max(residuals) <= 1e-12
    assert abs(end.drift) <= 1e-12
    # Something moved: the spring swung over more than a reach, and heads came and went.
    assert np.ptp([stretch_before[0], *stretches]) * simulation.bus.model.gear > 0.5
    assert end.kinetic != start["kinetic"]
    if isinstance(model, Huxley | DistributedMoment):
        assert end.attached > 0.1 * end.largest
        assert end.detached > 0.1 * end.largest


def test_an_integrator_that_does_not_conserve_leaves_a_residual():
    """The residual is found, not booked away: Störmer-Verlet's energy error shows in it."""
    simulation = oscillator(Huxley(), StoermerVerlet())
    simulation.run(0.05)
    assert abs(simulation.ledger.drift) > 1e-6


def test_external_work_is_booked():
    from myobridge_plugins.signal.constant import Constant

    spring = Spring(mass=1.0, stiffness=100.0, load=Constant(level=2.0))
    simulation = mb.Simulation(solid=spring, integrator=Midpoint(), dt=1e-2)
    simulation.run(1.0)
    moved = float(simulation.motion.displacement[0])
    assert moved > 1e-3
    assert simulation.ledger.external == pytest.approx(2.0 * moved, rel=1e-12)
    assert abs(simulation.ledger.drift) <= 1e-12


def test_a_clamp_supplies_the_work_that_sliding_takes():
    from myobridge_plugins.macro_solid.clamp import Clamp
    from myobridge_plugins.signal.sine import Sine
    from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

    clamp = Clamp(path=Sine(offset=1.0, amplitude=0.02, frequency=5.0))
    simulation = mb.Simulation(solid=clamp, cross_bridges=Huxley(), integrator=QuasiStatic(), dt=1e-3)
    simulation.run(0.2)
    ledger = simulation.ledger
    assert abs(ledger.external) > 0.1 * ledger.largest
    assert abs(ledger.drift) <= 1e-12
