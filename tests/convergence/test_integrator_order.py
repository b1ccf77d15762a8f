"""Every registered integrator has the order that it declares: one test for all, the fitted rate printed."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.cross_bridge.hill import Hill
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.rope import Rope
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.sine import Sine

INTEGRATORS = {item.name: item.cls for item in mb.registry() if item.family == "time_integrator"}
TOLERANCE = 0.15


def nonlinear_chain() -> mb.MacroSolid:
    """Three springs that swing in space, driven: geometry makes it nonlinear."""
    velocity = (0.0, 0.4, 0.1, 0.2, 0.0, -0.3, 0.1, 0.2, 0.1)
    return Chain(
        springs=3,
        length=0.3,
        modulus=2e4,
        mass=0.3,
        dimension="3",
        stretch_at_start=1.2,
        velocity=velocity,
        load=Sine(offset=0.5, amplitude=0.2, frequency=3.0),
    )


def rope_with_heads() -> mb.MacroSolid:
    """A rope with a consistent mass and heads that stay attached."""
    return Rope(elements=1, length=0.3, modulus=2e4, mass=0.3, stretch_at_start=1.1)


def damped_spring() -> mb.MacroSolid:
    """A spring that a force pulls and Hill's rate-dependent muscle holds: an equation of the first order in time."""
    return Spring(stiffness=2e3, length=0.1, area=1e-4, load=Sine(offset=7.3, amplitude=3.0, frequency=4.0))


def block_that_keeps_its_volume() -> mb.MacroSolid:
    """Two squares of soft tissue, clamped, thrown sideways: a constraint of degree two and its multipliers."""
    return FiniteElement(
        mesh=Block(size=(0.1, 0.05), cells=(2, 1)),
        material=NeoHooke(shear_modulus=200.0),
        bulk_modulus=np.inf,
        support=(Support(boundary="left"),),
        velocity_at_start=(0.3, 0.6),
    )


SOLIDS = {
    "chain": nonlinear_chain,
    "rope": rope_with_heads,
    "damped": damped_spring,
    "block": block_that_keeps_its_volume,
}
MODELS = {"rope": Liouville(p_max=2e3), "damped": Hill(force_velocity=True)}
# Steps of a case as multiples of those below, and that of its reference [s].
LONGER = {"rope": 0.25, "block": 2.0}
REFERENCE = {"block": 5e-5}


def final_state(integrator: mb.TimeIntegrator, case: str, dt: float) -> np.ndarray:
    simulation = mb.Simulation(
        solid=SOLIDS[case](),
        cross_bridges=MODELS.get(case),
        integrator=integrator,
        dt=dt,
        start="as_given" if case == "damped" else "projected",
    )
    simulation.run(0.05)
    motion = simulation.motion
    return motion.displacement if case == "damped" else np.concatenate([motion.displacement, 1e-2 * motion.velocity])


@functools.cache
def fine_state(case: str) -> np.ndarray:
    """Reference: the midpoint rule where there is inertia, so that no other method is judged by itself."""
    return final_state(
        INTEGRATORS["quasi_static" if case == "damped" else "midpoint"](), case, REFERENCE.get(case, 1e-5)
    )


# Each integrator is held to its order where its equation is: with inertia, or quasi-statically.
CASES = [
    (name, case)
    for name, cls in sorted(INTEGRATORS.items())
    for case in (("chain", "rope", "block") if cls.inertia else ("damped",))
    if case != "block" or cls.constraints
]


@pytest.mark.parametrize(("name", "case"), CASES)
def test_declared_order(name, case):
    integrator = INTEGRATORS[name]()
    steps = (
        np.array([2e-3, 1e-3, 5e-4, 2.5e-4])
        * LONGER.get(case, 1.0)
        * (0.25 if integrator.explicit and case != "rope" else 1.0)
    )
    reference = fine_state(case)
    errors = np.array([np.linalg.norm(final_state(integrator, case, dt) - reference) for dt in steps])
    rate = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    print(f"{name} on {case}: observed order {rate:.2f}, declared {integrator.order}, errors {errors}")
    assert errors[0] < 0.5 * np.linalg.norm(reference)
    assert abs(rate - integrator.order) < TOLERANCE, f"observed {rate:.2f}, declared {integrator.order}"
