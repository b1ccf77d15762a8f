"""Meshes from files: names, units, kinds of cells, and what is said of files that are no good."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from skfem.io.meshio import to_meshio

from myobridge.build import build
from myobridge.errors import ParameterError
from myobridge.registry import registry
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.mesh.file import MeshFile
from myobridge_plugins.mesh.fusiform import Fusiform

FLAT = Block(size=(4.0, 2.0), cells=(4, 2))


def written(path, points, cells, **more):
    """File with `points` (n, dim) and blocks of `cells`; as 2D points have a z of 0 in most formats."""
    points = np.asarray(points, dtype=float)
    if points.shape[1] == 2:
        points = np.pad(points, ((0, 0), (0, 1)))
    form = {"file_format": more.pop("form")} if "form" in more else {}
    meshio.write_points_cells(path, points, [(kind, np.asarray(block)) for kind, block in cells], **more, **form)
    return path


def message(path, **given) -> str:
    with pytest.raises(ParameterError) as caught:
        MeshFile(file=str(path), **given).mesh()
    return str(caught.value)


# ---------------------------------------------------------------------- what is read


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
@pytest.mark.parametrize("ending", ["vtu", "xdmf", "msh", "vtk", "inp"])
def test_what_scikit_fem_writes_comes_back(tmp_path, shape, ending):
    size, cells = ((4.0, 2.0), (4, 2)) if shape in ("triangle", "quadrilateral") else ((4.0, 2.0, 1.0), (4, 2, 2))
    mesh = Block(size=size, cells=cells, shape=shape, bow=0.3).mesh()
    raw = to_meshio(mesh, encode_cell_data=False)
    path = written(
        tmp_path / f"body.{ending}",
        raw.points,
        [(block.type, block.data) for block in raw.cells],
        **({"form": "gmsh"} if ending == "msh" else {}),
    )
    again = MeshFile(file=str(path), scale=1e-3).mesh()
    assert type(again) is type(mesh)
    assert again.p == pytest.approx(1e-3 * mesh.p, abs=1e-15)
    assert np.array_equal(again.t, mesh.t)


def gmsh_parts(form: str):
    """A rectangle in the words of gmsh: two surfaces, and two named edges of it and one without a name."""
    mesh = FLAT.mesh()
    left = mesh.p[0, mesh.t].mean(axis=0) < 2.0
    edges = [mesh.facets[:, mesh.boundaries[name]].T for name in ("left", "right", "top")]
    cells = [("triangle", mesh.t.T), ("line", np.vstack(edges))]
    edge_tags = np.repeat([7, 8, 0], [len(item) for item in edges])
    tags = [np.where(left, 1, 2).astype(np.int32), edge_tags.astype(np.int32)]
    names = {
        "soft": np.array([1, 2]),
        "stiff": np.array([2, 2]),
        "clamped": np.array([7, 1]),
    }
    return (
        mesh,
        left,
        {
            "cells": cells,
            "cell_data": {"gmsh:physical": tags, "gmsh:geometrical": tags},
            "field_data": names,
            "form": form,
        },
    )


def test_physical_groups_name_regions_and_boundaries(tmp_path):
    mesh, left, content = gmsh_parts("gmsh22")
    path = written(tmp_path / "parts.msh", mesh.p.T, **content)
    again = MeshFile(file=str(path)).mesh()
    assert np.array_equal(again.subdomains["soft"], np.flatnonzero(left))
    assert np.array_equal(again.subdomains["stiff"], np.flatnonzero(~left))
    assert np.array_equal(np.sort(again.boundaries["clamped"]), np.sort(mesh.boundaries["left"]))
    assert np.array_equal(np.sort(again.boundaries["8"]), np.sort(mesh.boundaries["right"]))  # a tag without a name
    assert sorted(again.subdomains) == ["soft", "stiff"]
    assert sorted(again.boundaries) == ["8", "clamped"]  # 0 means: no group


GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
1 7 "foot"
1 8 "between"
2 9 "body"
$EndPhysicalNames
$Entities
0 2 2 0
1 0 0 0 1 0 0 1 7 0
2 1 0 0 1 1 0 1 8 0
1 0 0 0 1 1 0 1 9 0
2 1 0 0 2 1 0 1 9 0
$EndEntities
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
1 1 0
0 1 0
2 0 0
2 1 0
$EndNodes
$Elements
4 6 1 6
1 1 1 1
1 1 2
1 2 1 1
2 2 3
2 1 2 2
3 1 2 3
4 1 3 4
2 2 2 2
5 2 5 6
6 2 6 3
$EndElements
"""


