"""Matrices of the free numbers are those of all numbers with rows and columns left out, entry by entry."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge_plugins.macro_solid.finite_element.assembly import Assembly
from myobridge_plugins.macro_solid.finite_element.discretisation import discretise
from myobridge_plugins.macro_solid.finite_element.element_pairs import reference_cell
from myobridge_plugins.macro_solid.finite_element.pattern import pattern
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block

CASES = [
    ("triangle", "P2-P1"),
    ("quadrilateral", "Q2-P1disc"),
    ("tetrahedron", "P2-P1"),
    ("tetrahedron", "P2"),
    ("hexahedron", "Q2-P1disc"),
]


@pytest.mark.parametrize(("shape", "pair"), CASES)
def test_numbers_held_anywhere(shape: str, pair: str) -> None:
    flat = shape in ("triangle", "quadrilateral")
    mesh = Block(size=(0.1, 0.02, 0.02)[: 2 if flat else 3], cells=(4, 3, 2)[: 2 if flat else 3], shape=shape).mesh()
    grid = discretise(mesh, reference_cell(mesh, pair, 2), [np.arange(mesh.nelements)])
    generator = np.random.default_rng(0)
    n, m = grid.dimension * grid.n_nodes, grid.n_multipliers
    fibre = np.zeros((3, grid.n_points))
    fibre[0] = 1.0
    state = 1e-4 * generator.standard_normal(n), generator.standard_normal(m)
    law = generator.random(grid.n_points), generator.random(grid.n_points)

    def matrices(free: np.ndarray, free_multipliers: np.ndarray):
        found = pattern(grid, free, free_multipliers)
        sums = Assembly(grid, found, [MooneyRivlin()], fibre, 1).sums(*state, *law, tangent=True)
        return found.stiffness.matrix(sums.stiffness), found.gradient.matrix(sums.gradient), sums.force

    # Single components of a fifth of all nodes, and a node of which nothing is free.
    free = np.setdiff1d(np.flatnonzero(generator.random(n) < 0.9), np.arange(grid.dimension))
    kept = np.flatnonzero(generator.random(m) < 0.8)
    whole, part = matrices(np.arange(n), np.arange(m)), matrices(free, kept)
    assert np.max(np.abs(part[2] - whole[2])) == 0.0
    for found, expected in ((part[0], whole[0][free][:, free]), (part[1], whole[1][kept][:, free])):
        assert found.has_canonical_format
        assert found.nnz == expected.nnz
        assert np.array_equal(found.data, expected.data)
        assert np.array_equal(found.indices, expected.indices)
    # The sums run over blocks a <= b and their transposes: symmetric to the last bit but for what the order changes.
    assert abs(whole[0] - whole[0].T).max() <= 1e-15 * abs(whole[0]).max()
