"""Shapes of the built-in meshes: closed forms of volume and area, symmetry, refinement, and the errors they raise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import skfem
from hypothesis import given, settings
from hypothesis import strategies as st

from myobridge.errors import ParameterError
from myobridge.mesh_check import check_mesh, scaled_jacobian
from myobridge.mesh_names import boundary_facets, subdomain_cells
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.mesh.fusiform import Fusiform
from myobridge_plugins.mesh.spindle import Spindle


def volume(mesh) -> float:
    basis = skfem.Basis(mesh, skfem.ElementHex1() if isinstance(mesh, skfem.MeshHex) else _lowest(mesh), intorder=3)
    return float(basis.dx.sum())


def _lowest(mesh):
    kinds = {skfem.MeshTri: skfem.ElementTriP1, skfem.MeshQuad: skfem.ElementQuad1, skfem.MeshTet: skfem.ElementTetP1}
    return kinds[type(mesh)]()


def area_of(mesh, name: str) -> float:
    return float(
        skfem.FacetBasis(
            mesh,
            skfem.ElementHex1() if isinstance(mesh, skfem.MeshHex) else _lowest(mesh),
            facets=mesh.boundaries[name],
        ).dx.sum()
    )


# ---------------------------------------------------------------------- block


@pytest.mark.parametrize("bow", [0.0, 0.3])
@pytest.mark.parametrize("shape", ["tetrahedron", "hexahedron"])
def test_a_block_has_its_volume_and_its_sides(shape, bow):
    mesh = Block(size=(2.0, 0.5, 0.25), cells=(6, 3, 2), shape=shape, bow=bow, origin=(1.0, -1.0, 3.0)).mesh()
    assert volume(mesh) == pytest.approx(0.25, rel=1e-12)
    assert area_of(mesh, "left") == pytest.approx(0.125, rel=1e-12)
    assert area_of(mesh, "right") == pytest.approx(0.125, rel=1e-12)
    assert area_of(mesh, "front") == pytest.approx(0.5, rel=1e-12)
    for name, axis, place in (("left", 0, 1.0), ("right", 0, 3.0), ("front", 1, -1.0), ("back", 1, -0.5)):
        assert np.all(mesh.p[axis][mesh.facets[:, mesh.boundaries[name]]] == place)
    top = mesh.p[:, mesh.facets[:, mesh.boundaries["top"]]].reshape(3, -1)
    assert top[2] == pytest.approx(3.25 + bow * np.sin(np.pi * (top[0] - 1.0) / 2.0), abs=1e-12)


def test_a_bowed_column_keeps_its_ends_and_its_area():
    mesh = Block(size=(0.1, 0.01), cells=(20, 2), bow=1e-4).mesh()
    assert volume(mesh) == pytest.approx(1e-3, rel=1e-12)
    ends = mesh.p[:, np.isin(mesh.p[0], [0.0, 0.1])]
    assert np.sort(ends[1]) == pytest.approx([0.0, 0.0, 0.005, 0.005, 0.01, 0.01], abs=1e-17)
    middle = mesh.p[1, np.abs(mesh.p[0] - 0.05) < 1e-12]
    assert np.sort(middle) == pytest.approx([1e-4, 0.0051, 0.0101], abs=1e-15)


@pytest.mark.parametrize("cells", [(4, 2), (16, 4), (6, 6)])
def test_triangles_of_a_block_are_mirrored_and_none_is_caught_in_a_corner(cells):
    mesh = Block(size=(1.0, 0.4), cells=cells).mesh()
    centres = mesh.p[:, mesh.t].mean(axis=1).T
    for mirrored in ([1.0, 0.0] + centres * [-1.0, 1.0], [0.0, 0.4] + centres * [1.0, -1.0]):
        assert {*map(tuple, mirrored.round(9))} == {*map(tuple, centres.round(9))}
    outside = np.isin(mesh.t2f, mesh.boundary_facets()).sum(axis=0)
    assert outside.max() == 1


@pytest.mark.parametrize(
    ("given_", "key", "words"),
    [
        ({"size": [1.0], "cells": [2]}, "size", "expected a list of 2 or 3 numbers"),
        ({"size": 1.0, "cells": [2]}, "size", "expected a list of 2 or 3 numbers"),
        ({"size": [1.0, 1.0], "cells": [2, 2, 2]}, "cells", "expected 2 numbers, one for each of size"),
        ({"size": [1.0, 1.0], "cells": [2, 2.5]}, "cells[1]", "is 2.5; expected a whole number"),
        ({"size": [1.0, 1.0], "cells": [2, 2], "shape": "hexahedron"}, "shape", "one of triangle, quadrilateral"),
        ({"size": [1.0, 1.0], "cells": [2, 2], "origin": 0.0}, "origin", "expected 2 numbers"),
        ({"size": [1.0, -1.0], "cells": [2, 2]}, "size[1]", "expected a number or a list of numbers in (0, inf)"),
    ],
)
def test_a_block_says_what_is_wrong(given_, key, words):
    with pytest.raises(ParameterError) as caught:
        Block(**given_)
    assert caught.value.key == key
    assert words in str(caught.value)


# ---------------------------------------------------------------------- spindle


@pytest.mark.parametrize("tendon", [0.0, 0.15])
@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_the_area_of_a_spindle_converges_to_its_closed_form(shape, tendon):
    exact = 0.1 * (0.01 + (1.0 - 2.0 * tendon) * 0.01)
    errors = [
        abs(volume(Spindle(end_width=0.01, tendon=tendon, cells=16, shape=shape, refinements=r).mesh()) - exact)
        for r in range(4)
    ]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx([2.0] * 3, abs=0.1), f"observed rates of the area: {rates}, errors {errors}"


@pytest.mark.parametrize("tendon", [0.0, 0.1])
def test_refining_a_spindle_keeps_the_old_nodes_and_follows_the_outline(tendon):
    coarse, fine = (Spindle(cells=9, tendon=tendon, refinements=r).mesh() for r in (0, 1))
    assert fine.nelements == 4 * coarse.nelements
    from scipy.spatial import KDTree

    assert KDTree(fine.p.T).query(coarse.p.T)[0].max() < 1e-15
    x, y = fine.p[:, np.unique(fine.facets[:, fine.boundaries["top"]])]
    inside = np.clip((x / 0.1 - tendon) / (1.0 - 2.0 * tendon), 0.0, 1.0)
    assert y == pytest.approx(0.006 + 0.009 * np.sin(np.pi * inside) ** 2, abs=1e-15)
    assert np.ptp(y) > 0.008


def test_a_spindle_is_mirrored_in_both_axes():
    mesh = Spindle(cells=12, tendon=0.1).mesh()
    centres = mesh.p[:, mesh.t].mean(axis=1).T
    for mirrored in (centres * [1.0, -1.0], [0.1, 0.0] + centres * [-1.0, 1.0]):
        assert {*map(tuple, mirrored.round(9))} == {*map(tuple, centres.round(9))}


def test_tendons_are_the_cells_at_the_ends():
    mesh = Spindle(tendon=0.2, cells=20).mesh()
    x = mesh.p[0][mesh.t]
    left, right, both, muscle = (
        subdomain_cells(mesh, name, "region") for name in ("tendon_left", "tendon_right", "tendon", "muscle")
    )
    assert x[:, left].max() == pytest.approx(0.02)
    assert x[:, right].min() == pytest.approx(0.08)
    assert np.array_equal(both, np.union1d(left, right))
    assert np.array_equal(np.union1d(both, muscle), np.arange(mesh.nelements))
    assert len(both) + len(muscle) == mesh.nelements
    assert list(Spindle().mesh().subdomains) == ["muscle"]


# ---------------------------------------------------------------------- fusiform


@pytest.mark.parametrize("flatness", [1.0, 0.6])
@pytest.mark.parametrize("shape", ["tetrahedron", "hexahedron"])
def test_the_volume_of_a_fusiform_muscle_converges_to_its_closed_form(shape, flatness):
    d = 0.015 - 0.005
    share = 0.2 * 0.005**2 + 0.8 * (0.005**2 + 0.005 * d + 0.375 * d**2)
    exact = np.pi * flatness * 0.1 * share
    errors = [
        1.0 - volume(Fusiform(end_radius=0.005, across=n, cells=10 * n, shape=shape, flatness=flatness).mesh()) / exact
        for n in (2, 4, 8)
    ]
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx([2.0, 2.0], abs=0.15), f"observed rates of the volume: {rates}, errors {errors}"


@settings(max_examples=25)
@given(
    thin=st.floats(0.25, 1.0),
    flatness=st.floats(0.5, 1.0),
    tendon=st.floats(0.05, 0.2),
    slender=st.floats(6.0, 20.0),
    across=st.integers(2, 4),
    shape=st.sampled_from(["tetrahedron", "hexahedron"]),
)
def test_no_cell_of_a_fusiform_muscle_is_bad(thin, flatness, tendon, slender, across, shape):
    radius = 0.1 / slender
    source = Fusiform(
        radius=radius, end_radius=thin * radius, flatness=flatness, tendon=tendon, across=across, shape=shape
    )
    assert scaled_jacobian(source.mesh()).min() > 0.1


def test_the_parts_of_a_fusiform_muscle():
    mesh = Fusiform(flatness=0.5).mesh()
    assert mesh.p[0].min() == 0.0
    assert mesh.p[0].max() == pytest.approx(0.1)
    assert np.abs(mesh.p[1]).max() == pytest.approx(0.015, rel=0.02)
    assert np.abs(mesh.p[2]).max() == pytest.approx(0.0075, rel=0.02)
    assert area_of(mesh, "left") == pytest.approx(0.5 * np.pi * 0.006**2, rel=0.11)
    assert area_of(mesh, "left") == pytest.approx(area_of(mesh, "right"), rel=1e-12)
    assert sorted(mesh.subdomains) == ["muscle", "tendon", "tendon_left", "tendon_right"]
    with pytest.raises(ParameterError, match=r"end_radius: is 0\.02; expected a number in \(0, 0\.015\]"):
        Fusiform(end_radius=0.02)


# ---------------------------------------------------------------------- names and checks


def test_a_name_that_is_not_there_lists_those_that_are():
    mesh = Spindle().mesh()
    assert len(boundary_facets(mesh, "left", "load.boundary")) > 0
    with pytest.raises(
        ParameterError, match=r"^load\.boundary: .*'lefft'. Allowed: bottom, left, right, top. Did .* 'left'"
    ):
        boundary_facets(mesh, "lefft", "load.boundary")
    with pytest.raises(ParameterError, match=r"^region: .*subdomain 'tendon'\. Allowed: muscle"):
        subdomain_cells(mesh, "tendon", "region")
    with pytest.raises(ParameterError, match="the mesh has no named boundaries"):
        boundary_facets(skfem.MeshTri(), "left", "support")
    with pytest.raises(ParameterError, match="'none' of the mesh holds no facet"):
        boundary_facets(skfem.MeshTri().with_boundaries({"none": np.array([], dtype=int)}), "none", "support")


SOUND = {
    "triangle": Block(size=(1.0, 1.0), cells=(4, 4)),
    "quadrilateral": Block(size=(1.0, 1.0), cells=(4, 4), shape="quadrilateral"),
    "tetrahedron": Block(size=(1.0, 1.0, 1.0), cells=(3, 3, 3)),
    "hexahedron": Block(size=(1.0, 1.0, 1.0), cells=(3, 3, 3), shape="hexahedron"),
}


def broken(shape: str, move) -> str:
    """Message about the mesh of `shape` after `move` changed a copy of its nodes and cells."""
    mesh = SOUND[shape].mesh()
    p, t = mesh.p.copy(), mesh.t.copy()
    changed = move(p, t)
    p, t = changed if changed is not None else (p, t)
    with pytest.raises(ParameterError) as caught:
        check_mesh(replace(mesh, doflocs=p, t=t, _boundaries=None, _subdomains=None), "file")
    assert caught.value.key == "file"
    return str(caught.value)


def inner_node(p) -> int:
    return int(np.argmin(np.linalg.norm(p - 0.5, axis=0)))


@pytest.mark.parametrize("shape", ["triangle", "tetrahedron"])
def test_a_folded_mesh_names_the_cells_beyond_the_fold(shape):
    """One node is pulled out of its own star: the cells that turn over are those whose volume changes sign."""
    mesh = SOUND[shape].mesh()
    star = np.flatnonzero((mesh.t == inner_node(mesh.p)).any(axis=0))

    def pull(p, t):
        p[:, inner_node(p)] += 0.4

    before, after = (
        np.sign(skfem.MappingAffine(item).detA) for item in (mesh, replace(mesh, doflocs=_pulled(mesh, pull)))
    )
    turned = np.flatnonzero(before != after)
    assert 0 < len(turned) < len(star)
    message = broken(shape, pull)
    assert f"cells {', '.join(map(str, turned[:5]))}" in message
    assert f"({len(turned)} of {mesh.nelements}) are inverted" in message


def _pulled(mesh, move):
    p = mesh.p.copy()
    move(p, mesh.t)
    return p


@pytest.mark.parametrize("shape", ["quadrilateral", "hexahedron"])
def test_a_cell_whose_jacobian_changes_sign_is_inverted(shape):
    def pull(p, t):
        p[:, inner_node(p)] += 0.45

    assert "inverted: J changes sign inside" in broken(shape, pull)


@settings(max_examples=20)
@given(seed=st.integers(0, 1000), shape=st.sampled_from(["triangle", "quadrilateral", "tetrahedron"]))
def test_the_numbering_of_a_sound_mesh_says_nothing(seed, shape):
    """Nodes of a cell in another order: the same body, and no message."""
    mesh = SOUND[shape].mesh()
    generator = np.random.default_rng(seed)
    if shape == "quadrilateral":
        turned = np.where(generator.random(mesh.nelements) < 0.5, mesh.t, mesh.t[::-1])
    else:
        turned = generator.permuted(mesh.t, axis=0)
    again = type(mesh)(mesh.p, turned)
    check_mesh(again, "file")
    assert scaled_jacobian(again) == pytest.approx(scaled_jacobian(mesh), abs=1e-12)


@pytest.mark.parametrize("shape", SOUND)
def test_what_else_is_wrong_is_named(shape):
    assert "without volume" in broken(
        shape, lambda p, t: (p, np.where(np.arange(t.shape[1]) == t.shape[1] // 2, t[:1, :], t))
    )
    if shape in ("triangle", "tetrahedron"):  # flattened; a box of cells only becomes thin
        assert "cells 0, 1, 2, 3, 4, ..." in broken(shape, lambda p, t: (np.vstack([p[:-1], 1e-9 * p[-1:]]), t))
    alone = broken(shape, lambda p, t: (np.hstack([p, np.full((len(p), 1), 5.0)]), t))
    assert f"node {SOUND[shape].mesh().p.shape[1]} (1 of" in alone
    assert "is in no cell" in alone

    def split(p, t):  # a cell inside gets a corner of its own
        cell = t.shape[1] // 2
        extra = p[:, [t[0, cell]]]
        t[0, cell] = p.shape[1]
        return np.hstack([p, extra]), t

    assert "at the same place as another" in broken(shape, split)

    def stack(p, t):
        return p, np.hstack([t, t[:, :1], t[:, :1]])

    assert "stacked: more than two share a facet" in broken(shape, stack)

    def infinite(p, t):
        p[0, 3] = np.nan

    assert "node 3 (1 of" in broken(shape, infinite)


def test_scaled_jacobian_is_one_for_the_regular_cell_and_small_for_a_flat_one():
    triangle = skfem.MeshTri(np.array([[0.0, 1.0, 0.5], [0.0, 0.0, np.sqrt(0.75)]]), np.array([[0], [1], [2]]))
    assert scaled_jacobian(triangle) == pytest.approx([1.0], rel=1e-14)
    corners = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]).T
    assert scaled_jacobian(skfem.MeshTet(corners, np.arange(4)[:, None])) == pytest.approx([1.0], rel=1e-14)
    assert scaled_jacobian(skfem.MeshHex()) == pytest.approx([1.0])
    sheared = skfem.MeshQuad(np.array([[0.0, 1.0, 2.0, 1.0], [0.0, 0.0, 1.0, 1.0]]), np.arange(4)[:, None])
    assert scaled_jacobian(sheared) == pytest.approx([np.sqrt(0.5)], rel=1e-14)


def test_curved_cells_are_refused():
    with pytest.raises(ParameterError, match="is a MeshTri2; expected straight-sided cells"):
        check_mesh(skfem.MeshTri2(), "mesh")
