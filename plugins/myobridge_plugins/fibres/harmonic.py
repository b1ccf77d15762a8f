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

# Below this share of its mean, and of one over the size of the body, the gradient is rounding: no direction is right.
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
        Degree of the potential. The error of the direction falls with the cell size for 1 (it is constant in a triangle
        or tetrahedron); for 2 with its square, or its power 3/2 where `start` or `end` is curved and the cells are
        straight.

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
        usual = max(float(np.nanmean(size)), 1.0 / float(np.linalg.norm(np.ptp(mesh.p, axis=1))))
        still = np.flatnonzero(~(size > _STILL * usual).all(axis=1))
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
