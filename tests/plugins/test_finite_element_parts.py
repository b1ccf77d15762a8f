"""Regions of the finite-element solid, what a body shows, and what it refuses with a helpful message."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge.errors import ParameterError
from myobridge.interfaces import AffineLaw, Motion
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.load.force import Force
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.regions import Region
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block

SHAPES = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
ANY_SHAPE = pytest.mark.parametrize("shape", SHAPES)
SOFT, HARD = NeoHooke(shear_modulus=1e4), NeoHooke(shear_modulus=8e4)
TENDON = Region(name="tendon", material=HARD, cross_bridges=False)


def plane(**given):
    return FiniteElement(**({"mesh": Block(size=(0.03, 0.02), cells=(3, 2)), "material": SOFT} | given))


@ANY_SHAPE
def test_tendon_has_no_sites_and_its_own_material(shape, distorted):
    solid = FiniteElement(mesh=distorted(shape), material=SOFT, region=(TENDON,))
    grid = solid._body.grid
    mesh = grid.mesh
    tendon = np.isin(np.arange(mesh.nelements), mesh.subdomains["tendon"])
    assert 0 < tendon.sum() < tendon.size
    n_q = grid.cell.weights.size
    assert solid.n_sites == (~tendon).sum() * n_q < grid.n_points
    assert solid.site_positions().shape == (solid.n_sites, mesh.dim())
    on_cells = solid.on_cells(solid.site_positions()[:, 0])
    assert np.isnan(on_cells).sum() == tendon.sum()
    # Energy of an affine deformation: volume times energy density, material by material.
    d = mesh.dim()
    F = np.eye(3)
    F[:d, :d] += 0.2 * np.random.default_rng(0).uniform(-1.0, 1.0, (d, d))
    density = 0.5 * (np.sum(F**2) - 3.0) - np.log(np.linalg.det(F))
    muscle, whole = solid.site_volumes.sum(), grid.volumes.sum()
    u = (grid.positions @ (F[:d, :d] - np.eye(d)).T).ravel()
    expected = density * (1e4 * muscle + 8e4 * (whole - muscle))
    assert 0.1 * whole < muscle < 0.9 * whole
    assert solid.elastic_energy(u) == pytest.approx(expected, rel=1e-11)


@ANY_SHAPE
def test_tension_pulls_in_muscle_alone(shape, distorted):
    solid = FiniteElement(mesh=distorted(shape), material=SOFT, region=(TENDON,))
    u = 2e-4 * np.random.default_rng(0).uniform(-1.0, 1.0, solid.n_unknowns)
    motion = Motion(u, 0.0 * u, np.empty(0))
    law = AffineLaw(np.ones(solid.n_sites), np.full(solid.n_sites, 5e3), np.zeros(solid.n_sites))
    active = solid.balance(motion, law, 0.0).force - solid.balance(motion, None, 0.0).force
    grid = solid._body.grid
    last = grid.region_batches[-1][0]
    in_muscle = np.unique(grid.nodes[: grid.first_cell[last]])
    force = active.reshape(-1, grid.dimension)
    outside = np.setdiff1d(np.arange(grid.n_nodes), in_muscle)
    assert outside.size
    assert np.all(force[outside] == 0.0)
    assert np.abs(force[in_muscle]).max() > 1e-2


def test_fibres_of_a_region(distorted):
    along, across = Constant(direction=(1.0, 0.0)), Constant(direction=(0.0, 1.0))
    region = Region(name="tendon", fibres=across)
    solid = FiniteElement(mesh=distorted("triangle"), material=SOFT, fibres=along, region=(region,))
    assert solid.n_sites == solid._body.grid.n_points, "a region with cross-bridges is muscle"
    shown = solid.visible_fields(solid.rest_motion(), 0.0)["fibre"]
    tendon = np.isin(solid._body.grid.order, solid._body.grid.mesh.subdomains["tendon"])
    assert shown[tendon] == pytest.approx(np.tile([0.0, 1.0, 0.0], (tendon.sum(), 1)))
    assert shown[~tendon] == pytest.approx(np.tile([1.0, 0.0, 0.0], ((~tendon).sum(), 1)))


@ANY_SHAPE
def test_the_pressure_of_an_enclosed_body_is_shown_without_its_level(shape):
    """Nothing but differences mean anything: of a pressure in one cell, the mean over the cells is taken away."""
    size = (0.03, 0.02) if shape in SHAPES[:2] else (0.03, 0.02, 0.02)
    cells = (3, 2) if len(size) == 2 else (2, 2, 2)
    sides = ("left", "right", "bottom", "top", "front", "back")[: 2 * len(size)]
    solid = FiniteElement(
        mesh=Block(size=size, cells=cells, shape=shape),
        material=SOFT,
        support=tuple(Support(boundary=side) for side in sides),
        bulk_modulus=np.inf,
    )
    rest = solid.rest_motion()
    assert solid._body.enclosed
    assert rest.multiplier.size == solid._body.grid.n_multipliers - 1
    grid = solid._body.grid
    one = np.zeros(grid.n_multipliers)
    one[grid.multipliers[0, 0]] = 4e3
    shown = solid.visible_fields(Motion(rest.displacement, rest.velocity, one[solid._body.free_multipliers]), 0.0)
    pressure = shown["pressure"]
    assert np.ptp(pressure) == pytest.approx(4e3)
    if grid.cell.multiplier == "P1disc":
        assert pressure.size == grid.n_cells
        assert abs(pressure.sum()) < 1e-9
        assert np.sum(np.abs(pressure - pressure.max()) < 1.0) in (1, pressure.size - 1), "one cell differs"


# --- what is refused


def refused(key, *words, **given):
    with pytest.raises(ParameterError) as caught:
        assert plane(**given).n_unknowns
    assert caught.value.key == key
    for word in words:
        assert word in caught.value.problem


def test_unknown_names_are_told_with_the_nearest():
    refused(
        "support[1].boundary",
        "'rigth'",
        "Did you mean 'right'?",
        support=(Support(boundary="left"), Support(boundary="rigth")),
    )
    refused("load[0].boundary", "'tops'", "Did you mean 'top'?", load=(Force(boundary="tops", force=(1.0, 0.0)),))
    refused("region[0].name", "tendon", "no named subdomains", region=(TENDON,))
    with pytest.raises(ParameterError, match="elements"):
        plane(elements="P2P1")


def test_a_load_that_does_not_fit_the_body():
    refused("load[0].force", "2D body", load=(Force(boundary="top", force=(1.0, 0.0, 0.0)),))


def test_a_cell_belongs_to_one_region(distorted):
    twice = (TENDON, Region(name="tendon"))
    refused("region[1].name", "shares", "'tendon'", mesh=distorted("triangle"), region=twice)


def test_elements_that_do_not_fit_the_mesh_or_the_effects():
    refused("elements", "does not exist on triangles", "P2-P1", elements="Q2-P1disc", bulk_modulus=np.inf)
    refused("elements", "needs a multiplier", "P2-P1", elements="P2", bulk_modulus=np.inf)
    refused("elements", "does without", "Allowed: P1, P2", elements="P2-P1")
    quads = Block(size=(0.03, 0.02), cells=(3, 2), shape="quadrilateral")
    refused("elements", "does not exist on quadrilaterals", mesh=quads, elements="P1-P0", bulk_modulus=np.inf)


@pytest.mark.parametrize("degree", [3, 4])
def test_rules_with_a_negative_weight_are_refused(degree):
    refused("quadrature", f"is {degree}", "negative weight", quadrature=degree)


def test_gravity_has_one_number_for_each_axis():
    refused("gravity", "3 components", "2 dimensions", gravity=(0.0, 0.0, -9.81))
    down = plane(gravity=9.81, density=1e3).external_force(np.zeros(plane().n_unknowns), 0.0).reshape(-1, 2).sum(axis=0)
    assert down == pytest.approx([0.0, -9.81e3 * 0.03 * 0.02], abs=1e-12)


def test_supports():
    refused("support[0].components", "holds 'z'", "plane", support=(Support(boundary="left", components="z"),))
    refused(
        "support[0].displacement", "3 values for 2", support=(Support(boundary="left", displacement=(0.0, 0.0, 0.0)),)
    )
    for components in ("xw", "xx"):
        with pytest.raises(ParameterError, match="letters out of x, y, z"):
            Support(boundary="left", components=components)
    corner = (Support(boundary="left"), Support(boundary="bottom", components="y", displacement=1e-3))
    refused("support[1].displacement", "component y", "'left'", "share nodes", support=corner)
    agreeing = (Support(boundary="left"), Support(boundary="bottom", components="y"))
    assert plane(support=agreeing).n_unknowns > 0


def test_a_body_that_cannot_move_is_refused():
    every = tuple(Support(boundary=side) for side in ("left", "right", "bottom", "top"))
    single = Block(size=(0.03, 0.02), cells=(1, 1))
    refused("support", "nothing is left to move", mesh=single, elements="P1", support=every)
