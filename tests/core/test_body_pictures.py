"""Pictures of bodies: what is coloured lies where the body is, in the colours that the bar explains."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.image import imread

import myobridge as mb
from myobridge.bodies import choose_field, choose_states, draw_body, nodal_means, skin
from myobridge.bodies.skin import lattice
from myobridge.bodies.surface import polylines, surface
from myobridge.vtkhdf import CELL_TYPES

DEEP = ("tetra", "tetra10", "hexahedron", "hexahedron27")
ENGINES = [
    "matplotlib",
    pytest.param(
        "pyvista",
        marks=pytest.mark.skipif(importlib.util.find_spec("pyvista") is None, reason="pyvista is the extra 'viz'"),
    ),
]


@pytest.fixture
def figure_of(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """Draw into a PNG; return its pixels (rows from below) and the figure that was written."""

    def draw(result: mb.Result, **options: Any) -> tuple[np.ndarray, Figure]:
        found: list[Figure] = []
        real = Figure.savefig

        def keep(figure: Figure, *arguments: Any, **keywords: Any) -> None:
            found.append(figure)
            real(figure, *arguments, **keywords)

        monkeypatch.setattr(Figure, "savefig", keep)
        draw_body(result, tmp_path / "picture.png", **options)
        monkeypatch.setattr(Figure, "savefig", real)
        return imread(tmp_path / "picture.png")[::-1, :, :3], found[0]

    return draw


def panel(pixels: np.ndarray, figure: Figure, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels of a panel, and the coordinates [mm] of its columns and rows."""
    axis = figure.axes[number]
    box = axis.get_window_extent()
    scale = 120.0 / figure.dpi
    left, right, bottom, top = (round(scale * edge) for edge in (box.x0, box.x1, box.y0, box.y1))
    cut = pixels[bottom + 2 : top - 2, left + 2 : right - 2]
    x0, x1, y0, y1 = *axis.get_xlim(), *axis.get_ylim()
    rows = y0 + (np.arange(bottom + 2, top - 2) + 0.5 - bottom) / (top - bottom) * (y1 - y0)
    columns = x0 + (np.arange(left + 2, right - 2) + 0.5 - left) / (right - left) * (x1 - x0)
    return cut, columns, rows


def coloured(cut: np.ndarray) -> np.ndarray:
    """Where a picture is neither white nor grey."""
    return np.ptp(cut, axis=2) > 0.15


# ---------------------------------------------------------------------- geometry


@pytest.mark.parametrize("kind", DEEP)
def test_the_skin_is_closed_and_looks_outwards(kind: str, bending) -> None:
    mesh = bending(kind, counts=(3, 2, 2)).mesh
    seen = skin(mesh)
    squares = 2 * (3 * 2 + 3 * 2 + 2 * 2)
    assert len(seen.faces) == squares * (2 if "tetra" in kind else 1)
    assert len(seen.border()) == 0
    body = surface(mesh, seen, mesh.points, np.zeros(len(mesh.points)), 3, on_cells=False, flat=False)
    place = body.points[body.triangles]
    normals = np.cross(place[:, 1] - place[:, 0], place[:, 2] - place[:, 0]) / 2.0
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-15)
    # Gauss: the flux of the place through the skin is three times the volume.
    volume = np.sum(place.mean(axis=1) * normals) / 3.0
    assert volume == pytest.approx(0.1 * 0.02 * 0.02, rel=1e-12)
    assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(2 * (0.1 * 0.02 * 2 + 0.02**2), rel=1e-12)


