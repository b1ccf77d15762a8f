"""The result of a body is a file that VTK's own reader opens: time steps, fields, geometry, volumes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import myobridge as mb
from myobridge.field_recording import MOST_STATES, stride
from myobridge.plan import Plan
from myobridge.run import start
from myobridge.vtkhdf import CELL_TYPES

vtk_hdf = pytest.importorskip("vtkmodules.vtkIOHDF", reason="VTK's reader comes with the extra 'test' or 'viz'")


class Read:
    """What VTK's reader finds in a file."""

    def __init__(self, path: Path) -> None:
        from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

        self.reader = vtk_hdf.vtkHDFReader()
        assert self.reader.CanReadFile(str(path)) == 1
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        self.times = list(self.reader.GetOutputInformation(0).Get(key))

    def grid(self, time: float) -> Any:
        """Unstructured grid at a time."""
        self.reader.UpdateTimeStep(time)
        return self.reader.GetOutput()


def arrays(data: Any) -> dict[str, np.ndarray]:
    """Arrays of a grid's point or cell data, by name."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return {data.GetArrayName(i): np.array(vtk_to_numpy(data.GetArray(i))) for i in range(data.GetNumberOfArrays())}


def volumes(grid: Any, displacement: np.ndarray) -> np.ndarray:
    """Measure of each deformed cell, by VTK's own shape functions at Gauss points."""
    flat = grid.GetCell(0).GetCellDimension() == 2
    simplex = grid.GetCell(0).GetNumberOfFaces() == 4 or (flat and grid.GetCell(0).GetNumberOfEdges() == 3)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    axes = np.meshgrid(*[nodes] * (2 if flat else 3), indexing="ij")
    weight = np.prod(np.meshgrid(*[weights] * (2 if flat else 3), indexing="ij"), axis=0).ravel()
    points = np.stack([axis.ravel() for axis in axes], axis=1)
    if simplex:  # collapsed coordinates: the product rule of the square, carried to the triangle
        rest = np.ones(len(points))
        for column in range(points.shape[1]):
            points[:, column] *= rest
            if column < points.shape[1] - 1:
                weight = weight * (rest - points[:, column])
            rest = rest - points[:, column]
    found = []
    for number in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(number)
        ids = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
        place = np.array([grid.GetPoint(i) for i in ids]) + displacement[ids]
        total = 0.0
        for point, factor in zip(points, weight, strict=True):
            slopes = [0.0] * ((2 if flat else 3) * len(ids))
            cell.InterpolateDerivs([*point, 0.0][:3], slopes)
            jacobian = np.reshape(slopes, (-1, len(ids))) @ place[:, : 2 if flat else 3]
            total += factor * np.linalg.det(jacobian)
        found.append(total)
    return np.array(found)


@pytest.mark.parametrize("kind", sorted(CELL_TYPES))
def test_vtk_reads_what_was_recorded(kind: str, moving, tmp_path: Path) -> None:
    result = moving(kind, output=tmp_path / "body.h5").to(1.0)
    read = Read(tmp_path / "body.h5")
    assert read.times == [state.time for state in result.fields]
    np.testing.assert_allclose(read.times, np.arange(21) * 0.05, atol=1e-14)
    for state in result.fields[::4]:
        grid = read.grid(state.time)
        assert grid.GetCellType(0) == CELL_TYPES[kind]
        nodal, on_cells = arrays(grid.GetPointData()), arrays(grid.GetCellData())
        assert set(nodal) == {"displacement", "pressure"} == set(state.at_nodes)
        assert set(on_cells) == {"stretch", "tension", "activation", "fibre", "J"} == set(state.on_cells)
        for name, array in {**nodal, **on_cells}.items():
            np.testing.assert_array_equal(array, state[name], err_msg=name, strict=True)
    assert np.ptp(result.fields[-1]["displacement"]) > 0.01, "it must have moved"
    assert np.ptp([state["tension"].mean() for state in result.fields]) > 1e3


@pytest.mark.parametrize("kind", sorted(CELL_TYPES))
def test_vtk_sees_the_same_deformed_cells(kind: str, moving, bending, tmp_path: Path) -> None:
    """The map keeps volumes, and quadratic cells hold it exactly: nodes in another order would not."""
    moving(kind, output=tmp_path / "body.h5").to(1.0)
    read = Read(tmp_path / "body.h5")
    body = bending(kind)
    whole = np.prod([side for side in np.ptp(body.mesh.points, axis=0) if side > 0.0])
    for time in (0.0, read.times[-1]):
        grid = read.grid(time)
        points = np.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())])
        displacement = arrays(grid.GetPointData())["displacement"]
        np.testing.assert_allclose(points + displacement, body.moved(body.mesh.points, time), atol=1e-15)
        found = volumes(grid, displacement)
        if kind[-1].isdigit() or time == 0.0:
            np.testing.assert_allclose(found, whole / len(found), rtol=1e-10)
        assert found.sum() == pytest.approx(whole, rel=0.05)


