r"""Order of the finite-element solid by a manufactured solution with active tension, strictly incompressible.

The solution is a chain of shears, each with :math:`J = 1` exactly, one side of the unit square or cube held:

.. math:: y = Y + b \sin \pi X, \quad (z = Z + c \sin \pi y,) \quad x = X + a \sin \pi y \;(\text{or } z), \qquad
          p = p_0 \cos \pi X \cos \pi Y

.. math:: P = \mu (F - F^{-T}) + p F^{-T} + \frac{T_0 + K_0 (\lambda - 1)}{\lambda} F N \otimes N, \qquad
          f_a = \int P : \nabla N_a

The load is the weak one, so that it serves inside and on the free boundary at once, and nothing is differentiated.
Exact stress and errors are integrated by scikit-fem, by a rule of a higher degree than that of the solid.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest
import skfem

from myobridge.interfaces import AffineLaw, MeshSource
from myobridge.testing import fitted_order
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.macro_solid.finite_element.element_pairs import reference_cell
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

MU, P0, T0, K0 = 1e4, 4e3, 6e3, 2e4
FIBRE = np.array([1.0, 0.6, -0.4])
DEGREE = 8


def shear(places, last, first, amplitude):
    """Step ``x_last += amplitude sin(pi x_first)``, and its derivative."""
    moved = places.copy()
    moved[last] = places[last] + amplitude * np.sin(np.pi * places[first])
    slope = np.zeros((len(places), *places.shape))
    for axis in range(len(places)):
        slope[axis, axis] = 1.0
    slope[last, first] = amplitude * np.pi * np.cos(np.pi * places[first])
    return moved, slope


def solution(X):
    """Deformed places (d, ...), F (d, d, ...) and pressure (...) at reference places (d, ...)."""
    steps = [(1, 0, 0.06), (0, 1, 0.05)] if len(X) == 2 else [(1, 0, 0.06), (2, 1, 0.05), (0, 2, 0.04)]
    x, F = X, None
    for last, first, amplitude in steps:
        x, slope = shear(x, last, first, amplitude)
        F = slope if F is None else np.einsum("ik...,kj...->ij...", slope, F)
    return x, F, P0 * np.cos(np.pi * X[0]) * np.cos(np.pi * X[1])


def stress(X):
    """Nominal stress (d, d, ...) of the exact solution [Pa]."""
    _, F, pressure = solution(X)
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(F, (0, 1), (-1, -2))), (-2, -1), (0, 1))  # F^-T
    N = FIBRE[: len(X)] / np.linalg.norm(FIBRE[: len(X)])
    along = np.einsum("ij...,j->i...", F, N)
    stretch = np.sqrt(np.sum(along**2, axis=0))
    tension = T0 + K0 * (stretch - 1.0)
    return MU * (F - inverse) + pressure * inverse + tension / stretch * np.einsum("i...,j->ij...", along, N)


@attrs.frozen
class Shaken(MeshSource):
    """Unit square or cube; of triangles and tetrahedra, whose regular meshes flatter the order, inner nodes are shaken.

    Quadrilaterals and hexahedra stay regular: their pressure is linear in the coordinates of the cell, which is of
    order 2 where cells become parallelograms as they are refined, and of a lower one where they do not (Boffi and
    Gastaldi, Int. J. Numer. Meth. Fluids 39 (2002) 1001).
    """

    shape: str
    n: int

    def mesh(self) -> Any:
        d = 2 if self.shape in ("triangle", "quadrilateral") else 3
        mesh = Block(size=(1.0,) * d, cells=(self.n,) * d, shape=self.shape).mesh()
        inside = np.all((mesh.p > 1e-9) & (mesh.p < 1.0 - 1e-9), axis=0)
        share = 0.1 if self.shape in ("triangle", "tetrahedron") else 0.0
        shift = share * np.random.default_rng(0).uniform(-1.0, 1.0, mesh.p.shape) / self.n
        found = type(mesh)(mesh.p + inside * shift, mesh.t)
        return found.with_boundaries({"left": lambda x: x[0] < 1e-9})


def discrete(shape, n, pair):
    """Body, its displacement (n_nodes, d) and pressure, from the weak load and exact values on the held side."""
    d = 2 if shape in ("triangle", "quadrilateral") else 3
    solid = FiniteElement(
        mesh=Shaken(shape, n),
        material=NeoHooke(shear_modulus=MU),
        fibres=Constant(direction=tuple(FIBRE[:d])),
        support=(Support(boundary="left"),),
        elements=pair,
        bulk_modulus=np.inf,
        quadrature=6,
    )
    body = solid._body
    basis, places = scalar_basis(body)

    @skfem.LinearForm
    def component(v: Any, w: Any):
        return sum(w[f"P{j}"] * v.grad[j] for j in range(d))

    P = stress(np.asarray(basis.global_coordinates()))
    load = np.empty((body.grid.n_nodes, d))
    for i in range(d):
        load[places, i] = component.assemble(basis, **{f"P{j}": P[i, j] for j in range(d)})
    exact = (solution(body.grid.positions.T)[0].T - body.grid.positions).ravel()
    held = attrs.evolve(body.held, values=[exact[body.held.numbers[0]]])
    body = attrs.evolve(body, held=held, loading=attrs.evolve(body.loading, weight=load.ravel()))
    solid = attrs.evolve(solid, shared=body)
    law = AffineLaw(np.ones(solid.n_sites), np.full(solid.n_sites, T0), np.full(solid.n_sites, K0))
    start = attrs.evolve(solid.rest_motion(), displacement=exact[body.free])
    step = QuasiStatic().step(solid, law, start, {}, 0.0, 1.0)
    assert step.report.converged, step.report.reason
    return body, body.displacement(step.motion.displacement, 0.0).reshape(-1, d), body.pressure(step.motion.multiplier)


def scalar_basis(body):
    """scikit-fem's basis of one component, and the number of each of its nodes in the body."""
    from scipy.spatial import KDTree

    basis = skfem.Basis(body.grid.mesh, body.grid.cell.element, intorder=DEGREE)
    distance, places = KDTree(body.grid.positions).query(basis.doflocs.T)
    assert distance.max() < 1e-12
    return basis, places


