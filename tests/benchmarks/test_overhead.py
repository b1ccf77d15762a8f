"""What the framework costs beyond its kernels: ratios in one run, printed; run with ``pytest -m benchmark -n 0 -s``."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
from time import perf_counter, process_time

import numpy as np
import pytest

import myobridge as mb
from myobridge.recording import Record
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.macro_solid.clamp import Clamp
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.midpoint import Midpoint
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

pytestmark = pytest.mark.benchmark

SITES = 5000
STEPS = 40
DT = 1e-3
MODEL = Huxley(low=-3.0, high=5.0)
CLAMP = Clamp(path=Sine(offset=1.0, amplitude=0.01, frequency=5.0), sites=SITES)


def by_hand() -> float:
    """The same kernels in a loop, nothing else; CPU seconds."""
    state, spare = MODEL.initial_state(SITES), MODEL.initial_state(SITES)
    activation = np.ones(SITES)
    stretch = CLAMP.stretch(np.empty(0), 0.0)
    started = process_time()
    for step in range(STEPS):
        following = CLAMP.stretch(np.empty(0), (step + 1) * DT)
        new, _ = MODEL.advance(state, activation, stretch, following, DT, spare)
        state, spare, stretch = new, state, following
    return process_time() - started


def by_simulation() -> float:
    simulation = mb.Simulation(solid=CLAMP, cross_bridges=MODEL, integrator=QuasiStatic(), dt=DT)
    run = mb.Run(simulation, Record(every=STEPS))
    started = process_time()
    run.to(STEPS * DT)
    return process_time() - started


def test_a_scene_of_5000_sites_against_the_same_kernels_by_hand():
    """Wanted: at most 1.05."""
    by_hand(), by_simulation()
    ratios = []
    for _ in range(9):
        hand = by_hand()
        ratios.append(by_simulation() / hand)
    ratio = statistics.median(ratios)
    print(f"\n{SITES} sites: simulation / by hand = {ratio:.3f} ({min(ratios):.3f} to {max(ratios):.3f})")
    assert ratio <= 1.05


def test_one_site_step():
    """Spring, Huxley, splitting, midpoint: wanted at most 200 us a step (printed, not asserted: a timing)."""
    spring = Spring(mass=0.01, stiffness=100.0, displacement=0.001)
    simulation = mb.Simulation(solid=spring, cross_bridges=Huxley(low=-3.0, high=5.0), integrator=Midpoint(), dt=DT)
    simulation.run(50 * DT)
    fastest = np.inf
    for _ in range(20):
        before, started = simulation.steps, perf_counter()
        simulation.run(simulation.time + 200 * DT)
        fastest = min(fastest, (perf_counter() - started) / (simulation.steps - before))
    print(f"\none-site step: {1e6 * fastest:.0f} us")


def test_import_time():
    """Wanted: below 1.0 s CPU (printed, not asserted: a timing)."""
    code = "import time; t = time.process_time(); import myobridge; print(time.process_time() - t)"
    seconds = [float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(5)]
    print(f"\nimport myobridge: {statistics.median(seconds):.2f} s CPU ({min(seconds):.2f} to {max(seconds):.2f})")


def test_second_run_does_not_compile(tmp_path):
    """A fresh process finds its kernels on disk: numba's own count of cache misses is zero."""
    code = """
import myobridge as mb
from numba.core import event
compiled = []
class Listener(event.Listener):
    def on_start(self, e): compiled.append(e.data.get("dispatcher"))
    def on_end(self, e): pass
with event.install_listener("numba:compile", Listener()):
    mb.run(mb.Scene(duration=0.01, step=1e-3, effects=["cross_bridges"], solid={"plugin": "clamp",
        "path": {"plugin": "ramp", "slope": 0.1, "initial": 1.0}}, cross_bridges={"plugin": "huxley"}))
print(len(compiled))
"""
    empty = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    runs = [int(subprocess.check_output([sys.executable, "-c", code], cwd=tmp_path, env=empty)) for _ in range(2)]
    print(f"\nkernels compiled in the first and the second process: {runs}")
    assert runs[0] > 0
    assert runs[1] == 0
