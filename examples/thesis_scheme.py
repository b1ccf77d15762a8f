"""The thesis' scheme against this project's default on the same plane muscle: computing time at equal error.

``python examples/thesis_scheme.py [--cells 32x8] [--duration 0.1] [--bulk-modulus 1e6] [--bins 8]``

Both integrate the complete model of a block that is held at the left and activated, quasi-incompressible so that the
thesis' scheme survives: half-explicit Euler in symplectic order, upwind population, staggered coupling, at its limit
of stability, which is found first. The default (energy-momentum, exact population, splitting) takes the largest step
with which displacement and tension at the end are as close to a fine reference or closer.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Mapping, Sequence
from time import process_time
from typing import Any, NamedTuple

import numpy as np

import myobridge as mb
from myobridge.solvers import largest_frequency
from myobridge.work import counted

SCENE = """
[scene]
name = "thesis_scheme"
effects = ["inertia", "cross_bridges", "incompressibility"]
duration = 0.1
step = 1e-3

[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025], cells = [32, 8] }
material = { plugin = "mooney_rivlin", parameters = "thesis" }
bulk_modulus = 1e6 # Pa
threads = 1

[[support]]
boundary = "left"

[cross_bridges]
plugin = "huxley"
start = "empty"
"""
THESIS = {
    "integrator.plugin": "half_explicit",
    "integrator.sequence": "symplectic",
    "coupling.plugin": "staggered",
    "cross_bridges.discretisation": "upwind",
    # A window of four reaches: 32 cells at 8 a reach. The thesis had 20.
    "cross_bridges.low": -2.0,
    "cross_bridges.high": 2.0,
}
DEFAULT = {
    "integrator.plugin": "energy_momentum",
    "integrator.newton.plugin": "simplified",
    "integrator.newton.tolerance": 1e-8,
}
FINE = {"integrator.newton.tolerance": 1e-10, "cross_bridges.bins": 64}
# Numbers of steps that the default tries.
STEPS = (4, 5, 6, 8, 10, 12, 14, 16, 20, 25, 32, 40, 50, 64, 80, 100, 128, 160, 200)
# Energy that comes from nowhere, relative to the largest of the reference: beyond it a run is lost.
LOST = 1e-4


class Ran(NamedTuple):
    """One run: CPU time [s] of its steps, and how it ended."""

    simulation: mb.Simulation
    cpu: float
    survived: bool
    counts: Mapping[str, int]

    @property
    def displacement(self) -> np.ndarray:
        return self.simulation.motion.displacement

    @property
    def tension(self) -> np.ndarray:
        """Of the population at the end [Pa]."""
        bus = self.simulation.bus
        assert bus is not None
        return bus.active_law_at_rest().evaluate(bus.stretch, np.zeros(bus.n_sites)).tension


def run(scene: mb.Scene, settings: Mapping[str, Any], *, allowed: float | None = None) -> Ran:
    """Steps to the end, without recording; a run is given up that fails or gains more than the `allowed` energy [J]."""
    simulation = mb.Plan.of(scene.with_settings(settings)).simulation()
    end, survived = scene.duration, True
    with counted() as counts:
        started = process_time()
        if allowed is None:
            simulation.run(end)
        while allowed is not None and survived and not simulation.finished(end):
            simulation.step()
            ledger = simulation.ledger
            survived = simulation.control.halvings == 0 and abs(ledger.drift) * ledger.largest < allowed
        cpu = process_time() - started
    return Ran(simulation, cpu, survived, dict(counts))


def errors(found: Ran, reference: Ran) -> tuple[float, float]:
    """Relative errors of the displacement and of the tension at the end."""

    def relative(one: np.ndarray, other: np.ndarray) -> float:
        return float(np.linalg.norm(one - other) / np.linalg.norm(other))

    return relative(found.displacement, reference.displacement), relative(found.tension, reference.tension)


def reference_of(scene: mb.Scene) -> tuple[Ran, tuple[float, float]]:
    """A fine run, and how far one with twice its step lies from it."""
    count = round(scene.duration / 2.5e-4)
    coarse, fine = (
        run(scene, DEFAULT | FINE | {"scene.step": scene.duration / steps}) for steps in (count // 2, count)
    )
    return fine, errors(coarse, fine)


def predicted_limit(reference: Ran) -> float:
    """2 / omega_max at the end of the reference, the stiffness of its population included [s]."""
    simulation, bus = reference.simulation, reference.simulation.bus
    assert bus is not None
    found = largest_frequency(simulation.solid, bus.active_law_at_rest(), simulation.motion, simulation.time)
    return 2.0 / found.omega


def thesis_run(scene: mb.Scene, bins: int, limit: float, energy: float) -> tuple[Ran, float]:
    """The thesis' scheme with the largest step that survives, out of a ladder from the predicted limit down.

    Beyond the limit a run may end before it has gained much, but it rings, and comparing with that would be no merit.
    `energy` is the largest of the reference [J].

    Returns
    -------
    tuple
        The run, and its step [s].
    """
    settings = THESIS | {"cross_bridges.bins": bins}
    run(scene.with_settings({"scene.duration": 1e-5}), settings | {"scene.step": 1e-6})  # compiles
    for share in (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5):
        dt = share * limit
        # Steps of one length: the last one ends within half a step of the duration.
        steps = round(scene.duration / dt)
        found = run(scene, settings | {"scene.step": scene.duration / steps}, allowed=LOST * energy)
        say(
            f"  step {1e6 * scene.duration / steps:.2f} us: "
            + ("survives" if found.survived else f"lost at {1e3 * found.simulation.time:.1f} ms")
        )
        if found.survived:
            return found, scene.duration / steps
    raise SystemExit("the thesis' scheme survives at none of the steps that were tried; lower --bulk-modulus")


def default_run(scene: mb.Scene, reference: Ran, allowed: tuple[float, float]) -> tuple[Ran, int]:
    """The default with the largest step whose errors, and those of the next finer one, are at most `allowed`."""
    tried: list[tuple[Ran, int, bool]] = []
    for steps in STEPS:
        found = run(scene, DEFAULT | {"scene.step": scene.duration / steps})
        here = errors(found, reference)
        good = here[0] <= allowed[0] and here[1] <= allowed[1]
        say(f"  {steps} steps of {1e3 * scene.duration / steps:.3g} ms: {100 * here[0]:.2f} %, {100 * here[1]:.2f} %")
        if good and tried and tried[-1][2]:
            return tried[-1][0], tried[-1][1]
        tried.append((found, steps, good))
    raise SystemExit("no step of the default reaches the error of the thesis' scheme")


def say(text: str) -> None:
    print(text, flush=True)


def profile(ran: Ran) -> str:
    """Share of each phase, and what was counted in a step."""
    seconds, steps = ran.simulation.seconds, ran.simulation.steps
    whole = sum(seconds.values())
    shares = ", ".join(f"{name.replace('_', ' ')} {100 * value / whole:.0f} %" for name, value in seconds.items())
    done = ran.counts
    return (
        f"{1e3 * ran.cpu / steps:.1f} ms a step ({shares}); {done['newton_iterations'] / steps:.1f} iterations, "
        f"{done['factorisations']} factorisations in all"
    )


def compare(cells: Sequence[int], duration: float, bulk_modulus: float, bins: int) -> float:
    """Print the comparison; return the ratio of CPU times."""
    scene = mb.Scene.from_toml(SCENE).with_settings(
        {"solid.mesh.cells": list(cells), "scene.duration": duration, "solid.bulk_modulus": bulk_modulus}
    )
    say(f"{cells[0]} x {cells[1]} x 2 triangles, {1e3 * duration:g} ms, kappa = {bulk_modulus:g} Pa")
    run(scene.with_settings({"scene.duration": 2e-3}), DEFAULT)  # compiles
    reference, uncertain = reference_of(scene)
    say(
        f"reference: {reference.simulation.steps} steps, 64 bins a reach; half of them differ by "
        f"{100 * uncertain[0]:.2f} % (displacement), {100 * uncertain[1]:.2f} % (tension)"
    )
    limit = predicted_limit(reference)
    say(f"thesis' scheme, {4 * bins} cells a point; predicted limit {1e6 * limit:.2f} us")
    thesis, dt = thesis_run(scene, bins, limit, reference.simulation.ledger.largest)
    there = errors(thesis, reference)
    say(f"default, to at most {100 * there[0]:.2f} % (displacement) and {100 * there[1]:.2f} % (tension)")
    default, steps = default_run(scene, reference, there)
    again = [run(scene, DEFAULT | {"scene.step": duration / steps}).cpu for _ in range(3)]
    cpu, here = statistics.median(again), errors(default, reference)
    ratio = thesis.cpu / cpu
    for name, ran, seconds, step, wrong in (
        ("thesis", thesis, thesis.cpu, dt, there),
        ("default", default, cpu, duration / steps, here),
    ):
        say(
            f"{name:8s} step {step:.3g} s, {ran.simulation.steps} steps, CPU {seconds:.3g} s, "
            f"errors {100 * wrong[0]:.2f} % and {100 * wrong[1]:.2f} %\n         {profile(ran)}"
        )
    say(f"CPU ratio {ratio:.0f}")
    return ratio


def main(arguments: Sequence[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--cells", default="32x8", help="cells along and across, such as 64x16")
    parser.add_argument("--duration", type=float, default=0.1, help="simulated time [s]")
    parser.add_argument("--bulk-modulus", type=float, default=1e6, help="[Pa]")
    parser.add_argument("--bins", type=int, default=8, help="cells a reach of the thesis' scheme, four reaches wide")
    given = parser.parse_args(arguments)
    along, across = (int(part) for part in given.cells.split("x"))
    compare((along, across), given.duration, given.bulk_modulus, given.bins)


if __name__ == "__main__":
    main(sys.argv[1:])
