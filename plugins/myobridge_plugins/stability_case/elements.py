r"""Element pairs: the inf-sup constant must not vanish as the mesh is refined.

.. math:: B A^{-1} B^T q = \beta^2 M q

`A` is the stiffness at rest of a neo-Hookean body of modulus 1, `M` the mass matrix of the pressures at bulk modulus 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, final

import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, MacroSolid, StabilityCase
from myobridge.plan import Plan
from myobridge.scene import Scene


@final
class InfSup(StabilityCase):
    """Least inf-sup constant on three meshes."""

    summary = "the least inf-sup constant that is not 0 keeps its size on three meshes, each twice as fine"
    scene = """
[scene]
name = "inf_sup"
effects = ["incompressibility"]
[continuation]
plugin = "natural"
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [1.0, 1.0], cells = [3, 3], shape = "triangle" }
material = { plugin = "neo_hooke", shear_modulus = 1.0 }
bulk_modulus = 1.0
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [1.0, 0.0]
"""
    variants: ClassVar = {
        "triangle": {},
        "quadrilateral": {"solid.mesh.shape": "quadrilateral"},
    }
    limits = (Limit("ratio", at_least=0.7), Limit("spurious", 0))
    vary = ("solid.elements",)
    expected: ClassVar = {
        "triangle:P1-P0": Expectation("fails", "the pair has no inf-sup constant: it halves with the cells"),
    }
    bisect = False

    def measured(self, scene: Scene) -> Mapping[str, float]:
        constants, spurious = [], 0
        for cells in (3, 6, 12):
            solid = Plan.of(scene.with_settings({"solid.mesh.cells": [cells, cells]})).parts["solid"]
            found = _inf_sup(solid)
            spurious += int(np.sum(found == 0.0))
            constants.append(float(found[found > 0.0].min()))
        return {
            "ratio": min(constants[1] / constants[0], constants[2] / constants[1]),
            "constant": constants[-1],
            "spurious": float(spurious),
        }


def _inf_sup(solid: MacroSolid) -> np.ndarray:
    """All values of beta; 0 is a spurious pressure."""
    import scipy.linalg
    import scipy.sparse.linalg as sparse_linalg

    rest = solid.balance(solid.rest_motion(), None, 0.0, rate=False, tangent=True)
    assert rest.stiffness is not None
    assert rest.constraint_gradient is not None
    assert rest.constraint_compliance is not None
    gradient = rest.constraint_gradient.toarray()
    schur = gradient @ sparse_linalg.splu(rest.stiffness.tocsc()).solve(gradient.T)
    found = scipy.linalg.eigh(schur, rest.constraint_compliance.toarray(), eigvals_only=True)
    return np.sqrt(np.where(found > 1e-12, found, 0.0))


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {"inf_sup": InfSup}
