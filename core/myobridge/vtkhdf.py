"""VTKHDF: the group of a result file that ParaView and VTK read, an unstructured grid with time steps.

Layout (VTK File Formats, VTKHDF 2.0): the undeformed mesh once, with all its offsets in ``/VTKHDF/Steps`` zero; each
field one long array under ``PointData`` or ``CellData``, with the row at which each step begins under
``PointDataOffsets`` or ``CellDataOffsets``. A field that does not change from one step to the next has the same offset
in both, and its rows once. Nodes of quadratic cells are ordered as meshio orders them, which is VTK's order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from myobridge.errors import PluginError, nearest
from myobridge.fields import FieldSnapshot
from myobridge.interfaces import Array, VisibleMesh

__all__ = ["CELL_TYPES", "read_body", "write_body"]

CELL_TYPES: Mapping[str, int] = {
    "triangle": 5,
    "quad": 9,
    "tetra": 10,
    "hexahedron": 12,
    "triangle6": 22,
    "tetra10": 24,
    "quad9": 28,
    "hexahedron27": 29,
}
"""VTK's number of each kind of cell."""

_ROOT = "VTKHDF"
_PLACES = {"PointData": "at_nodes", "CellData": "on_cells"}


def write_body(file: Any, mesh: VisibleMesh, states: Sequence[FieldSnapshot]) -> None:
    """Write `mesh` and `states` into an open HDF5 file.

    Raises
    ------
    PluginError
        If the cells are of a kind that is not in `CELL_TYPES`.
    """
    if mesh.kind not in CELL_TYPES:
        raise PluginError(
            f"visible_mesh: cells of kind '{mesh.kind}' cannot be written. {nearest(mesh.kind, CELL_TYPES)}"
        )
    root = file.create_group(_ROOT)
    root.attrs["Version"] = np.array([2, 0])
    # VTK wants a string of fixed length.
    root.attrs["Type"] = np.bytes_("UnstructuredGrid")
    _write_mesh(root, mesh)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(states)
    steps["Values"] = np.array([state.time for state in states])
    steps["NumberOfParts"] = np.ones(len(states), dtype=np.int64)
    for name, shape in (
        ("PartOffsets", (len(states),)),
        ("PointOffsets", (len(states),)),
        ("CellOffsets", (len(states), 1)),
        ("ConnectivityIdOffsets", (len(states), 1)),
    ):
        steps[name] = np.zeros(shape, dtype=np.int64)
    # Ours, and of no concern to VTK.
    steps["Numbers"] = np.array([state.step for state in states], dtype=np.int64)
    steps.attrs["label"] = states[0].label if states else "time"
    for place, attribute in _PLACES.items():
        data, offsets = root.create_group(place), steps.create_group(f"{place}Offsets")
        for name in getattr(states[0], attribute) if states else ():
            data[name], offsets[name] = _rows([getattr(state, attribute)[name] for state in states])


def _write_mesh(root: Any, mesh: VisibleMesh) -> None:
    n_cells, n_nodes = np.shape(mesh.cells)
    root["Points"] = np.asarray(mesh.points, dtype=float)
    root["Connectivity"] = np.asarray(mesh.cells, dtype=np.int64).ravel()
    root["Offsets"] = np.arange(n_cells + 1, dtype=np.int64) * n_nodes
    root["Types"] = np.full(n_cells, CELL_TYPES[mesh.kind], dtype=np.uint8)
    root["NumberOfPoints"] = np.array([len(mesh.points)], dtype=np.int64)
    root["NumberOfCells"] = np.array([n_cells], dtype=np.int64)
    root["NumberOfConnectivityIds"] = np.array([n_cells * n_nodes], dtype=np.int64)


def _rows(arrays: Sequence[Array]) -> tuple[Array, Any]:
    """Rows of all steps, those that repeat the step before left out, and where each step begins."""
    kept: list[Array] = []
    offsets: list[int] = []
    end = 0
    for array in arrays:
        if not kept or not (array is kept[-1] or np.array_equal(array, kept[-1], equal_nan=True)):
            kept.append(array)
            end += len(array)
        offsets.append(end - len(array))
    return np.concatenate(kept), np.array(offsets, dtype=np.int64)


def read_body(file: Any) -> tuple[VisibleMesh | None, tuple[FieldSnapshot, ...]]:
    """Mesh and states of an open HDF5 file; None and nothing where it has none."""
    if _ROOT not in file:
        return None, ()
    root = file[_ROOT]
    number = int(root["Types"][0])
    kind = next(name for name, value in CELL_TYPES.items() if value == number)
    cells = root["Connectivity"][...].reshape(len(root["Types"]), -1)
    mesh = VisibleMesh(root["Points"][...], cells, kind)
    steps = root["Steps"]
    counts = {"PointData": len(mesh.points), "CellData": len(cells)}
    fields: dict[str, list[dict[str, Array]]] = {}
    for place, attribute in _PLACES.items():
        states: list[dict[str, Array]] = [{} for _ in steps["Values"]]
        for name, data in root[place].items():
            rows: dict[int, Array] = {}
            for state, begin in zip(states, steps[f"{place}Offsets"][name][...].tolist(), strict=True):
                if begin not in rows:
                    rows[begin] = data[begin : begin + counts[place]]
                state[name] = rows[begin]
        fields[attribute] = states
    label = str(steps.attrs["label"])
    return mesh, tuple(
        FieldSnapshot(float(time), int(step), at_nodes, on_cells, label)
        for time, step, at_nodes, on_cells in zip(
            steps["Values"][...], steps["Numbers"][...], fields["at_nodes"], fields["on_cells"], strict=True
        )
    )
