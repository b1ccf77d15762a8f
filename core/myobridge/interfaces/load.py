r"""Load: what acts on a named part of the boundary, as nodal forces of its facets.

.. math:: f_{a} = \int N_a\,t\,dA

A load sees a `Surface`: the facets, their nodes and quadrature, never the inside of the body. It works on all facets at
once and returns one force a node; the solid adds them up.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import attrs

from myobridge.interfaces.active_law import Array

__all__ = ["Load", "Surface"]


@attrs.frozen(eq=False)
class Surface:
    r"""Facets of a named boundary; ``dim`` is 2 (edges of a body of some thickness) or 3 (faces).

    Attributes
    ----------
    name : str
        Name of the boundary.
    positions : ndarray, shape (n_facets, n_nodes, dim)
        Reference positions of the nodes [m]. Nodes are ordered so that the normal points outwards: in 3D along
        :math:`x_{,0} \times x_{,1}`, in 2D along :math:`(x_{,0})` turned by -90 degrees, ``(t_y, -t_x)``.
    shapes : ndarray, shape (n_points, n_nodes)
        Shape functions at the quadrature points.
    slopes : ndarray, shape (n_points, n_nodes, dim - 1)
        Their derivatives by the coordinates of the reference facet.
    weights : ndarray, shape (n_points,)
        Quadrature weights on the reference facet.
    areas : ndarray, shape (n_facets, n_points)
        Reference area [m^2] that each point stands for (2D: length times thickness); sums to the area of the boundary.
    thickness : float
        Depth of a 2D body [m]; 1 in 3D.
    """

    name: str
    positions: Array
    shapes: Array
    slopes: Array
    weights: Array
    areas: Array
    thickness: float = 1.0

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.positions.shape[2]


class Load(ABC):
    """Abstract load on the boundary `boundary`; every implementation declares that parameter.

    Class attributes
    ----------------
    dead : bool
        Whether the force does not depend on the displacement.
    """

    summary: ClassVar[str] = ""
    dead: ClassVar[bool] = True
    boundary: str

    @abstractmethod
    def nodal_force(self, surface: Surface, displacement: Array, time: float) -> Array:
        """Nodal forces [N] at `displacement` (n_facets, n_nodes, dim) [m]; same shape.

        Raises
        ------
        ParameterError
            If the load does not fit the dimension.
        """

    def nodal_stiffness(self, surface: Surface, displacement: Array, time: float) -> Array | None:
        """Minus d force / d displacement, (n_facets, n_nodes, dim, n_nodes, dim) [N/m]; None where it is zero."""
        return None

    def nodal_mass(self, surface: Surface) -> Array | None:
        """Mass that hangs on the facets, (n_facets, n_nodes, n_nodes) [kg], the same for each component; None: none."""
        return None

    def energy(self, surface: Surface, displacement: Array) -> float:
        """Energy stored in a spring [J]; then its force is no external one."""
        return 0.0

    def jumps(self) -> tuple[float, ...]:
        """Times [s] at which the load jumps or bends; steps end there."""
        return ()
