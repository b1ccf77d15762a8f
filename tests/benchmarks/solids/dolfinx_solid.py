"""The neo-Hookean P2-P1 cube of the comparisons, by DOLFINx: a script for the Python that has it.

``python3 dolfinx_solid.py CELLS DEGREE`` says its version and number of cells; then it answers every line that it reads
with the CPU seconds of one residual + tangent.
"""

from __future__ import annotations

import sys
from time import process_time

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI


def main(cells: int, degree: int) -> None:
    box = [np.zeros(3), np.array([2.0, 1.0, 1.0])]
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, box, [2 * cells, cells, cells], dolfinx.mesh.CellType.tetrahedron)
    pair = ufl.MixedElement(
        ufl.VectorElement("Lagrange", mesh.ufl_cell(), 2), ufl.FiniteElement("Lagrange", mesh.ufl_cell(), 1)
    )
    space = fem.FunctionSpace(mesh, pair)
    state = fem.Function(space)
    generator = np.random.default_rng(0)
    state.x.array[:] = 1e-3 * generator.standard_normal(state.x.array.size)
    u, p = ufl.split(state)
    F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
    J = ufl.det(F)
    energy = (0.5 * (ufl.inner(F, F) - 3.0) - ufl.ln(J) + p * (J - 1.0)) * ufl.dx(
        metadata={"quadrature_degree": degree}
    )
    # More than its default -O2, which takes a third longer.
    options = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"]}
    residual = fem.form(ufl.derivative(energy, state), jit_params=options)
    tangent = fem.form(ufl.derivative(ufl.derivative(energy, state), state), jit_params=options)
    matrix, vector = fem.petsc.create_matrix(tangent), fem.petsc.create_vector(residual)

    def sums() -> None:
        with vector.localForm() as local:
            local.set(0.0)
        fem.petsc.assemble_vector(vector, residual)
        matrix.zeroEntries()
        fem.petsc.assemble_matrix(matrix, tangent)
        matrix.assemble()

    sums()
    print(dolfinx.__version__, mesh.topology.index_map(3).size_local, flush=True)
    for _ in sys.stdin:
        started = process_time()
        sums()
        print(process_time() - started, flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
