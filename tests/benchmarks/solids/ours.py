"""The neo-Hookean P2-P1 cube of the comparisons, by this project."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from myobridge_plugins.macro_solid.finite_element.assembly import Assembly
from myobridge_plugins.macro_solid.finite_element.discretisation import discretise
from myobridge_plugins.macro_solid.finite_element.element_pairs import reference_cell
from myobridge_plugins.macro_solid.finite_element.pattern import pattern
from myobridge_plugins.material.neo_hooke import NeoHooke


class Solid:
    """Residual and tangent of all nodes: nothing is held. Fibres are there, and pull with nothing.

    Parameters
    ----------
    mesh : skfem.MeshTet
    degree : int
        5 has 14 points, 2 has 4.
    threads : int
    """

    name = "myobridge"

    def __init__(self, mesh: Any, degree: int, threads: int = 1) -> None:
        cell = reference_cell(mesh, "P2-P1", degree)
        self.grid = discretise(mesh, cell, [np.arange(mesh.nelements)])
        d = self.grid.dimension
        found = pattern(self.grid, np.arange(d * self.grid.n_nodes), np.arange(self.grid.n_multipliers))
        fibre = np.zeros((3, self.grid.n_points))
        fibre[0] = 1.0
        self.assembly = Assembly(self.grid, found, [NeoHooke(shear_modulus=1.0)], fibre, threads)
        self.places = self.grid.positions
        vertices = np.empty((self.grid.n_multipliers, d))
        vertices[self.grid.multipliers] = mesh.p[:, mesh.t[:, self.grid.order]].transpose(2, 1, 0)
        self.vertices = vertices
        self.points = cell.weights.size

    def set(self, displacement: Callable[..., Any], pressure: Callable[..., Any]) -> None:
        """Fields as functions of the positions (n, 3): they give (n, 3) and (n,)."""
        self._u, self._p = displacement(self.places).ravel(), pressure(self.vertices)

    def sums(self) -> Any:
        """Vectors and matrices as a Newton iteration takes them: force, constraint, K and B as CSR arrays."""
        sums = self.assembly.sums(self._u, self._p, None, None, tangent=True)
        parts = self.assembly.pattern
        return sums.force, sums.constraint, parts.stiffness.matrix(sums.stiffness), parts.gradient.matrix(sums.gradient)

    def kernel(self) -> None:
        """The same without the last copy into CSR arrays."""
        self.assembly.sums(self._u, self._p, None, None, tangent=True)

    def probe(self, w: Callable[..., Any], q: Callable[..., Any]) -> tuple[float, float]:
        """Residual and tangent of one test function (w, q): two numbers that do not depend on any numbering."""
        force, constraint, K, B = self.sums()
        u, p = w(self.places).ravel(), q(self.vertices)
        return float(u @ force + p @ constraint), float(u @ (K @ u) + 2.0 * p @ (B @ u))
