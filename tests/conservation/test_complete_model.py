"""The complete model: bodies with inertia, kept volume, fibres, reacting heads, loads and viscosity; all is booked.

Each store and each flow of the ledger is found on its own, so that what closes is the energy balance of the step:
discrete gradient, exact transport of the heads, exact integrals of attachment and detachment.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.solvers import Ordinary
from myobridge_plugins.cross_bridge.discrete import Discrete
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.cross_bridge.prescribed import Prescribed
from myobridge_plugins.fibres.constant import Constant as Straight
from myobridge_plugins.load.pressure import Pressure
from myobridge_plugins.load.robin import Robin
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.rope import Rope
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum

# What the step leaves, relative to the largest energy; the solver's own tolerance is 1e-12.
TOLERANCE = 1e-9
SOLVER = Ordinary(tolerance=1e-12)
FLAT, DEEP = (2, 1), (1, 1, 1)
STRICT = math.inf


def muscle(cells, bulk_modulus=STRICT, *, loaded=True, viscosity=10.0) -> FiniteElement:
    """Block of 40 x 20 (x 20) mm with slanting fibres, held on the left."""
    d = len(cells)
    loads = (
        Traction(boundary="right", traction=(2e3, -1e3, 5e2)[:d], scale=Sine(amplitude=1.0, frequency=30.0)),
        Pressure(boundary="top", pressure=1e3),
        Robin(boundary="right", normal=1e5, tangential=3e4),
    )
    return FiniteElement(
        mesh=Block(size=(0.04, 0.02, 0.02)[:d], cells=cells),
        material=MooneyRivlin(),
        fibres=Straight(direction=(1.0, 0.3, 0.1)[:d]),
        support=(Support(boundary="left"),),
        load=loads if loaded else (),
        bulk_modulus=bulk_modulus,
        viscosity=viscosity,
        gravity=9.81 if loaded else None,
    )


def line(kind) -> mb.MacroSolid:
    """Chain or rope in space, held on the left, with all effects that lines know."""
    size = {"springs": 5} if kind is Chain else {"elements": 3}
    return kind(
        length=0.3,
        modulus=2e5,
        mass=0.05,
        dimension="3",
        gravity=(0.0, 0.0, -9.81),
        viscosity=20.0,
        stretch_at_start=1.05,
        load=Sine(offset=2.0, amplitude=2.0, frequency=30.0),
        **size,
    )


def under_way(solid, model, dt=1e-3, integrator=None) -> mb.Simulation:
    """Muscle that is switched on while it moves."""
    return mb.Simulation(
        solid=solid,
        integrator=integrator or EnergyMomentum(newton=SOLVER),
        cross_bridges=model,
        activation=Ramp(initial=0.1, final=1.0, end=0.02),
        dt=dt,
    )


def largest_residual(simulation, steps) -> tuple[float, float]:
    """Largest relative residual of a step, and the largest kinetic energy [J]."""
    residuals, kinetic = [], []
    for _ in range(steps):
        simulation.step()
        residuals.append(abs(simulation.ledger.residual))
        kinetic.append(simulation.ledger.kinetic)
    print({name: f"{value:.3g}" for name, value in simulation.ledger.entries().items()})
    print(f"largest residual {max(residuals):.1e}, {simulation.iterations / simulation.steps:.1f} iterations a step")
    assert simulation.control.halvings == 0
    return max(residuals), max(kinetic)


# --- everything at once


@pytest.mark.parametrize("bulk_modulus", [STRICT, 1e9, 1e5], ids=lambda kappa: f"kappa={kappa:g}")
@pytest.mark.parametrize("cells", [FLAT, DEEP], ids=["2D", "3D"])
def test_the_ledger_of_a_muscle_closes(cells, bulk_modulus):
    """Inertia, constraint, heads that react, activation, gravity, viscosity, dead and following loads, bedding."""
    simulation = under_way(muscle(cells, bulk_modulus), Huxley(bins=16))
    residual, kinetic = largest_residual(simulation, 20)
    ledger = simulation.ledger
    assert residual <= TOLERANCE
    assert abs(ledger.drift) <= TOLERANCE
    # Everything took part, and the heads above all.
    assert min(ledger.attached, ledger.detached, ledger.elastic) > 0.1 * ledger.largest
    assert kinetic > 1e-2 * ledger.largest
    assert abs(ledger.external) > 1e-3 * ledger.largest
    assert ledger.viscous > 1e-2 * ledger.largest
    assert np.ptp(simulation.bus.stretch) * simulation.bus.model.gear > 1.0
    found = simulation.solid.balance(simulation.motion, None, simulation.time)
    assert np.linalg.norm(found.constraint) <= 1e-10 * found.constraint_magnitude


@pytest.mark.parametrize("kind", [Chain, Rope])
def test_the_ledger_of_a_line_closes(kind):
    simulation = under_way(line(kind), Huxley(bins=16))
    residual, kinetic = largest_residual(simulation, 40)
    ledger = simulation.ledger
    assert residual <= TOLERANCE
    assert abs(ledger.drift) <= TOLERANCE
    assert min(ledger.attached, ledger.detached, kinetic) > 1e-2 * ledger.largest
    assert min(abs(ledger.external), ledger.viscous) > 1e-3 * ledger.largest


MODELS = {
    "distributed_moment": DistributedMoment(),
    "discrete": Discrete(),
    "liouville": Liouville(),
    "huxley upwind": Huxley(discretisation="upwind", bins=16),
    "hill": Hill(force_velocity=True),
    "prescribed": Prescribed(),
}


@pytest.mark.parametrize("name", MODELS)
def test_the_ledger_closes_with_every_model(name):
    """Tension without stored energy is booked as work; what a grid invents is booked as numerical."""
    simulation = under_way(muscle(FLAT), MODELS[name])
    residual, _ = largest_residual(simulation, 20)
    ledger = simulation.ledger
    assert residual <= TOLERANCE
    assert abs(ledger.drift) <= TOLERANCE
    moved = abs(ledger.active_work) if not simulation.bus.model.has_energy else ledger.cross_bridge
    assert moved > 0.1 * ledger.largest
    if simulation.bus.model.promises.exact_slide:
        assert abs(ledger.numerical) <= TOLERANCE * ledger.largest


def test_a_stiff_pressure_costs_half_its_change_squared_over_the_modulus():
    """What the end-point pressure takes is what numerics says: no remainder is hidden in that entry."""
    simulation = under_way(muscle(FLAT, 1e8), Huxley(bins=16))
    solid, expected = simulation.solid, 0.0
    for _ in range(20):
        before = simulation.motion.multiplier
        simulation.step()
        change = simulation.motion.multiplier - before
        compliance = solid.balance(simulation.motion, None, simulation.time, tangent=True).constraint_compliance
        expected -= 0.5 * float(change @ (compliance @ change))
    assert expected < -1e-5 * simulation.ledger.largest
    # The first pressure is none, and the body is at rest: the relation holds from the very first step.
    assert simulation.ledger.numerical == pytest.approx(expected, rel=1e-6)


def test_a_support_that_moves_is_booked():
    """No load but the support: what it does is all that comes in."""
    solid = attrs.evolve(
        muscle(FLAT, loaded=False),
        support=(
            Support(boundary="left"),
            Support(boundary="right", displacement=(2e-3, 1e-3), scale=Sine(amplitude=1.0, frequency=15.0)),
        ),
    )
    simulation = under_way(solid, Huxley(bins=16))
    residual, _ = largest_residual(simulation, 30)
    assert residual <= TOLERANCE
    assert abs(simulation.ledger.external) > 1e-2 * simulation.ledger.largest


def test_a_method_that_does_not_conserve_leaves_its_error_in_the_residual():
    """The residual is found and not booked away: backward Euler's loss shows in it."""
    simulation = under_way(muscle(FLAT), Huxley(bins=16), integrator=BackwardEuler(newton=SOLVER))
    residual, _ = largest_residual(simulation, 20)
    assert residual > 1e-4
    assert simulation.ledger.drift < -1e-3


