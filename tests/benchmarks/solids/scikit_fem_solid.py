"""The neo-Hookean P2-P1 cube of the comparisons, by forms of scikit-fem."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import skfem
from skfem.helpers import ddot, det, grad, identity, inv, mul, transpose


@skfem.LinearForm
def force(v, w):
    return ddot(w["stress"], grad(v))


@skfem.LinearForm
def constraint(q, w):
    return (w["volume"] - 1.0) * q


@skfem.BilinearForm
def stiffness(u, v, w):
    turned = mul(w["inverse"], mul(transpose(grad(u)), w["inverse"]))
    return ddot(grad(u) + w["turn"] * turned + w["level"] * ddot(w["inverse"], grad(u)) * w["inverse"], grad(v))


@skfem.BilinearForm
def gradient(u, q, w):
    return ddot(w["cofactor"], grad(u)) * q


class Solid:
    """Four forms on a vector basis of quadratic and a basis of linear tetrahedra.

    What does not depend on the test functions is worked out before, and not in the forms, which run for every pair.
    """

    name = f"scikit-fem {skfem.__version__}"

    def __init__(self, mesh: Any, degree: int) -> None:
        self._u = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP2()), intorder=degree)
        self._p = self._u.with_element(skfem.ElementTetP1())
        self.points = self._u.X.shape[1]

    def set(self, displacement: Callable[..., Any], pressure: Callable[..., Any]) -> None:
        self._fields = self._values(displacement), pressure(self._p.doflocs.T)

    def _values(self, displacement: Callable[..., Any]) -> np.ndarray:
        """Numbers of the vector basis; the places of its three components coincide."""
        values, places = np.empty(self._u.N), self._u.doflocs.T
        for table in (self._u.nodal_dofs, self._u.edge_dofs):
            for axis, numbers in enumerate(table):
                values[numbers] = displacement(places[numbers])[:, axis]
        return values

    def sums(self) -> Any:
        """Two vectors and two matrices."""
        slope, p = grad(self._u.interpolate(self._fields[0])), np.asarray(self._p.interpolate(self._fields[1]))
        F = slope + identity(slope)
        J, inverse = det(F), transpose(inv(F))
        at = {"stress": F - inverse + p * J * inverse, "volume": J, "cofactor": J * inverse}
        at |= {"inverse": inverse, "turn": 1.0 - p * J, "level": p * J}
        vectors = force.assemble(self._u, **at), constraint.assemble(self._p, **at)
        return *vectors, stiffness.assemble(self._u, **at), gradient.assemble(self._u, self._p, **at)

    def probe(self, w: Callable[..., Any], q: Callable[..., Any]) -> tuple[float, float]:
        f, c, K, B = self.sums()
        u, p = self._values(w), q(self._p.doflocs.T)
        return float(u @ f + p @ c), float(u @ (K @ u) + 2.0 * p @ (B @ u))
