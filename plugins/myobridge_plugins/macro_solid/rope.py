"""Elastic rope, finite elements on a line."""

from __future__ import annotations

from typing import Any, ClassVar, final

import attrs
import numpy as np
import scipy.sparse as sparse

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MacroSolid
from myobridge.parameters import integer
from myobridge_plugins.macro_solid.line import Line, LineMesh


@final
@attrs.frozen(eq=False)
class Rope(Line):
    r"""Continuous elastic rope (thesis, Examples 1.33 and 1.34), the limit of the chain.

    .. math:: L = \int_0^L \frac{m}{2L} |\dot\varphi|^2 - \frac{E A}{2} (|\varphi'| - 1)^2 \, dX

    Quadratic elements, consistent mass; two Gauss points an element are the sites.
    """

    summary: ClassVar[str] = "continuous elastic rope, quadratic finite elements (thesis, Example 1.34)"

    elements: int = integer(10, within="[1, inf)", doc="number of quadratic elements")

    def cut(self) -> LineMesh:
        import skfem

        mesh = skfem.MeshLine(np.linspace(0.0, self.length, self.elements + 1))
        # Order 4 integrates the mass exactly; the stiffness sites are the two Gauss points of order 3.
        element = skfem.ElementLineP2()
        mass_basis = skfem.Basis(mesh, element, intorder=4)
        sites = skfem.Basis(mesh, element, intorder=3)
        mass = skfem.BilinearForm(lambda u, v, w: u * v / self.length).assemble(mass_basis)
        coordinates = np.asarray(mass_basis.doflocs[0])
        order = np.argsort(coordinates)
        n_sites = sites.dx.size
        rows = np.arange(n_sites).reshape(sites.dx.shape)
        derivative = sparse.lil_array((n_sites, coordinates.size))
        for local in range(sites.Nbfun):  # three shape functions of one reference element, not a loop over elements
            field: Any = sites.basis[local][0]
            columns = np.asarray(sites.element_dofs[local])
            derivative[rows, np.broadcast_to(columns[:, None], rows.shape)] = field.grad[0]
        derivative = sparse.csr_array(derivative)[:, order]
        points = np.asarray(sites.global_coordinates())[0].ravel()
        return LineMesh(
            coordinates[order], points, derivative, sites.dx.ravel(), sparse.csc_array(mass)[order][:, order]
        )


@hookimpl
def myobridge_macro_solids() -> dict[str, type[MacroSolid]]:
    return {"rope": Rope}
