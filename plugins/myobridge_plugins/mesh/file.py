"""A mesh from a file of any format that meshio reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MeshSource
from myobridge.mesh_check import check_mesh
from myobridge.parameters import choice, flag, number, records, text
from myobridge_plugins.mesh.parts import named_parts
from myobridge_plugins.mesh.reading import read

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["MeshFile", "Plane"]

_AXES = ("x", "y", "z")

# Where VTK's corner of a hexahedron stands among scikit-fem's.
_HEXAHEDRON = (0, 3, 6, 2, 1, 5, 7, 4)


@final
@attrs.frozen
class Plane:
    """Part of the outside that lies in a plane, to be named: for files without names."""

    name: str = text(doc="name of the boundary")
    axis: str = choice("x", _AXES, doc="axis at right angles to the plane")
    at: float = number(unit="m", doc="where the plane crosses the axis")


@final
@attrs.frozen
class MeshFile(MeshSource):
    """Mesh from a file: gmsh's .msh, .vtu, .vtk, .xdmf, .inp, .mesh, .bdf and whatever else meshio reads.

    Cells of one kind: triangles or quadrilaterals in z = 0, tetrahedra or hexahedra; further blocks of facets only
    carry names. Subdomains: sets of cells, physical groups, tags. Boundaries: the same of facets (also inner ones, such
    as the face between tendon and muscle), sets of nodes, and `planes`. Tags without a name are named by their number.
    What is checked stands at `myobridge.mesh_check`; cells and nodes are numbered from 0 in the order of the file.

    Parameters
    ----------
    file : str
        Path of the file; in a scene, relative to the scene's file.
    scale : float
        Unit of the coordinates in the file [m]: 1e-3 for millimetres.
    straighten : bool
        Whether quadratic cells are taken by their corners; a curved outline becomes coarser.
    tags : str, optional
        Array of whole numbers, one a cell, that tells the parts; by default that of the file's format.
    planes : list of Plane
        Boundaries named by the plane they lie in, within a millionth of the size of the body.

    Raises
    ------
    ParameterError
        If the file is missing or unreadable, holds no body, or its mesh cannot be computed on.
    """

    summary: ClassVar[str] = "any file that meshio reads (.msh, .vtu, .xdmf, .inp ...), with its named regions"

    file: str = text(doc="mesh file", kind="file")
    scale: float = number(1.0, unit="m", within="(0, inf)", doc="unit of the coordinates, 1e-3 for millimetres")
    straighten: bool = flag(False, doc="take quadratic cells by their corners")
    tags: str = text("", doc="array of whole numbers, one a cell, that tells the parts; default: the format's own")
    planes: tuple[Plane, ...] = records(Plane, doc="boundaries named by the plane they lie in")

    def mesh(self) -> Mesh:
        import skfem

        content = read(Path(self.file), self.straighten)
        cells = content.cells[:, np.argsort(_HEXAHEDRON)] if content.kind == "hexahedron" else content.cells
        kinds: dict[str, Any] = {
            "triangle": skfem.MeshTri,
            "quad": skfem.MeshQuad,
            "tetra": skfem.MeshTet,
            "hexahedron": skfem.MeshHex,
        }
        points = np.ascontiguousarray(self.scale * content.points.T)
        mesh = kinds[content.kind](points, np.ascontiguousarray(cells.T, dtype=np.int32), validate=False)
        check_mesh(mesh, "file")
        boundaries, subdomains = named_parts(content, mesh, self.tags)
        for index, plane in enumerate(self.planes):
            if plane.name in boundaries:
                raise ParameterError(f"planes[{index}].name", f"'{plane.name}' is in the file already; choose another")
            boundaries[plane.name] = _in_plane(mesh, plane, f"planes[{index}]")
        return mesh.with_boundaries(boundaries).with_subdomains(subdomains)


def _in_plane(mesh: Any, plane: Plane, key: str) -> np.ndarray:
    axis = _AXES.index(plane.axis)
    if axis >= mesh.dim():
        raise ParameterError(f"{key}.axis", f"is '{plane.axis}'; the mesh has {', '.join(_AXES[: mesh.dim()])}")
    outer = mesh.boundary_facets()
    size = float(np.linalg.norm(np.ptp(mesh.p, axis=1)))
    there = (np.abs(mesh.p[axis][mesh.facets[:, outer]] - plane.at) <= 1e-6 * size).all(axis=0)
    if not there.any():
        low, high = mesh.p[axis].min(), mesh.p[axis].max()
        raise ParameterError(
            f"{key}.at",
            f"no facet of the outside lies in {plane.axis} = {plane.at:g} m; the body reaches from {low:g} to "
            f"{high:g} m",
        )
    return outer[there]


@hookimpl
def myobridge_meshes():
    return {"file": MeshFile}