def test_what_the_scene_has_not_is_not_written(moving) -> None:
    passive = moving("triangle6", model=None).to(0.2).fields[-1]
    assert set(passive.names) == {"displacement", "pressure", "stretch", "fibre", "J"}
    full = moving("triangle6", ramp=False).to(0.2).fields[-1]
    assert set(full.names) == {"displacement", "pressure", "stretch", "tension", "fibre", "J"}


def test_cells_without_sites_are_not_a_number(moving, tmp_path: Path) -> None:
    result = moving("tetra10", empty_cells=5, output=tmp_path / "body.h5").to(0.2)
    tension = result.fields[-1]["tension"]
    assert np.isnan(tension[-5:]).all()
    assert np.isfinite(tension[:-5]).all()
    read = Read(tmp_path / "body.h5")
    np.testing.assert_array_equal(arrays(read.grid(read.times[-1]).GetCellData())["tension"], tension)


def test_what_does_not_change_is_kept_once(moving, tmp_path: Path) -> None:
    result = moving("triangle6", output=tmp_path / "body.h5").to(1.0)
    n_cells = len(result.mesh.cells)
    again = mb.Result.load(tmp_path / "body.h5")
    with h5py.File(tmp_path / "body.h5") as opened:
        file: Any = opened
        assert file["VTKHDF/CellData/fibre"].shape == (n_cells, 3)
        assert file["VTKHDF/CellData/stretch"].shape == (21 * n_cells,)
        # Full activation is reached at 0.5 s, and from then on nothing changes.
        levels = {state["activation"][0] for state in result.fields}
        assert 10 < len(levels) < 14
        assert file["VTKHDF/CellData/activation"].shape == (len(levels) * n_cells,)
        assert file["VTKHDF/Points"].shape == result.mesh.points.shape
    for held in (result, again):
        assert held.fields[0]["fibre"] is held.fields[-1]["fibre"]
        assert held.fields[0]["activation"][0] == pytest.approx(0.2)
        assert held.fields[-1]["activation"][0] == 1.0


def assert_same_states(one: mb.Result, other: mb.Result) -> None:
    """Same mesh, times and fields, bit by bit."""
    np.testing.assert_array_equal(one.mesh.points, other.mesh.points)
    np.testing.assert_array_equal(one.mesh.cells, other.mesh.cells)
    assert one.mesh.kind == other.mesh.kind
    key = [(state.time, state.step, state.label, state.names) for state in one.fields]
    assert key == [(state.time, state.step, state.label, state.names) for state in other.fields]
    for left, right in zip(one.fields, other.fields, strict=True):
        for name in left.names:
            np.testing.assert_array_equal(left[name], right[name], err_msg=name, strict=True)


def test_a_loaded_result_is_the_saved_one(moving, tmp_path: Path) -> None:
    result = moving("quad9", {"fields_every": 7}, output=tmp_path / "body.h5").to(1.0)
    assert [state.step for state in result.fields] == [0, 7, 14, 20]
    again = mb.Result.load(tmp_path / "body.h5")
    assert_same_states(result, again)
    with pytest.raises(mb.MyobridgeError, match=r"no field 'tensoin'.*Did you mean 'tension'\?"):
        again.fields[0]["tensoin"]


def test_states_are_kept_at_chosen_times(moving) -> None:
    """Steps of 0.05 s end at 0.33 s too; no others are kept unless they are asked for."""
    result = moving("triangle", {"fields_at": [0.33, 0.5], "fields": ["tension"]}).to(1.0)
    assert [state.time for state in result.fields] == [0.0, 0.33, 0.5, 1.0]
    both = moving("triangle", {"fields_at": [0.33], "fields_every": 8, "fields": ["tension"]}).to(1.0)
    assert [state.time for state in both.fields] == pytest.approx([0.0, 0.33, 0.35, 0.75, 1.0])


