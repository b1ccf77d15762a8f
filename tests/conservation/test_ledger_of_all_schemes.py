"""Tension without stored energy is booked as work, under every coupling scheme."""

from __future__ import annotations

import pytest

import myobridge as mb
from myobridge.coupling import Corrected, Monolithic, Splitting, Staggered
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.midpoint import Midpoint


@pytest.mark.parametrize(
    "coupling", [Splitting(), Corrected(), Staggered(), Monolithic()], ids=lambda c: type(c).__name__
)
@pytest.mark.parametrize("model", [Prescribed(), Hill(force_velocity=True)], ids=["prescribed", "hill"])
def test_active_work_closes_the_ledger(coupling, model):
    spring = Spring(mass=1.0, stiffness=3e3, velocity=0.1)
    simulation = mb.Simulation(
        solid=spring,
        cross_bridges=model,
        integrator=Midpoint(),
        coupling=coupling,
        activation=Sine(offset=0.5, amplitude=0.5, frequency=20.0),
        dt=1e-3,
    )
    simulation.run(0.1)
    ledger = simulation.ledger
    assert ledger.cross_bridge == 0.0
    assert abs(ledger.active_work) > 1e-2 * ledger.largest
    assert abs(ledger.drift) <= 1e-11