@pytest.mark.parametrize("kind", [kind for kind in CELL_TYPES if kind[-1].isdigit()])
def test_refined_faces_follow_the_curve(kind: str, bending) -> None:
    """The map is quadratic, so that quadratic faces and edges are the exact images of straight ones."""
    body = bending(kind)
    seen = skin(body.mesh)
    straight, bent = body.mesh.points, body.moved(body.mesh.points, 1.0)
    nothing = np.zeros(len(straight))
    for n in (1, 4):
        one, other = (
            surface(body.mesh, seen, place, nothing, n, on_cells=False, flat=False).points for place in (straight, bent)
        )
        np.testing.assert_allclose(other, body.moved(one, 1.0), atol=1e-15)
        np.testing.assert_allclose(
            polylines(seen, bent, n).reshape(-1, 3),
            body.moved(polylines(seen, straight, n).reshape(-1, 3), 1.0),
            atol=1e-15,
        )


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad", "quad9"])
def test_a_lattice_covers_its_face_once(kind: str) -> None:
    for n in (1, 2, 5):
        grid = lattice(kind, n)
        np.testing.assert_allclose(grid.shape.sum(axis=1), 1.0, atol=1e-14)
        corners = np.array([(0, 0), (1, 0), (0, 1)] if "triangle" in kind else [(0, 0), (1, 0), (1, 1), (0, 1)], float)
        nodes = corners
        if kind[-1].isdigit():
            nodes = np.concatenate([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
        if kind == "quad9":
            nodes = np.concatenate([nodes, [[0.5, 0.5]]])
        x, y = (grid.shape @ nodes)[grid.triangles].transpose(2, 0, 1)
        areas = ((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])) / 2
        assert areas.min() > 0.0
        assert areas.sum() == pytest.approx(0.5 if "triangle" in kind else 1.0, rel=1e-12)
        for row, (start, end) in zip(grid.edges, zip(corners, np.roll(corners, -1, axis=0), strict=True), strict=True):
            expected = start + np.linspace(0, 1, n + 1)[:, None] * (end - start)
            np.testing.assert_allclose((grid.shape @ nodes)[row], expected, atol=1e-14)


def test_borders_and_creases(bending) -> None:
    flat = bending("triangle6").mesh
    assert len(skin(flat).border()) == 2 * (4 + 2)
    deep = bending("tetra10").mesh
    assert len(skin(deep).creases(deep.points)) == 4 * (4 + 2 + 2)


def test_means_at_nodes_leave_out_what_is_not_there(bending) -> None:
    mesh = bending("quad", counts=(3, 1, 0)).mesh
    found = nodal_means(mesh, np.array([1.0, 2.0, np.nan]))
    expected = {0.0: 1.0, 1.0: 1.5, 2.0: 2.0, 3.0: np.nan}
    for point, value in zip(mesh.points, found, strict=True):
        np.testing.assert_equal(value, expected[float(round(3 * point[0] / 0.1))])


# ---------------------------------------------------------------------- pictures


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad9"])
def test_a_flat_body_is_coloured_where_it_is(kind: str, moving, bending, figure_of) -> None:
    body = bending(kind)
    pixels, figure = figure_of(moving(kind).to(1.0), field="stretch", states="first,last", edges=False)
    for number, time in ((0, 0.0), (1, 1.0)):
        cut, columns, rows = panel(pixels, figure, number)
        # The bent body lies between 2 x^2 and 2 x^2 + 20 mm; straight edges of linear cells cut the corners of it.
        x, y = np.meshgrid(columns, rows)
        inside = (x > 0.0) & (x < 100.0) & (y > 2e-3 * time * x**2) & (y < 2e-3 * time * x**2 + 20.0)
        painted = coloured(cut) | ((cut.max(axis=2) < 0.6) & (np.ptp(cut, axis=2) > 0.05))
        area = (columns[1] - columns[0]) * (rows[1] - rows[0])
        assert np.sum(inside) * area == pytest.approx(0.1 * 0.02 * 1e6, rel=0.02)
        assert np.mean(painted[inside]) > (0.98 if kind[-1].isdigit() else 0.93)
        assert np.mean(painted[~inside]) < 0.02
    assert np.ptp(body.moved(body.mesh.points, 1.0)[:, 1]) > 0.03, "it must have moved"


@pytest.mark.parametrize("per_cell", [False, True])
def test_colours_are_those_of_the_bar(per_cell: bool, moving, bending, figure_of) -> None:
    result = moving("quad9").to(1.0)
    pixels, figure = figure_of(result, field="stretch", states="last", edges=False, per_cell=per_cell)
    cut, columns, rows = panel(pixels, figure, 0)
    values = result.fields[-1]["stretch"]
    low, high = values.min(), values.max()
    assert figure.axes[-1].get_ylim() == pytest.approx((low, high))
    assert figure.axes[-1].get_ylabel() == "stretch [-]"
    centres = bending("quad9").moved(bending("quad9").centres(), 1.0) * 1e3
    for (x, y, _), value in zip(centres, values, strict=True):
        row, column = np.argmin(np.abs(rows - y)), np.argmin(np.abs(columns - x))
        smooth = 0.0 if per_cell else 0.12
        close = colormaps["viridis"](np.clip((value - low) / (high - low) + np.array([-smooth, smooth]), 0, 1))[:, :3]
        assert np.all(cut[row, column] > close.min(axis=0) - 0.03), (x, y)
        assert np.all(cut[row, column] < close.max(axis=0) + 0.03), (x, y)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
def test_a_body_in_space_is_coloured_where_it_is(kind: str, engine: str, moving, bending, figure_of) -> None:
    """Seen from the side, a body that bends is the same strip as a flat one."""
    result = moving(kind, counts=(8, 2, 2)).to(1.0)
    pixels, figure = figure_of(result, field="stretch", states=2, edges=False, view=(-90.0, 0.0), engine=engine)
    for number, time in ((0, 0.0), (1, 1.0)):
        cut, columns, rows = panel(pixels, figure, number)
        x, z = np.meshgrid(columns, rows)
        inside = (x > 0.0) & (x < 100.0) & (z > 1e-3 * time * x**2) & (z < 1e-3 * time * x**2 + 20.0)
        assert np.mean(coloured(cut)[inside]) > 0.9
        assert np.mean(coloured(cut)[~inside]) < 0.02


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("turned", [False, True])
def test_what_is_in_front_hides_what_is_behind(turned: bool, engine: str, moving, bending, figure_of) -> None:
    """Two blocks, one behind the other; the second has no sites and is grey."""
    block = bending("hexahedron", counts=(3, 1, 1)).mesh
    behind = block.points + np.array([0.0, -0.05 if turned else 0.05, 0.0])
    cells = np.concatenate([block.cells, block.cells + len(block.points)])
    pair = block._replace(points=np.concatenate([block.points, behind]), cells=cells)
    result = moving("hexahedron", mesh=pair, empty_cells=3, bend=0.0).to(0.5)
    pixels, figure = figure_of(result, field="stretch", states="last", edges=False, view=(-90.0, 0.0), engine=engine)
    cut, columns, rows = panel(pixels, figure, 0)
    inside = cut[np.abs(rows - 10.0) < 9.0][:, np.abs(columns - 50.0) < 49.0]
    assert np.mean(coloured(inside)) == pytest.approx(0.0 if turned else 1.0, abs=0.02)
    assert inside.max() < 0.95, "a body, and no paper"


def test_cells_without_sites_are_grey(moving, figure_of) -> None:
    pixels, figure = figure_of(moving("quad", empty_cells=2, bend=0.0).to(0.5), states="last", edges=False)
    cut, columns, rows = panel(pixels, figure, 0)
    assert figure.axes[-1].get_ylabel() == "tension [kPa]", "the tension is what one wants to see first"
    row = np.argmin(np.abs(rows - 5.0))
    np.testing.assert_allclose(cut[row, np.argmin(np.abs(columns - 87.0))], 0.8, atol=0.01)
    assert coloured(cut)[row, np.argmin(np.abs(columns - 30.0))]


def test_the_undeformed_outline_is_there(moving, figure_of) -> None:
    pixels, figure = figure_of(moving("triangle6").to(1.0), states="last", edges=False)
    cut, columns, rows = panel(pixels, figure, 0)
    there = np.argmin(np.abs(columns - 100.0))
    beside = (rows > -0.5) & (rows < 19.0)  # the right end stood here, and has moved up by 20 mm
    darkest = cut[beside, there - 2 : there + 3].mean(axis=2).min(axis=1)
    assert 0.3 < np.mean(darkest < 0.9) < 0.9, "dashed"


def test_edges_are_drawn_where_they_are_few(moving, figure_of) -> None:
    def darkness(**options: Any) -> float:
        pixels, figure = figure_of(moving("triangle6", bend=0.0).to(0.5), states="last", field="stretch", **options)
        return float(np.mean(panel(pixels, figure, 0)[0]))

    assert darkness(edges=True) == darkness() < darkness(edges=False) - 1e-3


def test_states_and_layout(moving, figure_of) -> None:
    result = moving("triangle6").to(1.0)
    _, figure = figure_of(result)
    assert [axis.get_title() for axis in figure.axes[:-1]] == ["0 s", "0.35 s", "0.65 s", "1 s"]
    limits = {(axis.get_xlim(), axis.get_ylim()) for axis in figure.axes[:-1]}
    assert len(limits) == 1, "one scale for all"


# ---------------------------------------------------------------------- what is asked for


def test_states_are_chosen(moving) -> None:
    states = moving("triangle").to(1.0).fields

    def steps(wanted: str | int) -> list[int]:
        return [state.step for state in choose_states(states, wanted)]

    assert steps("") == [0, 7, 13, 20]
    assert steps(2) == [0, 20]
    assert steps("1") == [20]
    assert steps("100") == list(range(21))
    assert steps("first, 0.4,last") == [0, 8, 20]
    assert steps("0.4000001") == [8]
    scales = [attrs.evolve(state, label="scale") for state in states]
    assert choose_states(scales, "0.4,0.8")[1].time == pytest.approx(0.8)


@pytest.mark.parametrize(
    ("wanted", "says"),
    [
        ("0.42", r"no state at this time\. Kept: 0, 0\.05, .*Did you mean 0\.4\?"),
        ("7.0", r"Did you mean 1\?"),
        ("nan", "no state"),
        ("frist", r"a number of states, or a list of times, 'first' and 'last'.*Did you mean 'first'\?"),
        ("0", None),
        ("0.4,,", "a number of states"),
    ],
)
def test_a_state_that_is_not_there(wanted: str, says: str | None, moving) -> None:
    states = moving("triangle").to(1.0).fields
    if says is None:
        assert choose_states(states, wanted)[0].step == 0
        return
    with pytest.raises(mb.MyobridgeError, match=says):
        choose_states(states, wanted)


def test_fields_are_chosen(moving) -> None:
    states = moving("tetra10", empty_cells=3).to(1.0).fields[::10]
    assert choose_field(states).name == "tension"
    assert choose_field(states, "tension").limits[1] == pytest.approx(
        1e-3 * np.nanmax([state["tension"] for state in states])
    )
    length = choose_field(states, "displacement")
    assert (length.label, length.on_cells) == ("displacement [mm]", False)
    np.testing.assert_allclose(length.values[-1], 1e3 * np.linalg.norm(states[-1]["displacement"], axis=1))
    assert choose_field(states, "displacement_z").values[-1].max() == pytest.approx(10.0)
    constant = choose_field(states, "J")
    assert constant.limits[0] < 1.0 < constant.limits[1], "what is the same everywhere is not magnified"
    with pytest.raises(mb.MyobridgeError, match=r"--field tensoin: .*no such field.*Did you mean 'tension'\?"):
        choose_field(states, "tensoin")
    with pytest.raises(mb.MyobridgeError, match=r"no such field"):
        choose_field(states, "tension_x")


def test_a_pressure_of_both_signs_has_its_zero_in_the_middle(moving) -> None:
    states = moving("triangle6").to(0.1).fields
    flipped = [
        attrs.evolve(state, at_nodes={**state.at_nodes, "pressure": state["pressure"] - 10.0}) for state in states
    ]
    found = choose_field(flipped, "pressure")
    assert found.colours == "coolwarm"
    assert found.limits[0] == -found.limits[1] < 0.0
    assert choose_field(states, "pressure").colours == "viridis"


def test_the_command_line_draws_the_body_or_the_curves(cli, moving, scenes, write, tmp_path: Path) -> None:
    moving("tetra10", output=tmp_path / "body.h5").to(0.2)
    arguments = ("show", "body.h5", "--engine", "matplotlib")
    assert cli(*arguments, "-o", "body.png", "--field", "stretch", "--states", "first,0.1", "--cells").code == 0
    assert cli(*arguments, "-o", "turned.png", "--view=30,-20", "--no-edges").code == 0
    assert cli("show", "body.h5", "-o", "curves.png", "--series").code == 0
    shapes = {name: imread(tmp_path / f"{name}.png").shape for name in ("body", "turned", "curves")}
    assert len(set(shapes.values())) == 3
    for options, says in (
        (("--field", "tensoin"), "Did you mean 'tension'?"),
        (("--states", "0.123"), "there is no state at this time"),
        (("--engine", "pyvsita"), "Did you mean 'pyvista'?"),
        (("--view", "up"), "expected azimuth and elevation"),
        (("--series", "--field", "tension"), "--field is for a body"),
        (("-o", "picture.docx"), "picture.docx: the picture cannot be written"),
    ):
        outcome = cli("show", "body.h5", *options)
        assert outcome.code == 2
        assert says in outcome.err
    cli("run", write(scenes["clamp"]), "-q")
    outcome = cli("show", "scene.h5", "--field", "tension")
    assert (outcome.code, "no body to draw" in outcome.err) == (2, True)


def test_without_pyvista_it_says_so(moving, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(mb.MyobridgeError, match=r"pyvista: is not installed; pip install 'myobridge\[viz\]'"):
        draw_body(moving("tetra").to(0.1), tmp_path / "picture.png", engine="pyvista")
    draw_body(moving("tetra").to(0.1), tmp_path / "picture.png", states="last")
    assert imread(tmp_path / "picture.png").std() > 0.05
