"""The pressure that is recorded belongs to the instant: closer to that of a fine run, and it does not ring."""

from __future__ import annotations

import functools

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.field_recording import FieldRecorder
from myobridge.reported_motion import reported_motion
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.steps import Steps
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic
from myobridge_plugins.time_integrator.rattle import Rattle

RELEASE = Steps(times=(-1.0, 0.0), values=(1.0, 0.0), interpolation="hold")
DURATION = 0.012


def body(bulk_modulus=np.inf, **options):
    material = MooneyRivlin(**MooneyRivlin.parameter_sets["thesis"])
    return FiniteElement(
        mesh=Block(size=(0.1, 0.025), cells=(6, 2)),
        material=material,
        bulk_modulus=bulk_modulus,
        support=(Support(boundary="left"),),
        **options,
    )


@functools.cache
def stretched(bulk_modulus):
    """Body under a load that is gone at t = 0, and its equilibrium before."""
    solid = body(
        bulk_modulus, load=(Traction(boundary="right", traction=(1.12e5, 0.0), scale=RELEASE),), viscosity=10.0
    )
    return solid, mb.Simulation(solid=solid, integrator=EnergyMomentum(), start="equilibrium").motion


@functools.cache
def release(multiplier, bulk_modulus=np.inf, dt=1e-3):
    """Multipliers each millisecond of a 30 % release: the integrator's own, and those reported [Pa]."""
    solid, start = stretched(bulk_modulus)
    simulation = mb.Simulation(solid=solid, integrator=EnergyMomentum(multiplier=multiplier), dt=dt, start=None)
    simulation.motion = start
    own, reported = [], []
    while not simulation.finished(DURATION):
        simulation.step(DURATION)
        if round(simulation.time / dt) % round(1e-3 / dt) == 0:
            own.append(simulation.motion.multiplier)
            reported.append(reported_motion(simulation).multiplier)
    return np.array(own), np.array(reported)


def difference(pressure, other):
    return float(np.sqrt(np.mean((pressure - other) ** 2)))


@pytest.mark.parametrize("bulk_modulus", [np.inf, 1e9])
def test_in_a_release_the_reported_pressure_is_closer_to_that_of_a_fine_run(bulk_modulus) -> None:
    fine = release("endpoint", dt=2.5e-4)
    assert difference(*fine) < 0.1 * fine[1].std()  # the two agree as the step goes to zero
    own, reported = release("endpoint", bulk_modulus)
    errors = difference(own, fine[1]), difference(reported, fine[1])
    print(f"error of the integrator's pressure {errors[0]:.0f} Pa, of the reported one {errors[1]:.0f} Pa")
    assert errors[1] < 0.85 * errors[0]


def test_it_does_not_ring_where_the_mean_of_the_pressure_acts() -> None:
    fine = release("endpoint", dt=2.5e-4)[1]
    own, reported = release("averaged")
    errors = difference(own, fine), difference(reported, fine)
    print(f"error of the integrator's pressure {errors[0]:.0f} Pa, of the reported one {errors[1]:.0f} Pa")
    assert errors[1] < 0.5 * errors[0]
    np.testing.assert_allclose(reported, release("endpoint")[1], rtol=0.0, atol=1e-5 * np.abs(reported).max())


def test_it_is_what_the_field_holds_and_only_when_it_is_recorded(monkeypatch) -> None:
    import myobridge.field_recording as module

    solid = body()
    rest = solid.rest_motion()
    simulation = mb.Simulation(solid=solid, integrator=Rattle(limit="ignore"), dt=5e-5)
    motion = attrs.evolve(rest, multiplier=np.full(rest.multiplier.size, 3e3))
    simulation.motion = motion
    recorder = FieldRecorder(("pressure",), 1, simulation)
    recorder.observe(simulation)
    # At rest, without load, there is no pressure, whatever an integrator may carry.
    assert np.abs(recorder.snapshots[0]["pressure"]).max() < 1e-6
    assert np.abs(solid.visible_fields(motion, 0.0)["pressure"]).min() > 2.9e3
    monkeypatch.setattr(module, "reported_motion", None)
    FieldRecorder(("stretch",), 1, simulation).observe(simulation)
    with pytest.raises(TypeError):
        FieldRecorder(None, 1, simulation).observe(simulation)


def test_without_inertia_or_with_a_soft_constraint_it_is_as_it_is() -> None:
    for solid, integrator in ((body(), QuasiStatic()), (body(1e5), EnergyMomentum())):
        simulation = mb.Simulation(solid=solid, integrator=integrator)
        assert reported_motion(simulation) is simulation.motion
