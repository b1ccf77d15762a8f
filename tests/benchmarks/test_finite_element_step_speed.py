"""What the discrete gradient of a step costs beside the balance at a point: ratios in one run, one thread."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from myobridge.interfaces import AffineLaw, Motion
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block

pytestmark = pytest.mark.benchmark


def seconds(call) -> float:
    """Best of several runs, compiled before."""
    call()
    found = []
    for _ in range(7):
        start = process_time()
        call()
        found.append(process_time() - start)
    return min(found)


@pytest.mark.parametrize("tangent", [False, True], ids=["residual", "tangent"])
def test_a_step_costs_little_more_than_a_point(tangent):
    mesh = Block(size=(1.0, 1.0, 1.0), cells=(12, 12, 12), shape="tetrahedron")
    solid = FiniteElement(
        mesh=mesh, material=MooneyRivlin(), bulk_modulus=np.inf, support=(Support(boundary="left"),), threads=1
    )
    rest, generator = solid.rest_motion(), np.random.default_rng(0)
    u, du = 5e-3 * generator.uniform(-1.0, 1.0, (2, solid.n_unknowns))
    start, end = (Motion(place, 0.0 * u, rest.multiplier) for place in (u, u + 0.2 * du))
    law = AffineLaw(*np.array([[1.0], [1e4], [1e5]]) * np.ones(solid.n_sites))
    point = seconds(lambda: solid.balance(start, law, 0.0, tangent=tangent))
    step = seconds(lambda: solid.step_balance(start, end, law, (0.0, 1e-3), tangent=tangent))
    cells = solid._body.grid.n_cells
    print(f"\n{cells} tetrahedra, us each: point {1e6 * point / cells:.2f}, step {1e6 * step / cells:.2f}")
    assert step < (5.0 if tangent else 3.5) * point