# --- heads that neither attach nor detach (thesis, Model 3.12)


def swinging(cells, bulk_modulus, steps):
    """Energies of a body whose attached heads pull it out of rest: nothing comes in, nothing goes out."""
    solid = muscle(cells, bulk_modulus, loaded=False, viscosity=None)
    simulation = mb.Simulation(
        solid=solid, integrator=EnergyMomentum(newton=SOLVER), cross_bridges=Liouville(), dt=1e-3
    )
    energies, kinetic = [simulation.ledger.total], []
    for _ in range(steps):
        simulation.step()
        energies.append(simulation.ledger.total)
        kinetic.append(simulation.ledger.kinetic)
    drift = np.abs(np.array(energies) / energies[0] - 1.0)
    moved = max(kinetic) / energies[0]
    print(f"{steps} steps: largest change of the energy {drift.max():.1e}, kinetic up to {moved:.2f}")
    assert simulation.control.halvings == 0
    assert moved > 1e-2
    # It swings and goes on swinging: energy goes into motion and back.
    assert np.sum(np.diff(np.sign(np.diff(kinetic))) != 0) > 0.02 * steps
    assert max(kinetic[-steps // 4 :]) > 0.2 * max(kinetic)
    return drift.max()


@pytest.mark.parametrize("bulk_modulus", [STRICT, 1e5], ids=lambda kappa: f"kappa={kappa:g}")
@pytest.mark.parametrize("cells", [FLAT, DEEP], ids=["2D", "3D"])
def test_energy_is_constant_without_attachment_and_detachment(cells, bulk_modulus):
    assert swinging(cells, bulk_modulus, 60) <= TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize("bulk_modulus", [STRICT, 1e5], ids=lambda kappa: f"kappa={kappa:g}")
@pytest.mark.parametrize("cells", [FLAT, DEEP], ids=["2D", "3D"])
def test_energy_is_constant_over_a_thousand_steps(cells, bulk_modulus):
    assert swinging(cells, bulk_modulus, 1000) <= TOLERANCE
