"""Incompressible P2-P1 blocks that move and contract: CPU seconds a step with one of Newton's methods.

``python moving_block.py CASE CELLS STEPS INTEGRATOR METHOD [FILE]`` prints one line of JSON. CASE: D0 (free release
from a static stretch of 24 %, passive), DA7 (contraction from rest, cross-bridges to 1e7 Pa), S0 and S7 (ramps of
tension and of a force across without inertia, without and with stiff cross-bridges). CELLS such as 14x8x8, METHOD a
table of TOML; FILE takes the displacement at the end.
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

STEP = 1e-3
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

    def told(self, steps: int) -> dict[str, Any]:
        history = [step for found in self.found for step in found.history]
        return {
            "factorisations": sum(step.factorised for step in history),
            "iterations": len(history) / steps,
            "each": [len(found.history) for found in self.found],
            "renewed": [k for k, found in enumerate(self.found) if any(step.factorised for step in found.history)],
            "linear": sum(step.linear_iterations for step in history) / steps,
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


def main(case: str, cells: str, steps: int, name: str, method: str, file: str = "") -> None:
    counts = tuple(int(count) for count in cells.split("x"))
    static = case.startswith("S")
    end = steps * STEP
    solid = block(counts, *([pulled(0.0, 0.0, ACROSS, end=end)] if static else []))
    motion: Motion = stretched(counts) if case == "D0" else solid.rest_motion()
    newton = Counted(build(mb.registry(), "newton", tomllib.loads(method)))
    integrator = mb.registry().find("time_integrator", "quasi_static" if static else name).cls(newton=newton)
    memory, times = integrator.initial_memory(solid, motion), []
    # Kernels are compiled and libraries found before the clock starts.
    warm = block((2, 1, 1))
    integrator.step(warm, law(case, warm, warm.rest_motion(), 0.0, 0.1), warm.rest_motion(), {}, 0.0, STEP)
    newton.found.clear()
    for k in range(steps):
        time, begin = k * STEP, process_time()
        share = (k + 1) / steps if static else 0.5 * (1.0 - math.cos(math.pi * min((time + 0.5 * STEP) / RISE, 1.0)))
        motion, memory, report = integrator.step(
            solid, law(case, solid, motion, time, share), motion, memory, time, STEP
        )
        assert report.converged, report.reason
        times.append(process_time() - begin)
    if file:
        np.save(file, motion.displacement)
    found = {
        "unknowns": solid.n_unknowns + motion.multiplier.size,
        "seconds": float(np.mean(times)),
        "largest": float(max(times)),
        "moved": float(np.abs(motion.displacement).max()),
        **newton.told(steps),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), *sys.argv[4:])
