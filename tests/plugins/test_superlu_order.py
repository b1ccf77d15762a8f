"""SuperLU's elimination order: a pressure that lives in each cell alone must not spoil it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from myobridge.equilibria import Equilibria
from myobridge.solvers import bordered
from myobridge_plugins.linear_solver.superlu import SuperLU
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block


def tangent(shape, n, bulk_modulus=np.inf):
    d = 2 if shape in ("triangle", "quadrilateral") else 3
    solid = FiniteElement(
        mesh=Block(size=(1.0,) * d, cells=(n,) * d, shape=shape),
        material=NeoHooke(),
        support=(Support(boundary="left"),),
        bulk_modulus=bulk_modulus,
    )
    problem = Equilibria(solid, None, of="load")
    return problem.system(problem.start, 1.0)


def entries(factors):
    """Entries of the factors by entry of the matrix."""
    found = re.search(r"([\d.]+) million entries", factors.describe())
    assert found
    return 1e6 * float(found[1])


@pytest.mark.parametrize("bulk_modulus", [np.inf, 1e6])
@pytest.mark.parametrize(
    ("shape", "n", "fill"), [("quadrilateral", 16, 6.5), ("hexahedron", 3, 4.0), ("triangle", 16, 7.0)]
)
def test_factors_stay_small_and_true(shape, n, fill, bulk_modulus):
    """Minimum degree on the whole Q2-P1disc matrix fills in 36 entries for one (16 x 16), and 9 (hexahedra)."""
    system = tangent(shape, n, bulk_modulus)
    factors = SuperLU().factorise(system)
    ratio = entries(factors) / system.matrix().nnz
    print(f"{shape}: {ratio:.2f} entries of the factors for one of the matrix")
    assert ratio < fill
    right = np.random.default_rng(0).standard_normal(system.n_unknowns)
    found = factors.solve(right)
    assert np.linalg.norm(system.times(found) - right) < 1e-11 * np.linalg.norm(right)


def test_a_border_does_not_change_the_order():
    """The dense row of arclength continuation is eliminated last."""
    system = tangent("quadrilateral", 8)
    generator = np.random.default_rng(0)
    column, row = generator.standard_normal((2, system.n_unknowns))
    with_border = bordered(system, column, row, 1.0)
    factors = SuperLU().factorise(with_border)
    assert entries(factors) < 1.3 * entries(SuperLU().factorise(system))
    right = generator.standard_normal(system.n_unknowns + 1)
    found = factors.solve(right)
    assert np.linalg.norm(with_border.times(found) - right) < 1e-10 * np.linalg.norm(right)
