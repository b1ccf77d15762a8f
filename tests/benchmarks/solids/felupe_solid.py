"""The neo-Hookean P2-P1 cube of the comparisons, by FElupe."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import felupe
import numpy as np
from felupe.math import cdya_il, det, dya, inv, transpose


class MixedMaterial(felupe.ConstitutiveMaterial):
    """W(F) + p (J - 1) for fields of displacement and pressure, in the style of `felupe.NearlyIncompressible`.

    That one has a third field for the volume; with two fields FElupe has less to do, and the equations are ours.
    """

    def __init__(self, material: Any) -> None:
        self.material, self.parallel = material, False
        self.x = [material.x[0], np.ones(1), material.x[-1]]

    def _gradient(self, x: Any) -> Any:
        (F, p), state = x[:2], x[-1]
        J = det(F)
        stress, _ = self.material.gradient([F, state])
        stress += p * J * transpose(inv(F, determinant=J))
        return [stress, J - 1.0, state]

    def _hessian(self, x: Any) -> Any:
        (F, p), state = x[:2], x[-1]
        J = det(F)
        inverse = transpose(inv(F, determinant=J))
        tangent = self.material.hessian([F, state])[0]
        tangent = tangent + p * J * (dya(inverse, inverse) - cdya_il(inverse, inverse))
        return [tangent, J * inverse, None]


class Solid:
    """Solid body on fields (quadratic displacement, linear continuous pressure), assembled as its users do."""

    name = f"FElupe {felupe.__version__}"

    def __init__(self, mesh: Any, degree: int) -> None:
        cells = mesh.t.T.copy()
        edges = mesh.p.T[cells[:, 1:]] - mesh.p.T[cells[:, :1]]
        turned = np.linalg.det(edges) < 0.0
        cells[turned, :2] = cells[turned, 1::-1]
        quadratic = felupe.Mesh(mesh.p.T.copy(), cells, "tetra").add_midpoints_edges()
        region = felupe.RegionQuadraticTetra(quadratic, quadrature=felupe.TetrahedronQuadrature(order=degree))
        self.field = felupe.FieldsMixed(region, n=2)
        material = MixedMaterial(felupe.NeoHookeCompressible(mu=1.0))
        self.body = felupe.SolidBody(material, self.field)
        self.places = quadratic.points
        self.vertices = quadratic.points[: self.field[1].values.shape[0]]
        self.points = region.quadrature.npoints

    def set(self, displacement: Callable[..., Any], pressure: Callable[..., Any]) -> None:
        self.field[0].values[:] = displacement(self.places)
        self.field[1].values[:] = pressure(self.vertices)[:, None]

    def sums(self) -> Any:
        """Vector and matrix of both fields, the matrix as CSR."""
        return self.body.assemble.vector(self.field), self.body.assemble.matrix(self.field)

    def probe(self, w: Callable[..., Any], q: Callable[..., Any]) -> tuple[float, float]:
        vector, matrix = self.sums()
        values = np.concatenate([w(self.places).ravel(), q(self.vertices)])
        return float(values @ vector.toarray().ravel()), float(values @ (matrix @ values))
