"""Mesh source: where the shape of a body comes from.

A mesh is a `skfem.Mesh` of triangles, quadrilaterals, tetrahedra or hexahedra with straight edges, in metres. Its
*boundaries* (named sets of facets, for loads and supports) and *subdomains* (named sets of cells, the regions) are
scikit-fem's own: ``mesh.boundaries["left"]``, ``mesh.subdomains["tendon"]``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["MeshSource"]


class MeshSource(ABC):
    """Abstract source of a mesh; sizes and file names are the attributes of a frozen class."""

    summary: ClassVar[str] = ""

    @abstractmethod
    def mesh(self) -> Mesh:
        """The mesh, with named boundaries and subdomains.

        Raises
        ------
        ParameterError
            If cells are inverted or degenerate (it names them), or the file is not what it should be.
        """