@pytest.mark.parametrize("cut", [0.2, 0.45])
def test_a_resumed_run_has_the_chosen_times(cut: float, moving, tmp_path: Path) -> None:
    record = {"fields_at": [0.33, 0.5], "fields": ["tension"]}
    whole = moving("triangle", record).to(1.0)
    moving("triangle", record, output=tmp_path / "part.h5").to(1.0, until=cut)
    left = mb.Result.load(tmp_path / "part.h5")
    continued = moving("triangle", record, output=tmp_path / "part.h5")
    left.checkpoint.restore(continued.simulation)
    continued.recorder.resume(left.series, left.densities, left.fields, continued.simulation)
    assert_same_states(continued.to(1.0), whole)


@pytest.mark.parametrize(("every", "cut"), [(0, 0.45), (4, 0.55), (4, 0.6), (0, 2.45), (0, 2.0)])
def test_a_resumed_run_has_the_states_of_one_that_never_stopped(every: int, cut: float, moving, tmp_path: Path) -> None:
    record, end = {"fields_every": every, "fields": ["tension"]}, 1.0 if cut < 1.0 else 3.0
    whole = moving("triangle", record).to(end)
    moving("triangle", record, output=tmp_path / "part.h5").to(end, until=cut)
    left = mb.Result.load(tmp_path / "part.h5")
    assert left.fields[-1].time == pytest.approx(cut), "an orderly stop keeps its last state"
    continued = moving("triangle", record, output=tmp_path / "part.h5")
    left.checkpoint.restore(continued.simulation)
    continued.recorder.resume(left.series, left.densities, left.fields, continued.simulation)
    assert_same_states(continued.to(end), whole)
    assert_same_states(mb.Result.load(tmp_path / "part.h5"), whole)
    assert Read(tmp_path / "part.h5").times == [state.time for state in whole.fields]


@pytest.mark.parametrize("steps", [1, 38, 39, 40, 41, 79, 80, 81, 1000])
def test_a_run_of_any_length_keeps_twenty_to_forty_even_states(steps: int, moving) -> None:
    run = moving("triangle", {"fields": ["J"]}, counts=(1, 1, 0))
    states = run.to(0.05 * steps).fields
    gap = stride(steps, 0)
    assert [state.step for state in states] == sorted({*range(0, steps, gap), steps})
    assert len(states) <= MOST_STATES + 1
    if steps >= MOST_STATES:
        assert len(states) > MOST_STATES // 2
    assert states[0].names == ("displacement", "J")


@pytest.mark.parametrize("fields", [[], None])
def test_a_solid_without_shape_and_a_record_without_fields_write_no_body(fields, moving, scenes, tmp_path) -> None:
    if fields is None:
        result = mb.run(mb.Scene.from_toml(scenes["chain"]), tmp_path / "body.h5")
    else:
        result = moving("triangle6", {"fields": fields}, output=tmp_path / "body.h5").to(0.2)
    assert result.mesh is None
    assert result.fields == ()
    with h5py.File(tmp_path / "body.h5") as file:
        assert "VTKHDF" not in file
    assert mb.Result.load(tmp_path / "body.h5").mesh is None


def test_an_unknown_field_is_said_before_the_first_step(moving) -> None:
    run = moving("triangle6")
    for record, key, says in (
        ({"fields": ["tensoin"]}, "fields[0]", "Did you mean 'tension'?"),
        ({"fields": ["J", "sarcomere_density"]}, "fields[1]", "which this scene has not. Allowed: J, activation"),
        ({"fields_every": 1}, "fields_every", "states of"),
    ):
        with pytest.raises(mb.ParameterError) as caught:
            mb.Record(**record).check(run.simulation, 10**10)
        assert caught.value.key == key
        assert says in caught.value.problem


def test_fields_of_a_solid_without_shape_are_refused(scenes) -> None:
    with pytest.raises(mb.SceneError, match=r"record\.fields: are given, and Chain has no shape"):
        mb.run(mb.Scene.from_toml(scenes["chain"]), settings={"record.fields": ["tension"]})


@pytest.mark.parametrize(("cells", "many"), [((5, 100, 0), False), ((5, 101, 0), True)])
def test_of_many_sites_a_summary_is_kept_and_no_row_for_each(cells, many: bool, moving) -> None:
    run = moving("quad", counts=cells)
    result = run.to(0.1)
    assert ("tension" in result.series) is not many
    assert ("mean/tension" in result.series) is many
    if many:
        assert sum(rows.nbytes for rows in result.series.values()) < 20_000
        bus = run.simulation.bus
        assert result["mean/tension"][-1] == pytest.approx(bus.tension.mean(), rel=1e-12)
        assert result["least/stretch"][-1] == bus.stretch.min() < bus.stretch.max() == result["largest/stretch"][-1]
        chosen = moving("quad", {"sites": [3, 7]}, counts=cells).to(0.1)
        np.testing.assert_array_equal(chosen["tension"][-1], bus.tension[[3, 7]])
        assert "mean/tension" in chosen.series


