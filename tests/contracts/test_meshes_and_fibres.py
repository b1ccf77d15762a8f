"""Every registered source of meshes and field of fibres against the contract."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge.build import build
from myobridge.registry import registry
from myobridge.testing import fibre_checks, mesh_checks

# Parameters, and the scaled Jacobian that no cell may fall below.
MESHES = {
    "block": ({"size": [1.0, 0.3], "cells": [5, 4]}, 0.4),
    "block-quadrilateral": (
        {"size": [1.0, 0.3], "cells": [5, 4], "shape": "quadrilateral", "bow": 0.1, "origin": [1.0, 2.0]},
        0.9,
    ),
    "block-tetrahedron": ({"size": [1.0, 0.8, 1.2], "cells": [4, 3, 5]}, 0.3),
    "block-hexahedron": ({"size": [1.0, 0.8, 1.2], "cells": [4, 3, 5], "shape": "hexahedron", "bow": -0.2}, 0.8),
    "spindle": ({}, 0.5),
    "spindle-quadrilateral": ({"shape": "quadrilateral", "tendon": 0.1, "refinements": 1}, 0.9),
    "fusiform": ({}, 0.2),
    "fusiform-hexahedron": ({"shape": "hexahedron", "across": 3}, 0.75),
    "fusiform-flat": ({"flatness": 0.5, "tendon": 0.0}, 0.1),
    "file": ({"file": "body.vtu", "planes": [{"name": "foot", "axis": "y", "at": 0.0}]}, 0.4),
}
FIBRES = {
    "constant": {},
    "harmonic": {"start": "left", "end": "right"},
    "harmonic-linear": {"start": "left", "end": "right", "order": 1},
    "table": {"file": "places.txt"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import meshio

    where = tmp_path_factory.mktemp("files")
    flat = build(registry(), "mesh", {"plugin": "block", "size": [1.0, 0.5], "cells": [4, 2]}).mesh()
    meshio.write_points_cells(where / "body.vtu", np.pad(flat.p.T, ((0, 0), (0, 1))), [("triangle", flat.t.T)])
    places = np.random.default_rng(0).normal(size=(50, 6))
    for dim in (2, 3):
        np.savetxt(where / f"places{dim}.txt", places[:, : 2 * dim])
    return where


def mesh_source(key, folder):
    return build(registry(), "mesh", {"plugin": key.split("-")[0], **MESHES[key][0]}, folder=folder)


@pytest.mark.parametrize("key", MESHES)
def test_meshes(key, folder):
    for check in mesh_checks(mesh_source(key, folder), MESHES[key][1]):
        check()


@pytest.mark.parametrize("key", [key for key in MESHES if key != "file"])
def test_every_facet_of_the_outside_has_one_name(key, folder):
    mesh = mesh_source(key, folder).mesh()
    named = np.concatenate(list(mesh.boundaries.values()))
    assert np.array_equal(np.sort(named), mesh.boundary_facets())


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
@pytest.mark.parametrize("key", FIBRES)
def test_fibres(key, shape, folder):
    if shape in ("triangle", "quadrilateral"):
        mesh = build(registry(), "mesh", {"plugin": "spindle", "cells": 6, "shape": shape}).mesh()
    else:
        mesh = build(registry(), "mesh", {"plugin": "fusiform", "cells": 5, "shape": shape}).mesh()
    table = {"plugin": key.split("-")[0], **FIBRES[key]}
    if key == "table":
        table["file"] = f"places{mesh.dim()}.txt"
    for check in fibre_checks(build(registry(), "fibres", table, folder=folder), mesh):
        check()


@pytest.mark.parametrize(("family", "examples"), [("mesh", MESHES), ("fibres", FIBRES)])
def test_every_registered_one_has_an_example(family, examples):
    ours = {item.name for item in registry() if item.family == family and item.package == "myobridge"}
    assert {key.split("-")[0] for key in examples} == ours
