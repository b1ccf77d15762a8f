"""The neo-Hookean P2-P1 cube of the comparisons, by forms of scikit-fem."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import skfem
from skfem.helpers import ddot, det, grad, identity, inv, mul, transpose


def _state(w: Any) -> tuple[Any, Any, Any]:
    F = grad(w["displacement"]) + identity(grad(w["displacement"]))
    return F, det(F), transpose(inv(F))


@skfem.LinearForm
def force(v, w):
    F, J, inverse = _state(w)
    return ddot(F - inverse + w["pressure"] * J * inverse, grad(v))


@skfem.LinearForm
def constraint(q, w):
    return (det(grad(w["displacement"]) + identity(grad(w["displacement"]))) - 1.0) * q


@skfem.BilinearForm
def stiffness(u, v, w):
    _, J, inverse = _state(w)
    p = w["pressure"]
    turned = mul(inverse, mul(transpose(grad(u)), inverse))
    return ddot(grad(u) + turned + p * J * (ddot(inverse, grad(u)) * inverse - turned), grad(v))


@skfem.BilinearForm
def gradient(u, q, w):
    _, J, inverse = _state(w)
    return J * ddot(inverse, grad(u)) * q


class Solid:
    """Four forms on a vector basis of quadratic and a basis of linear tetrahedra."""

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
        at = {"displacement": self._u.interpolate(self._fields[0]), "pressure": self._p.interpolate(self._fields[1])}
        vectors = force.assemble(self._u, **at), constraint.assemble(self._p, **at)
        return *vectors, stiffness.assemble(self._u, **at), gradient.assemble(self._u, self._p, **at)

    def probe(self, w: Callable[..., Any], q: Callable[..., Any]) -> tuple[float, float]:
        f, c, K, B = self.sums()
        u, p = self._values(w), q(self._p.doflocs.T)
        return float(u @ f + p @ c), float(u @ (K @ u) + 2.0 * p @ (B @ u))
