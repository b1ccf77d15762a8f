"""A Python function as a signal drives a clamp like any other."""

from __future__ import annotations

import math

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.macro_solid.clamp import Clamp
from myobridge_plugins.signal.function import Function
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic


def final_tension(path: mb.Signal) -> float:
    simulation = mb.Simulation(solid=Clamp(path=path), cross_bridges=Huxley(), integrator=QuasiStatic(), dt=1e-3)
    simulation.run(0.1)
    assert np.ptp([simulation.bus.tension[0], 73e3]) > 1e3
    return float(simulation.bus.tension[0])


def test_a_function_is_the_signal_it_computes():
    function = Function(lambda t: 1.0 + 0.01 * math.sin(2.0 * math.pi * 7.0 * t))
    sine = Sine(offset=1.0, amplitude=0.01, frequency=7.0)
    assert final_tension(function) == pytest.approx(final_tension(sine), rel=1e-12)
    assert function.mean(0.01, 0.013) == pytest.approx(sine.mean(0.01, 0.013), rel=1e-13)


def test_mean_is_exact_between_kinks():
    wedge = Function(lambda t: abs(t - 0.3), kinks=(0.3,))
    assert wedge.mean(0.0, 1.0) == pytest.approx((0.3**2 + 0.7**2) / 2.0, rel=1e-14)
    assert wedge.jumps() == (0.3,)
