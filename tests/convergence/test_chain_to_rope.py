"""The chain of springs converges to the rope as the number of springs grows (thesis, Examples 1.32 to 1.34)."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.macro_solid.chain import Chain
from myobridge_plugins.macro_solid.rope import Rope
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.midpoint import Midpoint

COMMON = {
    "length": 1.0,
    "area": 1e-4,
    "modulus": 1e5,
    "mass": 0.05,
    "load": Sine(offset=0.0, amplitude=1.0, frequency=4.0),
}


def tip(solid: mb.MacroSolid, end: float = 0.1) -> float:
    simulation = mb.Simulation(solid=solid, integrator=Midpoint(), dt=2e-4)
    simulation.run(end)
    return float(simulation.motion.displacement[-1])


def exact_tip(end: float, modes: int = 4000) -> float:
    """Tip of a fixed-free elastic bar under F sin(w t) at its end, by its modes; the 1D rope is linear."""
    length, stiffness, density = COMMON["length"], COMMON["modulus"] * COMMON["area"], COMMON["mass"] / COMMON["length"]
    omega = 2.0 * np.pi * COMMON["load"].frequency
    own = (np.arange(modes) + 0.5) * np.pi / length * np.sqrt(stiffness / density)
    response = (np.sin(omega * end) - omega / own * np.sin(own * end)) / (own**2 - omega**2)
    return float(np.sum(2.0 / (density * length) * response) * COMMON["load"].amplitude)


def test_chain_converges_to_the_rope_at_order_two():
    reference = tip(Rope(elements=160, **COMMON))
    springs = np.array([10, 20, 40, 80])
    errors = np.array([abs(tip(Chain(springs=int(n), **COMMON)) - reference) for n in springs])
    rate = -np.polyfit(np.log(springs), np.log(errors), 1)[0]
    print(f"observed order {rate:.2f}, errors {errors}, tip {reference:.6f}")
    assert abs(reference) > 1e-2
    assert abs(rate - 2.0) < 0.15


def test_rope_is_the_elastic_bar():
    """Against the series solution of the wave equation, to the error of the time step."""
    assert tip(Rope(elements=80, **COMMON)) == pytest.approx(exact_tip(0.1), rel=2e-3)


def test_statics_of_the_hanging_rope():
    """A rope under its own weight: stretch 1 + m g (1 - X/L) / (E A), exactly linear in one dimension."""
    from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

    weight = 9.81 * COMMON["mass"]
    for solid in (Rope(elements=4, gravity=9.81, **{**COMMON, "load": None}),):
        simulation = mb.Simulation(solid=solid, integrator=QuasiStatic(), dt=1e-2)
        simulation.step()
        stretch = solid.stretch(simulation.motion.displacement, 0.0)
        expected = 1.0 + weight * (1.0 - solid.site_positions()[:, 0]) / (COMMON["modulus"] * COMMON["area"])
        assert stretch == pytest.approx(expected, rel=1e-12)
        assert np.ptp(stretch) > 1e-3
        force = solid.reactions(simulation.motion, np.zeros(solid.n_sites), 0.0)["left"]
        # The support carries the weight but for the share of the first node, which rests on it directly.
        assert -force[0] == pytest.approx(weight, rel=0.05)