def test_gmsh_of_today_with_a_named_face_inside(tmp_path):
    (tmp_path / "two.msh").write_text(GMSH_41)
    mesh = MeshFile(file=str(tmp_path / "two.msh")).mesh()
    assert mesh.nelements == 4
    assert mesh.subdomains["body"].tolist() == [0, 1, 2, 3]
    foot, between = (mesh.p[:, mesh.facets[:, mesh.boundaries[name]]] for name in ("foot", "between"))
    assert np.all(foot[1] == 0.0)
    assert foot[0].max() == 1.0
    assert np.all(between[0] == 1.0)
    assert mesh.boundaries["between"][0] not in mesh.boundary_facets()


def test_sets_of_abaqus_name_cells_and_by_their_nodes_boundaries(tmp_path):
    mesh = Fusiform().mesh()
    left = np.unique(mesh.facets[:, mesh.boundaries["left"]])
    path = written(
        tmp_path / "muscle.inp",
        1e3 * mesh.p.T,
        [("tetra", mesh.t.T)],
        point_sets={"INSERTION": left},
        cell_sets={"TENDON": [mesh.subdomains["tendon"]]},
    )
    again = MeshFile(file=str(path), scale=1e-3).mesh()
    assert np.array_equal(again.subdomains["TENDON"], np.sort(mesh.subdomains["tendon"]))
    assert np.array_equal(np.sort(again.boundaries["INSERTION"]), np.sort(mesh.boundaries["left"]))


def test_tags_of_a_scene_and_planes(tmp_path):
    mesh = FLAT.mesh()
    colours = np.where(mesh.p[1, mesh.t].mean(axis=0) < 1.0, 3, 4)
    path = written(tmp_path / "body.vtu", mesh.p.T, [("triangle", mesh.t.T)], cell_data={"colour": [colours]})
    table = {
        "plugin": "file",
        "file": "body.vtu",
        "tags": "colour",
        "scale": 0.01,
        "planes": [{"name": "left", "axis": "x", "at": 0.0}, {"name": "lid", "axis": "y", "at": 0.02}],
    }
    again = build(registry(), "mesh", table, folder=tmp_path).mesh()
    assert np.array_equal(again.subdomains["3"], np.flatnonzero(colours == 3))
    assert np.array_equal(np.sort(again.boundaries["left"]), np.sort(mesh.boundaries["left"]))
    assert np.array_equal(np.sort(again.boundaries["lid"]), np.sort(mesh.boundaries["top"]))
    with pytest.raises(
        ParameterError, match=r"planes\[0\]\.at: no facet of the outside lies in x = 0\.5 m; .* from 0 to 4 m"
    ):
        MeshFile(file=str(path), planes=build_planes(tmp_path, "x", 0.5)).mesh()
    with pytest.raises(ParameterError, match=r"planes\[0\]\.axis: is 'z'; the mesh has x, y"):
        MeshFile(file=str(path), planes=build_planes(tmp_path, "z", 0.0)).mesh()
    with pytest.raises(ParameterError, match=r"tags: the file holds no 'color' .* Did you mean 'colour'"):
        MeshFile(file=str(path), tags="color").mesh()


def build_planes(folder, axis, at):
    table = {"plugin": "file", "file": "body.vtu", "planes": [{"name": "cut", "axis": axis, "at": at}]}
    return build(registry(), "mesh", table, folder=folder).planes


def test_quadratic_cells_lose_their_middles_on_request_only(tmp_path):
    # Two triangles with nodes in the middle of their edges; one edge is curved.
    points = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 1], [1, 2.3], [0, 1]]
    cells = [("triangle6", [[0, 1, 2, 4, 5, 6], [0, 2, 3, 6, 7, 8]]), ("line3", [[0, 1, 4]])]
    tags = [np.array([1, 1], np.int32), np.array([5], np.int32)]
    path = written(
        tmp_path / "curved.msh",
        points,
        cells,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        form="gmsh22",
    )
    assert "holds 2 triangle6; meshes have straight edges here" in message(path)
    mesh = MeshFile(file=str(path), straighten=True).mesh()
    assert mesh.p.T.tolist() == [[0, 0], [2, 0], [2, 2], [0, 2]]
    assert np.all(mesh.p[1, mesh.facets[:, mesh.boundaries["5"]]] == 0.0)


# ---------------------------------------------------------------------- what is refused


