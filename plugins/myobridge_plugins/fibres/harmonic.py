"""Fibres that run from one tendon to the other as a potential flow would."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Fibres
from myobridge.mesh_check import listed
from myobridge.mesh_names import boundary_facets
from myobridge.parameters import integer, text
from myobridge_plugins.fibres.laplace import potential

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Harmonic"]

# Below this share of its mean, the gradient is rounding: a stagnation point, where no direction is right.
_STILL = 1e-8


@final
@attrs.frozen
class Harmonic(Fibres):
    r"""Normalised gradient of the harmonic potential between two named boundaries.

    .. math:: \Delta\varphi = 0, \qquad \varphi = 0 \text{ on start}, \quad \varphi = 1 \text{ on end}, \quad
              \partial_n \varphi = 0 \text{ elsewhere}; \qquad N = \nabla\varphi / |\nabla\varphi|

    Fibres leave both boundaries at right angles, follow the outline between them and never cross.

    Parameters
    ----------
    start, end : str
        Named boundaries, such as the two tendon faces; they may lie inside the body too.
    order : {1, 2}
        Degree of the elements. Of the potential: with 1 the direction is constant in a triangle or tetrahedron; with 2
        its error falls with the square of the cell size.

    Raises
    ------
    ParameterError
        If a boundary does not exist, both share a node, a part of the mesh touches neither, or the gradient vanishes
        somewhere; the message names the cells.

    References
    ----------
    .. [1] J. D. Bayer, R. C. Blake, G. Plank, N. A. Trayanova, Ann. Biomed. Eng. 40 (2012) 2243-2254: fibres from
       Laplace problems.
    """

    summary: ClassVar[str] = "from one boundary to another, along the gradient of a harmonic potential"

    start: str = text(doc="name of the boundary where the fibres begin")
    end: str = text(doc="name of the boundary where they end")
    order: int = integer(2, within="[1, 2]", doc="degree of the elements for the potential")

    def directions(self, mesh: Mesh, points: Array) -> Array:
        start, end = (boundary_facets(mesh, getattr(self, key), key) for key in ("start", "end"))
        all_facets: Any = mesh.facets
        shared = np.intersect1d(all_facets[:, start], all_facets[:, end])
        if shared.size:
            raise ParameterError(
                "end", f"'{self.end}' and '{self.start}' share {shared.size} nodes: the potential would jump there"
            )
        gradient = potential(mesh, start, end, self.order, points)
        size = np.linalg.norm(gradient, axis=0)
        # A body in pieces: one that touches neither boundary has no potential, one that touches one has no gradient.
        still = np.flatnonzero(~(size > _STILL * np.nanmean(size)).all(axis=1))
        if still.size:
            raise ParameterError(
                "start",
                f"no direction leads from here to '{self.end}' where the potential is level: "
                f"{listed(still, mesh.nelements, 'cell')} such",
            )
        return np.ascontiguousarray(np.moveaxis(gradient / size, 0, 2))


@hookimpl
def myobridge_fibres():
    return {"harmonic": Harmonic}