def test_a_body_of_ten_thousand_sites_is_saved(moving, tmp_path: Path) -> None:
    """The numbers of the sites alone are more than an attribute of HDF5 holds."""
    result = moving("quad", {"fields": ["tension"]}, output=tmp_path / "large.h5", counts=(50, 100, 0)).to(0.1)
    again = mb.Result.load(tmp_path / "large.h5")
    np.testing.assert_array_equal(again.sites, np.arange(10_000))
    assert_same_states(result, again)


MUSCLE = """
[scene]
name = "muscle"
effects = ["cross_bridges", "incompressibility", "sarcomere_density"]
[solid]
plugin = "finite_element"
mesh = {{ plugin = "block", shape = "{shape}", size = {size}, cells = {cells} }}
material = {{ plugin = "mooney_rivlin" }}
[[support]]
boundary = "left"
[cross_bridges]
plugin = "prescribed"
[sarcomere_density]
plugin = "tapered"
[continuation]
plugin = "natural"
to = 0.2
report = [0.0, 0.1, 0.2]
"""
MUSCLES = [
    ("triangle", [0.04, 0.02], [4, 2], "triangle6"),
    ("quadrilateral", [0.04, 0.02], [2, 1], "quad9"),
    ("tetrahedron", [0.04, 0.02, 0.02], [2, 1, 1], "tetra10"),
    ("hexahedron", [0.04, 0.02, 0.02], [2, 1, 1], "hexahedron27"),
]


@pytest.mark.parametrize(("shape", "size", "cells", "kind"), MUSCLES)
def test_a_finite_element_muscle_is_read_by_vtk(shape: str, size, cells, kind: str, nodes_of, tmp_path: Path) -> None:
    scene = mb.Scene.from_toml(MUSCLE.format(shape=shape, size=size, cells=cells))
    result = mb.run(scene, tmp_path / "muscle.h5")
    mesh = result.mesh
    assert mesh.kind == kind
    for number, corners in enumerate(nodes_of[kind]):
        middle = mesh.points[mesh.cells[:, corners]].mean(axis=1)
        np.testing.assert_allclose(mesh.points[mesh.cells[:, number]], middle, atol=1e-15, err_msg=f"node {number}")
    read = Read(tmp_path / "muscle.h5")
    assert read.times == pytest.approx([0.0, 0.1, 0.2])
    expected = {"displacement", "pressure", "stretch", "tension", "sarcomere_density", "fibre", "J"}
    assert {name for state in result.fields for name in state.names} == expected, "no activation: nobody called for it"
    for state in result.fields:
        grid = read.grid(state.time)
        found = arrays(grid.GetPointData()) | arrays(grid.GetCellData())
        for name in expected:
            np.testing.assert_array_equal(found[name], state[name], err_msg=name)
        # Incompressible: on the whole, and the mean ratio of each cell is that of its volumes.
        deformed = volumes(grid, found["displacement"])
        assert deformed.sum() == pytest.approx(np.prod(size), rel=1e-8)
        np.testing.assert_allclose(deformed * len(deformed) / np.prod(size), found["J"], rtol=1e-8)
    last = result.fields[-1]
    assert np.ptp(last["displacement"]) > 1e-4, "it must have moved"
    np.testing.assert_allclose(last["tension"], 0.2 * 73e3 * last["sarcomere_density"], rtol=1e-12)
    assert np.ptp(last["sarcomere_density"]) > 0.01


def test_a_finite_element_muscle_resumes_with_its_states(tmp_path: Path) -> None:
    text = MUSCLE.format(shape="triangle", size=[0.04, 0.02], cells=[2, 1])
    text = text.replace('name = "muscle"', 'name = "muscle"\nduration = 0.01\nstep = 1e-3')
    text = text.partition("[continuation]")[0] + "[record]\nfields_every = 3\n"
    scene = mb.Scene.from_toml(text.replace('plugin = "prescribed"', 'plugin = "distributed_moment"'))
    whole = mb.run(scene)
    start(Plan.of(scene), tmp_path / "part.h5").to(scene.duration, until=0.005)
    assert [state.step for state in mb.Result.load(tmp_path / "part.h5").fields] == [0, 3, 5]
    continued, again = mb.resume(tmp_path / "part.h5")
    assert_same_states(continued.to(again.duration), whole)
    assert [state.step for state in whole.fields] == [0, 3, 6, 9, 10]
    assert np.ptp([state["stretch"].mean() for state in whole.fields]) > 1e-3, "it must have moved"
