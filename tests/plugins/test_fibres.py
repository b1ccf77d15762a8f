"""Fields of fibre directions: closed forms, convergence, errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import skfem
from hypothesis import given
from hypothesis import strategies as st

from myobridge.errors import ParameterError
from myobridge_plugins.fibres import laplace
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.fibres.harmonic import Harmonic
from myobridge_plugins.fibres.table import Table
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.mesh.fusiform import Fusiform
from myobridge_plugins.mesh.spindle import Spindle

BLOCKS = {
    "triangle": Block(size=(0.1, 0.03), cells=(6, 3)),
    "quadrilateral": Block(size=(0.1, 0.03), cells=(6, 3), shape="quadrilateral"),
    "tetrahedron": Block(size=(0.1, 0.03, 0.02), cells=(5, 2, 2)),
    "hexahedron": Block(size=(0.1, 0.03, 0.02), cells=(5, 2, 2), shape="hexahedron"),
}


def inside(mesh, count=4):
    corners = mesh.elem.refdom.p
    return corners @ np.random.default_rng(1).dirichlet(np.ones(corners.shape[1]), count).T


def places(mesh, points):
    return np.moveaxis(mesh.mapping().F(points), 0, -1)


@given(
    direction=st.lists(st.floats(-1e200, 1e200), min_size=2, max_size=2).filter(
        lambda n: any(abs(x) > 1e-200 for x in n)
    )
)
def test_a_constant_direction_is_normalised(direction):
    mesh = skfem.MeshTri()
    found = Constant(direction=direction).directions(mesh, inside(mesh))
    assert found.shape == (2, 4, 2)
    assert np.linalg.norm(found, axis=2) == pytest.approx(1.0, abs=1e-15)
    larger = np.argmax(np.abs(direction))
    assert np.all(np.sign(found[..., larger]) == np.sign(direction[larger]))


def test_a_constant_direction_fits_the_mesh():
    mesh = skfem.MeshTet()
    assert np.all(Constant().directions(mesh, inside(mesh)) == [1.0, 0.0, 0.0])
    with pytest.raises(ParameterError, match="direction: has 2 numbers; the mesh has 3 dimensions"):
        Constant(direction=(1.0, 0.0)).directions(mesh, inside(mesh))
    for wrong in ((0.0, 0.0), 1.0, (1.0,)):
        with pytest.raises(ParameterError, match="expected 2 or 3 numbers, not all of them 0"):
            Constant(direction=wrong)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", BLOCKS)
def test_harmonic_fibres_of_a_block_are_parallel(shape, order):
    mesh = BLOCKS[shape].mesh()
    found = Harmonic(start="bottom", end="top", order=order).directions(mesh, inside(mesh))
    expected = np.eye(mesh.dim())[-1]
    assert np.abs(found - expected).max() < 1e-12


def annulus(cells: int, shape: str):
    """Quarter of a ring, 1 < r < 2; left is at angle 0, right at a quarter turn, bottom inside, top outside."""
    mesh = Block(size=(1.0, 1.0), cells=(cells, cells), shape=shape).mesh()
    # Distorted inside, or its symmetry would make the directions exact.
    bump = 0.08 * np.sin(np.pi * mesh.p[0]) * np.sin(np.pi * mesh.p[1])
    angle, radius = 0.5 * np.pi * (mesh.p[0] + bump), 1.0 + mesh.p[1] - bump
    return replace(mesh, doflocs=radius * np.stack([np.cos(angle), np.sin(angle)]))


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
@pytest.mark.parametrize(
    ("start", "end", "turn", "order", "rate"),
    [
        ("left", "right", [[0.0, -1.0], [1.0, 0.0]], 1, 1.0),
        ("left", "right", [[0.0, -1.0], [1.0, 0.0]], 2, 2.0),
        ("bottom", "top", [[1.0, 0.0], [0.0, 1.0]], 1, 1.0),
        ("bottom", "top", [[1.0, 0.0], [0.0, 1.0]], 2, 1.5),  # straight edges where the potential is given on a circle
    ],
)
def test_fibres_of_a_ring_are_circles_or_rays(start, end, turn, order, rate, shape):
    """The potential is the angle, or the logarithm of the radius."""
    errors = []
    for cells in (8, 16, 32):
        mesh = annulus(cells, shape)
        points = inside(mesh, 6)
        place = places(mesh, points)
        exact = place @ np.transpose(turn) / np.linalg.norm(place, axis=2, keepdims=True)
        found = Harmonic(start=start, end=end, order=order).directions(mesh, points)
        errors.append(np.sqrt(np.mean(np.sum((found - exact) ** 2, axis=2))))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert rates == pytest.approx([rate, rate], abs=0.15), f"observed rates {rates} of the direction, errors {errors}"


def test_harmonic_fibres_of_a_spindle_follow_its_outline():
    mesh = Spindle(cells=40, refinements=1).mesh()
    points = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]])  # middles of the edges of each triangle
    found = Harmonic(start="left", end="right").directions(mesh, points)
    edge = mesh.boundaries["top"]
    cells = mesh.f2t[0, edge]
    which = np.argmax(mesh.t2f[:, cells] == edge, axis=0)
    ends = mesh.p[:, mesh.facets[:, edge]]
    order = np.argsort(ends[0], axis=0)
    ends = np.take_along_axis(ends, order[None], axis=1)
    along = (ends[:, 1] - ends[:, 0]).T
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The middle of facet k of a triangle is point k: edges (0, 1), (1, 2), (0, 2).
    there = found[cells, which]
    assert np.abs(along[:, 1]).max() > 0.25
    assert np.linalg.norm(there - along, axis=1).max() < 0.02
    assert found[..., 0].min() > 0.9


def test_large_bodies_are_solved_by_multigrid_to_the_same_end(monkeypatch):
    mesh = Fusiform(across=2).mesh()
    points = inside(mesh, 2)
    direct = Harmonic(start="left", end="right").directions(mesh, points)
    monkeypatch.setattr(laplace, "_LARGE", 10)
    by_multigrid = Harmonic(start="left", end="right").directions(mesh, points)
    assert np.abs(by_multigrid - direct).max() < 1e-9
    assert not np.array_equal(by_multigrid, direct)


def test_harmonic_fibres_say_why_there_are_none():
    mesh = Spindle(cells=4).mesh()
    with pytest.raises(
        ParameterError, match=r"start: .* 'lift'\. Allowed: bottom, left, right, top\. Did you mean 'left'"
    ):
        Harmonic(start="lift", end="right").directions(mesh, inside(mesh))
    with pytest.raises(ParameterError, match="end: 'top' and 'left' share 1 nodes"):
        Harmonic(start="left", end="top").directions(mesh, inside(mesh))
    # Two bodies side by side: what touches one boundary, or none, has no direction.
    one = Block(size=(1.0, 1.0), cells=(1, 1), shape="quadrilateral").mesh()
    two = one + one.translated((2.0, 0.0)) + one.translated((4.0, 0.0))
    named = two.with_boundaries({"low": lambda x: x[0] == 0.0, "high": lambda x: x[0] == 3.0})
    with pytest.raises(ParameterError, match=r"where the potential is level: cells 0, 1, 2 \(3 of 3\) are such"):
        Harmonic(start="low", end="high").directions(named, inside(named))
    named = two.with_boundaries({"low": lambda x: x[0] == 0.0, "high": lambda x: x[0] == 1.0})
    with pytest.raises(ParameterError, match=r"cells 1, 2 \(2 of 3\) are such"):
        Harmonic(start="low", end="high").directions(named, inside(named))


def test_a_table_gives_one_direction_a_cell(tmp_path):
    mesh = BLOCKS["triangle"].mesh()
    given_ = np.random.default_rng(0).normal(size=(mesh.nelements, 2))
    np.savetxt(tmp_path / "cells.csv", given_, delimiter=", ", header="x, y")
    np.savez(tmp_path / "cells.npz", directions=given_)
    expected = given_ / np.linalg.norm(given_, axis=1, keepdims=True)
    for name in ("cells.csv", "cells.npz"):
        found = Table(file=str(tmp_path / name)).directions(mesh, inside(mesh, 3))
        assert found == pytest.approx(np.repeat(expected[:, None], 3, axis=1), abs=1e-15)


def test_a_table_of_places_gives_that_of_the_nearest(tmp_path):
    mesh = BLOCKS["tetrahedron"].mesh()
    generator = np.random.default_rng(0)
    spots = generator.uniform(0.0, 1.0, (30, 3)) * [100.0, 30.0, 20.0]  # [mm]
    units = generator.normal(size=(30, 3))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    np.savetxt(tmp_path / "spots.txt", np.hstack([spots, 3.0 * units]))
    np.savez(tmp_path / "spots.npz", positions=spots, directions=units)
    points = inside(mesh)
    distance = np.linalg.norm(places(mesh, points)[:, :, None] - 1e-3 * spots, axis=3)
    for name in ("spots.txt", "spots.npz"):
        found = Table(file=str(tmp_path / name), scale=1e-3).directions(mesh, points)
        assert found == pytest.approx(units[distance.argmin(axis=2)], abs=1e-14)
    assert len(np.unique(distance.argmin(axis=2))) > 10


def test_a_table_says_what_is_wrong(tmp_path):
    mesh = skfem.MeshTri()

    def said(content: str) -> str:
        (tmp_path / "a.txt").write_text(content)
        with pytest.raises(ParameterError) as caught:
            Table(file=str(tmp_path / "a.txt")).directions(mesh, inside(mesh))
        assert caught.value.key == "file"
        return str(caught.value)

    assert "has 3 columns; the mesh has 2 dimensions: 2 or 4" in said("1 0 0\n0 1 0\n")
    assert "has 3 rows; the mesh has 2 cells" in said("1 0\n0 1\n1 1\n")
    assert "row 1 (counted from 0) is a direction of no length" in said("1 0\n0 0\n")
    assert "row 0 (counted from 0) is not finite" in said("nan 0\n0 1\n")
    assert "is no table of numbers" in said("1 0\n0 up\n")
    assert "it is empty" in said("# nothing\n")
    assert "expected rows of 2 or 3 numbers" in said("1\n2\n")
    with pytest.raises(ParameterError, match=r"does not exist\. Allowed: a\.txt\. Did you mean 'a\.txt'"):
        Table(file=str(tmp_path / "b.txt"))
    np.savez(tmp_path / "wrong.npz", fibres=np.ones((2, 2)))
    with pytest.raises(ParameterError, match="holds no 'directions', but fibres"):
        Table(file=str(tmp_path / "wrong.npz"))
