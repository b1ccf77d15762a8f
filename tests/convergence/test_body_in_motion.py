"""Order in time of the complete model: an incompressible body in smooth motion with heads that react at every point.

What `splitting` and `corrected` promise with each method: a step of `splitting` is symmetric in time, so that one-step
methods keep their order 2; methods that remember earlier steps remember the forces of other populations, which costs
them an order unless the population is redone along the path.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import myobridge as mb
from myobridge.coupling import Corrected, Splitting
from myobridge.interfaces import Array
from myobridge.solvers import Ordinary, accelerated
from myobridge.testing import fitted_order
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.fibres.constant import Constant as Straight
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.function import Function

TOLERANCE = 0.15
SOLVER = Ordinary(tolerance=1e-12)
END = 8e-3
INTEGRATORS = {item.name: item.cls for item in mb.registry() if item.family == "time_integrator"}
COUPLINGS = {"splitting": Splitting(), "corrected": Corrected()}
SLOW = pytest.mark.slow


def at_end(name: str, coupling: str, dt: float) -> tuple[Array, Array, Array]:
    """Displacement, velocity, and the pressure that the accelerations need, at the end.

    Nothing is sudden: the load begins with its third derivative, the muscle is switched on from nothing, and no head
    comes near the ends of its window.
    """
    solid = FiniteElement(
        mesh=Block(size=(0.04, 0.02), cells=(1, 1)),
        material=MooneyRivlin(),
        fibres=Straight(direction=(1.0, 0.3)),
        support=(Support(boundary="left"),),
        load=(
            Traction(
                boundary="right",
                traction=(8e3, -12e3),
                scale=Function(of_time=lambda time: math.sin(math.pi * time / 0.016) ** 4),
            ),
        ),
        bulk_modulus=math.inf,
    )
    simulation = mb.Simulation(
        solid=solid,
        integrator=INTEGRATORS[name](newton=SOLVER),
        cross_bridges=Huxley(bins=64, start="empty"),
        coupling=COUPLINGS[coupling],
        activation=Function(of_time=lambda time: math.sin(math.pi * time / 0.02) ** 2),
        dt=dt,
    )
    simulation.run(END)
    assert simulation.control.halvings == 0
    assert np.ptp(simulation.bus.stretch) * simulation.bus.model.gear > 1.0
    assert np.abs(simulation.bus.tension).max() > 5e3
    law = simulation.bus.active_law_at_rest()
    pressure = accelerated(solid, law, simulation.motion, simulation.time).multiplier
    return simulation.motion.displacement, simulation.motion.velocity, pressure


@functools.cache
def reference() -> tuple[Array, ...]:
    """Extrapolated, by the order 2 of which the method is also found to be."""
    coarse, fine = (at_end("energy_momentum", "splitting", dt) for dt in (5e-5, 2.5e-5))
    return tuple((4.0 * near - far) / 3.0 for far, near in zip(coarse, fine, strict=True))


CASES = [
    ("energy_momentum", "splitting", 2),
    ("bathe", "splitting", 2),
    ("bdf2", "splitting", 1),
    ("generalised_alpha", "splitting", 1),
    ("generalised_alpha", "corrected", 2),
    pytest.param("energy_momentum", "corrected", 2, marks=SLOW),
    pytest.param("bathe", "corrected", 2, marks=SLOW),
    pytest.param("bdf2", "corrected", 2, marks=SLOW),
    pytest.param("midpoint", "splitting", 2, marks=SLOW),
    pytest.param("midpoint", "corrected", 2, marks=SLOW),
    pytest.param("backward_euler", "splitting", 1, marks=SLOW),
    pytest.param("backward_euler", "corrected", 1, marks=SLOW),
]


@pytest.mark.parametrize(("name", "coupling", "order"), CASES)
def test_order_with_heads_at_every_point(name, coupling, order):
    """Displacement and pressure; the pressure of the step itself, which rings, has no order to speak of."""
    # These two see their order only at shorter steps.
    steps = np.array([4e-4, 2e-4, 1e-4]) * (0.5 if name in ("bdf2", "backward_euler") else 1.0)
    ends = [at_end(name, coupling, dt) for dt in steps]
    for what, quantity in ((0, "displacement"), (2, "pressure")):
        exact = reference()[what]
        errors = np.array([np.linalg.norm(end[what] - exact) / np.linalg.norm(exact) for end in ends])
        rate = fitted_order(steps, errors)
        print(f"{name}, {coupling}, {quantity}: observed order {rate:.2f}, expected {order}, errors {errors}")
        assert errors[0] < 0.2
        assert abs(rate - order) < TOLERANCE, f"{quantity}: observed {rate:.2f}, expected {order}"
