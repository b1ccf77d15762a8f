"""Published problems of nonlinear elasticity, solved with the finite-element solid as a scene would."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest
import skfem

from myobridge.equilibria import Equilibria
from myobridge.interfaces import MeshSource
from myobridge_plugins.continuation.natural import Natural
from myobridge_plugins.load.pressure import Pressure
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.guccione import Guccione
from myobridge_plugins.material.holzapfel_ogden import HolzapfelOgden
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block


def traced(solid, step=0.5):
    """Equilibrium under the whole load, which is raised in steps; every state on the way is stable."""
    problem = Equilibria(solid, None, of="load")
    path = Natural(step=step).trace(problem, problem.start)
    assert path.completed, path.reason
    assert {point.negative_eigenvalues for point in path.points} == {0}
    print([(point.level, point.iterations) for point in path.points], f"{solid.n_unknowns} displacements")
    return problem.motion(path.points[-1].unknowns)


# --- Cook's membrane


@attrs.frozen
class Cook(MeshSource):
    """The tapered panel (0, 0), (48, 44), (48, 60), (0, 44) mm."""

    shape: str
    n: int

    def mesh(self) -> Any:
        mesh = Block(size=(1.0, 1.0), cells=(self.n, self.n), shape=self.shape).mesh()
        x, y = mesh.p
        points = 1e-3 * np.stack([48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x)])
        found = type(mesh)(points, mesh.t)
        return found.with_boundaries({"left": lambda x: x[0] < 1e-9, "right": lambda x: x[0] > 48e-3 - 1e-9})


def cook(shape, n, displacement_at):
    """Vertical displacement of the corner (48, 60) [mm]: E = 240.565 MPa, nu = 0.499, 6.25 MPa upwards."""
    solid = FiniteElement(
        mesh=Cook(shape, n),
        material=NeoHooke(shear_modulus=80.242e6, form="isochoric"),
        support=(Support(boundary="left"),),
        load=(Traction(boundary="right", traction=(0.0, 6.25e6)),),
        bulk_modulus=40094e6,
    )
    return 1e3 * displacement_at(solid, traced(solid), (0.048, 0.060))[1]


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_cooks_membrane(shape, displacement_at):
    found = [cook(shape, n, displacement_at) for n in (4, 8, 16)]
    print(f"Cook's membrane, {shape}: corner moves by {found} mm")
    assert found[-1] == pytest.approx(6.94, abs=0.02)
    assert 0.0 < found[2] - found[1] < 0.75 * (found[1] - found[0]), "monotone, from below"


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["triangle", "quadrilateral"])
def test_cooks_membrane_refined(shape, displacement_at):
    found = [cook(shape, n, displacement_at) for n in (16, 32, 64)]
    print(f"Cook's membrane, {shape}: corner moves by {found} mm")
    assert found[1:] == pytest.approx([6.94, 6.94], abs=0.01)


# --- Land et al. (2015), problem 1


@attrs.frozen
class Bar(MeshSource):
    """Bar of 10 x 1 x 1 mm, hexahedra; those at the held end, where the stress is singular, are the shortest."""

    cells: tuple[int, int, int]

    def mesh(self) -> Any:
        mesh = Block(size=(1.0, 1.0, 1.0), cells=self.cells, shape="hexahedron").mesh()
        points = 1e-3 * np.stack([10.0 * mesh.p[0] ** 1.8, *(0.5 - 0.5 * np.cos(np.pi * mesh.p[1:]))])
        found = skfem.MeshHex(points, mesh.t)
        return found.with_boundaries({"left": lambda x: x[0] < 1e-9, "bottom": lambda x: x[2] < 1e-9})


@pytest.mark.parametrize(
    ("cells", "accuracy"), [((8, 2, 2), 0.02), pytest.param((16, 3, 3), 0.005, marks=pytest.mark.slow)]
)
def test_the_pressed_bar_of_land(cells, accuracy, displacement_at):
    """Deformed z of the point (10, 1, 1) mm under 4 Pa that follow the lower face; the fibres lie along x."""
    solid = FiniteElement(
        mesh=Bar(cells),
        material=Guccione(**Guccione.parameter_sets["land-2015-1"]),
        support=(Support(boundary="left"),),
        load=(Pressure(boundary="bottom", pressure=4.0),),
        bulk_modulus=np.inf,
    )
    found = 1.0 + 1e3 * displacement_at(solid, traced(solid), (10e-3, 1e-3, 1e-3))[2]
    print(f"bar of {cells} hexahedra: z = {found:.4f} mm")
    assert found == pytest.approx(4.170, abs=accuracy)


# --- inflation of a thick sphere


@attrs.frozen
class Shell(MeshSource):
    """Octant of a hollow sphere of radii 1 and 2: three patches of n x n cells, m through the wall."""

    n: int
    m: int

    def mesh(self) -> Any:
        side = Block(size=(1.0, 1.0, 1.0), cells=(self.n, self.n, self.m), shape="hexahedron").mesh()
        patches = []
        for axis in range(3):
            # Angles, not lengths, are divided evenly; a patch is the part where its own coordinate is the largest.
            places = np.ones((3, side.p.shape[1]))
            places[(axis + 1) % 3], places[(axis + 2) % 3] = np.tan(0.25 * np.pi * side.p[:2])
            patches.append(places / np.linalg.norm(places, axis=0) * (1.0 + side.p[2]))
        mesh = skfem.MeshHex(np.hstack(patches), np.hstack([side.t + k * side.p.shape[1] for k in range(3)]))
        kept, inverse = np.unique(np.round(mesh.p, 9), axis=1, return_index=True, return_inverse=True)[1:]
        mesh = skfem.MeshHex(mesh.p[:, kept], inverse.reshape(-1)[mesh.t])
        sides = {name: lambda x, k=k: x[k] < 1e-9 for k, name in enumerate("xyz")}
        # Middles of flat facets lie within the spheres, by less than a quarter of the wall.
        outer = mesh.boundary_facets()
        radius = np.linalg.norm(mesh.p[:, mesh.facets[:, outer]], axis=0)
        return mesh.with_boundaries({**sides, "inside": outer[(radius < 1.0 + 1e-9).all(axis=0)]})


INFLATED = {1.1: 1.2136623165, 1.5: 3.9416688637, 2.0: 5.4967421639}  # inner stretch, pressure for c10 = c01 = 1


def test_the_published_pressures_are_those_of_the_closed_form():
    """p = integral of W'(s) / (s^3 - 1) over the hoop stretch s, from the outer to the inner wall."""
    from scipy.integrate import quad

    def slope(s):
        return (4.0 * s - 4.0 * s**-5 + 4.0 * s**3 - 4.0 * s**-3) / (s**3 - 1.0)

    for inner, pressure in INFLATED.items():
        outer = (1.0 + (inner**3 - 1.0) / 8.0) ** (1.0 / 3.0)
        assert quad(slope, outer, inner, epsabs=1e-13)[0] == pytest.approx(pressure, abs=1e-9)


