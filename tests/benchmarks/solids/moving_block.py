"""Incompressible P2-P1 blocks that move and contract: CPU seconds a step with kept factors, and with new ones.

``python moving_block.py CASE CELLS STEPS EVERY LINEAR [KEPT]`` prints one line of JSON. CASE: D0 (free release from a
static stretch of 24 %, passive), DA7 (contraction from rest, cross-bridges to 1e7 Pa), S0 and S7 (ramps of tension and
of a force across without inertia, without and with stiff cross-bridges). CELLS such as 14x8x8. All steps are taken with
kept factors; one out of EVERY is also solved with new ones in every iteration, from the same state, and what both find
is compared. LINEAR is a table of TOML with the linear solver, KEPT that of the kept factors.
"""

from __future__ import annotations

import json
import math
import sys
import tomllib
from time import process_time
from typing import Any

import numpy as np

import myobridge as mb
from myobridge.build import build
from myobridge.interfaces import AffineLaw, Array, Motion, NewtonMethod, NewtonProblem, NewtonResult
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.signal.ramp import Ramp

STEP, RAMP = 1e-3, 20  # length [s] of a step, and steps of the ramps
TOLERANCE = 1e-8
ALONG, ACROSS = 8e4, 5e3  # tractions [Pa] on the free end
TENSION, RISE = 7.3e4, 0.015  # of active tissue [Pa], and the time that it takes to rise [s]
STIFFNESS = {"D0": 0.0, "DA7": 1e7, "S0": 0.0, "S7": 1e7}


class Counted(NewtonMethod):
    """A method, and what all its solves took together."""

    def __init__(self, method: NewtonMethod) -> None:
        self.method, self.found = method, []

    def solve(self, problem: NewtonProblem, start: Array, kept: Any = None) -> NewtonResult:
        found = self.method.solve(problem, start, kept)
        self.found.append(found)
        return found

    def told(self) -> dict[str, Any]:
        steps = [[step.factorised for step in found.history] for found in self.found]
        return {
            "factorisations": sum(sum(step) for step in steps),
            "iterations": [len(step) for step in steps],
            "renewed": [k for k, step in enumerate(steps) if any(step)],
        }


def block(cells: tuple[int, ...], *loads: Traction) -> FiniteElement:
    return FiniteElement(
        mesh=Block(size=(0.1, 0.05, 0.05), cells=cells, shape="tetrahedron"),
        material=MooneyRivlin(),
        support=(Support(boundary="left"),),
        load=loads,
        bulk_modulus=math.inf,
        threads=1,
    )


def pulled(*traction: float, end: float) -> Traction:
    return Traction(boundary="right", traction=traction, scale=Ramp(initial=0.0, final=1.0, start=0.0, end=end))


def stretched(cells: tuple[int, ...]) -> Motion:
    """Equilibrium under the tractions, in four steps."""
    solid = block(cells, pulled(ALONG, 0.0, ACROSS, end=1.0))
    newton = mb.registry().find("newton", "simplified").cls(tolerance=1e-10)
    integrator = mb.registry().find("time_integrator", "quasi_static").cls(newton=newton)
    motion, memory = solid.rest_motion(), {}
    for k in range(4):
        motion, memory, report = integrator.step(solid, None, motion, memory, 0.25 * k, 0.25)
        assert report.converged, report.reason
    return Motion(motion.displacement, np.zeros_like(motion.velocity), motion.multiplier)


def law(case: str, solid: FiniteElement, motion: Motion, time: float, share: float) -> AffineLaw | None:
    """Tension [Pa] that has risen to a share, stiff about the stretch at the beginning of the step."""
    if case == "D0":
        return None
    stretch = solid.stretch(motion.displacement, time)
    return AffineLaw(stretch, np.full_like(stretch, share * TENSION), np.full_like(stretch, share * STIFFNESS[case]))


def main(case: str, cells: str, steps: int, every: int, linear: str, kept_linear: str = "") -> None:
    counts = tuple(int(count) for count in cells.split("x"))
    static = case.startswith("S")
    solid = block(counts, *([pulled(0.0, 0.0, ACROSS, end=RAMP * STEP)] if static else []))
    motion: Motion = stretched(counts) if case == "D0" else solid.rest_motion()
    methods = {
        "kept": Counted(method("simplified", kept_linear or linear)),
        "ordinary": Counted(method("ordinary", linear)),
    }
    cls = mb.registry().find("time_integrator", "quasi_static" if static else "energy_momentum").cls
    integrators = {name: cls(newton=one) for name, one in methods.items()}
    # Kernels are compiled and libraries found before the clock starts.
    warm = block((2, 1, 1))
    for name, integrator in integrators.items():
        integrator.step(warm, law(case, warm, warm.rest_motion(), 0.0, 0.1), warm.rest_motion(), {}, 0.0, STEP)
        methods[name].found.clear()
    memory: Any = {}
    seconds: dict[str, list[float]] = {name: [] for name in methods}
    off = 0.0
    for k in range(steps):
        time = k * STEP
        rising = 0.5 * (1.0 - math.cos(math.pi * min((time + 0.5 * STEP) / RISE, 1.0)))
        tension = law(case, solid, motion, time, (k + 1) / RAMP if static else rising)
        begin = process_time()
        found = integrators["kept"].step(solid, tension, motion, memory, time, STEP)
        assert found.report.converged, found.report.reason
        seconds["kept"].append(process_time() - begin)
        if k % every == every // 2:
            begin = process_time()
            other = integrators["ordinary"].step(solid, tension, motion, {}, time, STEP)
            assert other.report.converged, other.report.reason
            seconds["ordinary"].append(process_time() - begin)
            change = other.motion.displacement - motion.displacement
            missed = found.motion.displacement - other.motion.displacement
            off = max(off, float(np.abs(missed).max() / np.abs(change).max()))
        motion, memory = found.motion, found.memory
    told = {
        name: {
            "seconds": float(np.mean(seconds[name] or [0.0])),
            "each": np.round(seconds[name], 3).tolist(),
            **one.told(),
        }
        for name, one in methods.items()
    }
    n = solid.n_unknowns + motion.multiplier.size
    print(json.dumps({"unknowns": n, "off": off, "moved": float(np.abs(motion.displacement).max()), **told}))


def method(name: str, linear: str) -> NewtonMethod:
    return build(mb.registry(), "newton", {"plugin": name, "tolerance": TOLERANCE, "linear": tomllib.loads(linear)})


if __name__ == "__main__":
    main(*sys.argv[1:3], int(sys.argv[3]), int(sys.argv[4]), *sys.argv[5:])