def test_files_that_are_none(tmp_path):
    assert "does not exist. Allowed: " in message(tmp_path / "none.msh") or "Nothing is allowed" in message(
        tmp_path / "n.msh"
    )
    written(tmp_path / "muscle.vtu", FLAT.mesh().p.T, [("triangle", FLAT.mesh().t.T)])
    assert "Did you mean 'muscle.vtu'?" in message(tmp_path / "mussle.vtu")
    (tmp_path / "broken.msh").write_text("no mesh at all\n")
    assert "cannot be read by meshio" in message(tmp_path / "broken.msh")
    (tmp_path / "broken.vtu").write_text("<VTKFile")
    assert "cannot be read by meshio" in message(tmp_path / "broken.vtu")
    (tmp_path / "mesh.docx").write_text("")
    assert "cannot be read by meshio" in message(tmp_path / "mesh.docx")


SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
TWO = [[0, 1, 2], [0, 2, 3]]


def test_cells_of_the_wrong_kind(tmp_path):
    assert "holds 1 line; expected one of" in message(written(tmp_path / "a.vtu", SQUARE, [("line", [[0, 1]])]))
    mixed = [("triangle", [[0, 1, 2]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[0, 2, 3]])]
    assert "mixes cells: 2 triangle, 1 quad" in message(written(tmp_path / "b.vtu", SQUARE, mixed))
    wedge = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]
    assert "holds 1 wedge; expected one of triangle, quad, tetra" in message(
        written(tmp_path / "c.vtu", wedge, [("wedge", [[0, 1, 2, 3, 4, 5]])])
    )


def test_flat_cells_out_of_the_plane(tmp_path):
    surface = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]])
    said = message(written(tmp_path / "a.vtu", surface, [("triangle", TWO)]))
    assert "do not lie in z = 0: node 2 (1 of 4) is off it, z from 0 to 0.5" in said
    lifted = np.pad(np.array(SQUARE), ((0, 0), (0, 1)), constant_values=3.0)
    assert "nodes 0, 1, 2, 3 (4 of 4) are off it" in message(written(tmp_path / "b.vtu", lifted, [("triangle", TWO)]))


@pytest.mark.parametrize(
    ("points", "cells", "words"),
    [
        ([*SQUARE, [9.0, 9.0]], TWO, "node 4 (1 of 5) is in no cell"),
        ([*SQUARE, [1.0, 1.0]], [[0, 1, 2], [0, 4, 3]], "nodes 2, 4 (2 of 5) are at the same place as another"),
        ([*SQUARE, [0.5, 0.0]], [*TWO, [0, 1, 4]], "cell 2 (1 of 3) is degenerate: without volume"),
        ([*SQUARE[:3], [0.9, 0.1]], TWO, "inverted: on the same side of a facet as the neighbour"),
    ],
)
def test_meshes_that_cannot_be_computed_on(tmp_path, points, cells, words):
    assert words in message(written(tmp_path / "a.vtu", points, [("triangle", cells)]))


def test_an_inverted_cell_is_named_by_its_number_in_the_file(tmp_path):
    mesh = Block(size=(3.0, 2.0, 2.0), cells=(3, 2, 2)).mesh()
    before = np.linalg.det(np.moveaxis(mesh.p[:, mesh.t[1:]] - mesh.p[:, mesh.t[:1]], 2, 0))
    p = mesh.p.copy()
    p[:, np.flatnonzero((p[0] == 1.0) & (p[1] == 1.0) & (p[2] == 1.0))[0]] += [1.17, 0.13, 0.21]
    after = np.linalg.det(np.moveaxis(p[:, mesh.t[1:]] - p[:, mesh.t[:1]], 2, 0))
    turned = np.flatnonzero(before * after < 0.0)
    said = message(written(tmp_path / "a.vtu", p.T, [("tetra", mesh.t.T)]))
    assert f"cells {', '.join(map(str, turned[:5]))}" in said
    assert f"({len(turned)} of {mesh.nelements}) are inverted" in said
    assert 0 < len(turned) < 20


def test_left_handed_files_are_no_error(tmp_path):
    """Some programs number cells the other way round, or without any rule; the body is the same."""
    mesh = Block(size=(1.0, 1.0, 1.0), cells=(2, 2, 2), shape="hexahedron").mesh()
    raw = to_meshio(mesh, encode_cell_data=False)
    mirrored = raw.cells[0].data[:, [4, 5, 6, 7, 0, 1, 2, 3]]
    path = written(tmp_path / "a.vtu", raw.points, [("hexahedron", mirrored)])
    assert MeshFile(file=str(path)).mesh().nelements == 8


def test_a_named_facet_that_is_none(tmp_path):
    tags = [np.array([1, 1], np.int32), np.array([5], np.int32)]
    path = written(
        tmp_path / "a.msh",
        SQUARE,
        [("triangle", TWO), ("line", [[1, 3]])],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        form="gmsh22",
    )
    assert "1 of 1 facets of '5' are no facets of its cells" in message(path)