def inner_stretches(n, m, equilibrium, displacement_at):
    """Radius of the inner wall on the axis under each published pressure."""
    found, motion = [], None
    for pressure in INFLATED.values():
        solid = FiniteElement(
            mesh=Shell(n, m),
            material=MooneyRivlin(c10=1.0, c01=1.0),
            support=tuple(Support(boundary=axis, components=axis) for axis in "xyz"),
            load=(Pressure(boundary="inside", pressure=pressure),),
            bulk_modulus=np.inf,
        )
        motion = equilibrium(solid, start=motion)
        found.append(1.0 + displacement_at(solid, motion, (1.0, 0.0, 0.0))[0])
    return np.array(found)


@pytest.mark.parametrize(("numbers", "accuracy"), [((1, 2), 5e-3), pytest.param((2, 3), 1e-3, marks=pytest.mark.slow)])
def test_inflation_of_a_thick_sphere(numbers, accuracy, equilibrium, displacement_at):
    """Facets are flat, so the sphere of a coarse mesh is not round: an error of h^2, which extrapolation removes."""
    exact = np.array(list(INFLATED))
    coarse, fine = (inner_stretches(n, n, equilibrium, displacement_at) for n in numbers)
    limit = fine + (fine - coarse) / ((numbers[1] / numbers[0]) ** 2 - 1.0)
    print(f"inner stretches {coarse} and {fine}, extrapolated {limit}, exact {exact}")
    assert np.all(np.abs(fine - exact) < 0.6 * np.abs(coarse - exact))
    assert limit == pytest.approx(exact, rel=accuracy)


# --- uniaxial tension


@pytest.mark.parametrize("shape", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize(
    ("material", "stretch", "expected"),
    [
        (NeoHooke(shear_modulus=10.0), 2.0, 17.5),
        (MooneyRivlin(c10=2.5, c01=2.5), 2.0, 13.125),
        (HolzapfelOgden(a=0.059, b=8.023, af=18.472, bf=16.026), 1.1, 17.32206451),
    ],
)
def test_uniaxial_stress(shape, material, stretch, expected, equilibrium):
    """Reaction by reference area of a block pulled along its fibres; the sides are free to come in."""
    pull = stretch - 1.0
    solid = FiniteElement(
        mesh=Block(size=(1.0, 1.0, 1.0), cells=(2, 2, 2), shape=shape),
        material=material,
        support=(
            Support(boundary="left", components="x"),
            Support(boundary="front", components="y"),
            Support(boundary="bottom", components="z"),
            Support(boundary="right", components="x", displacement=pull),
        ),
        bulk_modulus=np.inf,
    )
    # Pulled without coming in: nodes left at rest behind a side that moves so far would be turned over.
    stretched = pull * solid._body.grid.positions * np.array([1.0, 0.0, 0.0])
    start = attrs.evolve(solid.rest_motion(), displacement=stretched.ravel()[solid._body.free])
    motion = equilibrium(solid, start=start)
    reaction = solid.reactions(motion, np.empty(0), 0.0)
    assert reaction["right"] == pytest.approx([expected, 0.0, 0.0], rel=1e-9, abs=1e-9)
    assert reaction["left"] == pytest.approx([-expected, 0.0, 0.0], rel=1e-9, abs=1e-9)
    assert solid.stretch(motion.displacement, 0.0) == pytest.approx(stretch, rel=1e-10)
