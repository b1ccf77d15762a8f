"""From the parameters of a finite-element solid to its body."""

from __future__ import annotations

from typing import TYPE_CHECKING

from myobridge.errors import ParameterError, within
from myobridge_plugins.macro_solid.finite_element.body import Body
from myobridge_plugins.macro_solid.finite_element.loading import acceleration

if TYPE_CHECKING:
    from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement

__all__ = ["build"]


def build(solid: FiniteElement) -> Body:
    """The body that a solid describes.

    Raises
    ------
    ParameterError
        Naming the key.
    """
    if solid.quadrature in (3, 4):
        raise ParameterError("quadrature", f"is {solid.quadrature}, whose rule on tetrahedra has a negative weight")
    with within("mesh"):
        mesh = solid.mesh.mesh()
    weight = None if solid.gravity is None else solid.density * acceleration(solid.gravity, mesh.p.shape[0])
    return Body.of(
        mesh,
        solid.material,
        solid.fibres,
        regions=solid.region,
        supports=solid.support,
        loads=solid.load,
        elements=solid.elements,
        bulk_modulus=solid.bulk_modulus,
        weight=weight,
        thickness=solid.thickness,
        degree=solid.quadrature,
        threads=solid.threads,
    )
