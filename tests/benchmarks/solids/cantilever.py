"""A neo-Hookean P2-P1 block held at one end, at a bent state: one whole Newton iteration by this project.

``python cantilever.py CELLS SOLVER`` prints one line of JSON for a block of ``2 CELLS x CELLS x CELLS`` cubes:
unknowns, CPU seconds of assembly and of the linear solve, iterations, and the largest resident memory in bytes.
"""

from __future__ import annotations

import json
import resource
import sys
from time import process_time
from typing import Any

import numpy as np

import myobridge as mb
from myobridge.interfaces import Array, LinearSystem, Motion
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block

TOLERANCE = 1e-8


def bent(x: Array) -> Array:
    """Displacement of nodes at `x` (n, 3): none at the held end."""
    return 0.02 * x[:, :1] * np.sin(x[:, [1, 2, 0]] * 2.0 + x)


class Cantilever:
    """Newton's first iteration from the bent state, with everything that it takes.

    Parameters
    ----------
    cells : sequence of int
        Cubes of six tetrahedra along each axis; 2 m long, 1 m wide and high.
    solver : str
        Registered name of a linear solver.
    """

    def __init__(self, cells: tuple[int, int, int], solver: str) -> None:
        self.solid = FiniteElement(
            mesh=Block(size=(2.0, 1.0, 1.0), cells=cells, shape="tetrahedron"),
            material=NeoHooke(shear_modulus=1.0),
            support=(Support(boundary="left"),),
            bulk_modulus=np.inf,
            threads=1,
        )
        body = self.solid._body
        self.places = body.grid.positions
        self.free = body.free
        rest = self.solid.rest_motion()
        self.motion = Motion(bent(self.places).ravel()[self.free], rest.velocity, rest.multiplier)
        self.solver = mb.registry().find("linear_solver", solver).cls()
        self.n_unknowns = self.free.size + rest.multiplier.size
        self.seconds = {"assembly": np.inf, "solve": np.inf}

    def iterate(self) -> Array:
        """Residual, tangent, solve, and the residual at the new point; the correction of all nodes (n, 3)."""
        started = process_time()
        balance = self.solid.balance(self.motion, None, 0.0, tangent=True)
        assembled = process_time()
        scale, n = self.solid.multiplier_scale, self.free.size
        gradient: Any = scale * balance.constraint_gradient
        system = LinearSystem(balance.stiffness, gradient, gradient, None, self.solid.rigid_motions())
        factors = self.solver.factorise(system)
        found = factors.solve(-np.concatenate([balance.force, scale * balance.constraint]), TOLERANCE)
        solved = process_time()
        correction = np.zeros(self.places.size)
        correction[self.free] = found[:n]
        motion = Motion(
            self.motion.displacement + found[:n], self.motion.velocity, self.motion.multiplier + scale * found[n:]
        )
        assert self.solid.admissible(motion.displacement)
        self.solid.balance(motion, None, 0.0)
        self.iterations = factors.iterations
        spent = {"assembly": assembled - started + process_time() - solved, "solve": solved - assembled}
        self.seconds = {name: min(spent[name], self.seconds[name]) for name in spent}
        return correction.reshape(-1, 3)


def main(cells: int, solver: str) -> None:
    block = Cantilever((2 * cells, cells, cells), solver)
    for _ in range(2):
        block.iterate()
    found = {
        "unknowns": block.n_unknowns,
        **block.seconds,
        "iterations": block.iterations,
        "memory": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
