r"""Element pairs: shape functions of displacement, geometry and multiplier at the quadrature points of one cell.

=============  ==============================  ============================================================
pair           cells                           multiplier
=============  ==============================  ============================================================
``P2-P1``      triangles, tetrahedra           continuous, linear (Taylor and Hood [1]_); inf-sup stable
``Q2-P1disc``  quadrilaterals, hexahedra       linear in each cell, discontinuous; inf-sup stable
``P1-P0``      triangles, tetrahedra           constant in each cell; locks, kept to show that it does
``P2``, ``Q2``, ``P1``                         none: compressible tissue
=============  ==============================  ============================================================

The discontinuous pressure is linear in the coordinates of the cell, not in space: pressure and strain are of order 2
where cells become parallelograms as the mesh is refined, and drop to 1 where they stay distorted [2]_.

References
----------
.. [1] C. Taylor, P. Hood, Comput. Fluids 1 (1973) 73-100.
.. [2] D. Boffi, L. Gastaldi, Int. J. Numer. Meth. Fluids 39 (2002) 1001-1011.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from myobridge.errors import ParameterError, nearest
from myobridge.interfaces import Array

__all__ = ["PAIRS", "ReferenceCell", "facet_nodes", "pair_of", "reference_cell"]

PAIRS = ("P2-P1", "Q2-P1disc", "P1-P0", "P2", "Q2", "P1")
_TENSOR = ("quad", "hex")


class ReferenceCell(NamedTuple):
    """One cell at its quadrature points.

    Attributes
    ----------
    element : skfem.Element
        Scalar element of each displacement component.
    multiplier : str
        "P1", "P1disc", "P0" or "".
    points, weights : ndarray, (dim, n_q) and (n_q,)
    slopes : ndarray, (n_q, n_nodes, 3)
        Derivatives of the displacement's shape functions by the local coordinates; zero beyond the dimension.
    values : ndarray, (n_q, n_nodes)
        The shape functions themselves.
    map_slopes : ndarray, (n_q, n_corners, 3)
        Derivatives of the corner functions, which map the cell.
    shapes : ndarray, (n_q, n_multipliers)
        Shape functions of the multiplier.
    affine : bool
        Whether the Jacobian is constant in a cell.
    """

    element: Any
    multiplier: str
    points: Array
    weights: Array
    slopes: Array
    values: Array
    map_slopes: Array
    shapes: Array
    affine: bool


def pair_of(mesh: Any, pair: str | None, incompressible: bool) -> str:
    """The pair to use on a mesh: the one asked for, or the default.

    Raises
    ------
    ParameterError
        If the pair does not exist on these cells, or does not go with the effect `incompressibility`.
    """
    tensor = _kind(mesh) in _TENSOR
    fitting = ("Q2-P1disc", "Q2") if tensor else ("P2-P1", "P1-P0", "P2", "P1")
    if pair is None:
        return fitting[0] if incompressible else fitting[0][:2]
    if pair not in fitting:
        cells = "quadrilaterals and hexahedra" if tensor else "triangles and tetrahedra"
        raise ParameterError("elements", f"is '{pair}', which does not exist on {cells}. {nearest(pair, fitting)}")
    if incompressible != ("-" in pair):
        said = "needs" if incompressible else "does without"
        allowed = [name for name in fitting if ("-" in name) == incompressible]
        raise ParameterError(
            "elements",
            f"is '{pair}', but the scene {said} a multiplier for the effect 'incompressibility'. "
            f"{nearest(pair, allowed)}",
        )
    return pair


def reference_cell(mesh: Any, pair: str, degree: int) -> ReferenceCell:
    """Tables of a pair on the cells of `mesh`, with a quadrature rule exact to `degree`."""
    import skfem
    from skfem.quadrature import get_quadrature

    kind = _kind(mesh)
    displacement, _, multiplier = pair.partition("-")
    name = {"tri": "Tri", "tet": "Tet", "quad": "Quad", "hex": "Hex"}[kind]
    letter = {"P2": "P2", "P1": "P1", "Q2": "2"}[displacement]
    element = getattr(skfem, f"Element{name}{letter}")()
    corner = mesh.elem()
    points, weights = get_quadrature(element, degree)
    slopes, values = _tables(element, points)
    map_slopes, corner_values = _tables(corner, points)
    if multiplier == "P1":
        shapes = corner_values
    elif multiplier == "P1disc":
        shapes = np.vstack([np.ones(points.shape[1]), points - 0.5]).T
    else:
        shapes = np.ones((points.shape[1], 1 if multiplier else 0))
    return ReferenceCell(
        element,
        multiplier,
        points,
        np.ascontiguousarray(weights),
        slopes,
        values,
        map_slopes,
        np.ascontiguousarray(shapes),
        kind not in _TENSOR,
    )


def facet_nodes(mesh: Any, element: Any) -> tuple[Any, np.ndarray, np.ndarray]:
    """Facet element, and for each facet of the cell the numbers of its nodes, in two orders that face opposite ways.

    Both tables are (n_facets of a cell, n_nodes of a facet).
    """
    import skfem

    kind = _kind(mesh)
    linear = len(element.doflocs) == mesh.elem.refdom.p.shape[1]
    names = {"tri": ("LineP1", "LineP2"), "quad": ("LineP1", "LineP2"), "tet": ("TriP1", "TriP2")}
    names["hex"] = ("Quad1", "Quad2")
    facet = getattr(skfem, "Element" + names[kind][0 if linear else 1])()
    corners = mesh.elem.refdom.p
    tables = []
    for turned in (False, True):
        rows = []
        for numbers in mesh.elem.refdom.facets:
            ends = corners[:, list(numbers)]
            if turned:
                ends = ends[:, [0, *range(ends.shape[1] - 1, 0, -1)]] if ends.shape[1] > 2 else ends[:, ::-1]
            # A point of the facet stands at its first corner plus its coordinates along both edges from there.
            edges = np.stack([ends[:, 1] - ends[:, 0], *([ends[:, -1] - ends[:, 0]] if ends.shape[1] > 2 else [])])
            places = ends[:, 0] + facet.doflocs @ edges
            distance = np.linalg.norm(places[:, None] - element.doflocs[None], axis=2)
            assert np.all(distance.min(axis=1) < 1e-12)
            rows.append(distance.argmin(axis=1))
        tables.append(np.array(rows))
    return facet, tables[0], tables[1]


def _kind(mesh: Any) -> str:
    return mesh.elem.refdom.__name__.lower().removeprefix("ref")


def _tables(element: Any, points: Array) -> tuple[Array, Array]:
    """Derivatives (n_q, n_nodes, 3) and values (n_q, n_nodes) of a scalar element."""
    n_nodes, (dimension, n_q) = len(element.doflocs), points.shape
    slopes, values = np.zeros((n_q, n_nodes, 3)), np.empty((n_q, n_nodes))
    for a in range(n_nodes):
        value, slope = element.lbasis(points, a)
        values[:, a] = value
        slopes[:, a, :dimension] = np.asarray(slope).T
    return slopes, values