def errors(shape, n, pair):
    """Errors of the displacement in H1 and L2, and of the pressure in L2 (those of J, and tension, follow)."""
    body, displacement, pressure = discrete(shape, n, pair)
    basis, places = scalar_basis(body)
    X = np.asarray(basis.global_coordinates())
    x, F, p = solution(X)
    first, slopes = 0.0, 0.0
    for i in range(len(X)):
        found = basis.interpolate(displacement[places, i])
        first += np.sum(basis.dx * (np.asarray(found) - (x[i] - X[i])) ** 2)
        for j in range(len(X)):
            slopes += np.sum(basis.dx * (found.grad[j] + (i == j) - F[i, j]) ** 2)
    shapes = reference_cell(body.grid.mesh, pair, DEGREE).shapes
    values = np.empty(p.shape)
    values[body.grid.order] = pressure[body.grid.multipliers] @ shapes.T
    return np.sqrt([slopes, first, np.sum(basis.dx * (values - p) ** 2) / P0**2])


def check_orders(shape, pair, numbers):
    found = np.array([errors(shape, n, pair) for n in numbers])
    steps = [1.0 / n for n in numbers]
    orders = [fitted_order(steps, column) for column in found.T]
    told = f"{shape} {pair} on {numbers}: orders H1 {orders[0]:.3f}, L2 {orders[1]:.3f}, pressure L2 {orders[2]:.3f}"
    print(told, found.tolist(), sep="\n")
    assert orders[0] == pytest.approx(2.0, abs=0.15), told
    assert orders[1] == pytest.approx(3.0, abs=0.15), told
    assert orders[2] == pytest.approx(2.0, abs=0.15), told


def test_the_solution_is_isochoric_and_its_gradient_is_one():
    for d in (2, 3):
        X = np.random.default_rng(0).uniform(0.0, 1.0, (d, 40))
        x, F, _ = solution(X)
        assert np.abs(np.linalg.det(np.moveaxis(F, -1, 0)) - 1.0).max() < 1e-14
        for j in range(d):
            step = np.zeros((d, 1))
            step[j] = 1e-6
            difference = (solution(X + step)[0] - solution(X - step)[0]) / 2e-6
            assert np.abs(difference - F[:, j]).max() < 1e-8
        assert np.abs(x - X).max() > 0.05


@pytest.mark.parametrize(
    ("shape", "pair", "numbers"), [("triangle", "P2-P1", (8, 16, 32)), ("quadrilateral", "Q2-P1disc", (4, 8, 16))]
)
def test_order_in_the_plane(shape, pair, numbers):
    check_orders(shape, pair, numbers)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shape", "pair", "numbers"), [("tetrahedron", "P2-P1", (6, 8, 10)), ("hexahedron", "Q2-P1disc", (2, 3, 4))]
)
def test_order_in_space(shape, pair, numbers):
    check_orders(shape, pair, numbers)
