r"""The finite-element solid: patch test, objectivity, order of cells, threads.

Patch test: whatever the cells, a boundary held at ``F X`` gives ``F X`` everywhere, and the stress
:math:`P(F) + p\,\mathrm{cof} F + (T / \lambda) F N \otimes N`, known in closed form.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from myobridge.interfaces import AffineLaw, Motion
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.load.robin import Robin
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.forces import total_force
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.guccione import Guccione
from myobridge_plugins.material.neo_hooke import NeoHooke

MU = 1e4
SHAPES = {
    "triangle": ("P2-P1", "P1-P0", "P2", "P1"),
    "quadrilateral": ("Q2-P1disc", "Q2"),
    "tetrahedron": ("P2-P1", "P1-P0", "P2", "P1"),
    "hexahedron": ("Q2-P1disc", "Q2"),
}
PAIRS = pytest.mark.parametrize(
    ("shape", "pair"), [(shape, pair) for shape, pairs in SHAPES.items() for pair in pairs], ids=lambda x: str(x)
)
ANY_SHAPE = pytest.mark.parametrize("shape", SHAPES)


def dimension(shape):
    return 2 if shape in ("triangle", "quadrilateral") else 3


def gradient(d, seed=1, determinant=None):
    """A deformation gradient (d, d), of a given determinant where one is asked for."""
    found = np.eye(d) + 0.25 * np.random.default_rng(seed).uniform(-1.0, 1.0, (d, d))
    return found if determinant is None else found * (determinant / np.linalg.det(found)) ** (1.0 / d)


def tension(solid, value):
    """Law of the constant nominal tension `value` [Pa]."""
    zero = np.zeros(solid.n_sites)
    return AffineLaw(zero + 1.0, zero + value, zero)


def stress(deformation, pressure, active, direction):
    """Nominal stress (3, 3) of the logarithmic neo-Hooke material, with pressure and tension [Pa]."""
    F = np.eye(3)
    d = len(deformation)
    F[:d, :d] = deformation
    N = np.zeros(3)
    N[:d] = direction / np.linalg.norm(direction)
    inverse = np.linalg.inv(F).T
    along = F @ N
    passive = MU * (F - inverse) + pressure * np.linalg.det(F) * inverse
    return passive + active / np.linalg.norm(along) * np.outer(along, N)


def mean_stress(solid, motion, active):
    """Volume mean of the nominal stress (d, d), from the forces on all nodes: their virial."""
    body = solid._body
    force = total_force(body, motion, np.full(solid.n_sites, active), 0.0).reshape(-1, body.grid.dimension)
    return force.T @ body.grid.positions / body.grid.volumes.sum()


def make(distorted, shape, pair, bulk_modulus, **more):
    direction = (1.0, 0.5, -0.3)[: dimension(shape)]
    return FiniteElement(
        mesh=distorted(shape),
        material=NeoHooke(shear_modulus=MU),
        fibres=Constant(direction=direction),
        support=(Support(boundary="all"),),
        elements=pair,
        bulk_modulus=bulk_modulus,
        quadrature=6,
        **more,
    )


def near(solid, F):
    """The affine field with every free node moved by up to half a millimetre: 5 % of a cell."""
    rest, body = solid.rest_motion(), solid._body
    exact = (body.grid.positions @ (F - np.eye(len(F))).T).ravel()[body.free]
    noise = 5e-4 * np.random.default_rng(5).uniform(-1.0, 1.0, exact.size)
    return attrs.evolve(rest, displacement=exact + noise)


@PAIRS
@pytest.mark.parametrize("active", [0.0, 7e3])
def test_patch(shape, pair, active, distorted, held_at, equilibrium):
    """One modulus for all pairs: compressible, or of a finite bulk modulus, so that the pressure is kappa (J - 1)."""
    d, kappa = dimension(shape), 5e4 if "-" in pair else None
    F = gradient(d)
    solid = held_at(make(distorted, shape, pair, kappa), lambda X: X @ (F - np.eye(d)).T)
    motion = equilibrium(solid, tension(solid, active) if active else None, start=near(solid, F))
    _check_patch(solid, motion, F, 0.0 if kappa is None else kappa * (np.linalg.det(F) - 1.0), active)


@pytest.mark.parametrize("active", [0.0, 7e3])
@pytest.mark.parametrize(("shape", "pair"), [(shape, pairs[0]) for shape, pairs in SHAPES.items()])
def test_strictly_incompressible_patch(shape, pair, active, distorted, held_at, equilibrium):
    """The whole boundary is held: the level of the pressure is free, and one number of it is set to zero."""
    d = dimension(shape)
    F = gradient(d, determinant=1.0)
    solid = held_at(make(distorted, shape, pair, np.inf), lambda X: X @ (F - np.eye(d)).T)
    assert solid._body.enclosed
    motion = equilibrium(solid, tension(solid, active) if active else None, start=near(solid, F))
    _check_patch(solid, motion, F, 0.0, active)


def test_a_boundary_that_is_held_in_part_leaves_the_pressure_its_level(distorted):
    solid = attrs.evolve(make(distorted, "triangle", "P2-P1", np.inf), support=(Support(boundary="left"),))
    assert not solid._body.enclosed
    assert solid.rest_motion().multiplier.size == solid._body.grid.n_multipliers


def _check_patch(solid, motion, F, pressure, active):
    d, body = len(F), solid._body
    exact = (body.grid.positions @ (F - np.eye(d)).T).ravel()
    found = body.displacement(motion.displacement, 0.0)
    assert np.abs(exact[body.free]).max() > 1e-3, "something moves"
    assert np.abs(found - exact).max() < 1e-11 * 0.03 * 10.0
    direction = np.array((1.0, 0.5, -0.3)[:d])
    unit = direction / np.linalg.norm(direction)
    assert solid.stretch(motion.displacement, 0.0) == pytest.approx(np.linalg.norm(F @ unit), abs=1e-10)
    expected = stress(F, pressure, active, direction)[:d, :d]
    assert np.abs(mean_stress(solid, motion, active) - expected).max() < 1e-9 * np.abs(expected).max()
    if motion.multiplier.size and solid._body.grid.cell.multiplier != "P1disc":
        assert np.abs(motion.multiplier - pressure).max() < 1e-8 * MU


# --- what must not matter


@ANY_SHAPE
def test_rigid_motions_store_nothing_and_turn_the_forces(shape, distorted):
    """W(Q F) = W(F), and f(Q x) = Q f(x), tension included: exactly what objectivity says."""
    d, generator = dimension(shape), np.random.default_rng(3)
    solid = FiniteElement(
        mesh=distorted(shape), material=Guccione(), fibres=Constant(direction=(1.0, 0.5, -0.3)[:d]), bulk_modulus=3e4
    )
    Q = np.linalg.qr(generator.standard_normal((d, d)))[0]
    Q[:, 0] *= np.linalg.det(Q)
    X = solid._body.grid.positions
    moved = X + 1e-3 * generator.uniform(-1.0, 1.0, X.shape)
    turned = moved @ Q.T + 0.4
    pressure = 2e3 * generator.uniform(-1.0, 1.0, solid.rest_motion().multiplier.size)
    law = AffineLaw(np.full(solid.n_sites, 1.0), np.full(solid.n_sites, 6e3), np.full(solid.n_sites, 2e5))
    forces, energies, stretches = [], [], []
    for x in (moved, turned):
        u = (x - X).ravel()
        balance = solid.balance(Motion(u, 0.0 * u, pressure), law, 0.0)
        forces.append(balance.force.reshape(-1, d))
        energies.append(solid.elastic_energy(u))
        stretches.append(solid.stretch(u, 0.0))
        assert np.abs(forces[-1].sum(axis=0)).max() < 1e-12 * np.abs(forces[-1]).sum()
    assert np.abs(forces[1] - forces[0] @ Q.T).max() < 1e-11 * np.abs(forces[0]).max()
    assert energies[1] == pytest.approx(energies[0], rel=1e-10)
    assert energies[0] > 0.0
    assert np.abs(stretches[1] - stretches[0]).max() < 1e-13 * 10.0
    rigid = (X @ Q.T + 0.4 - X).ravel()
    assert abs(solid.elastic_energy(rigid)) < 1e-12 * energies[0]
    assert np.abs(solid.balance(Motion(rigid, 0.0 * rigid, 0.0 * pressure), None, 0.0).force).max() < 1e-9


@ANY_SHAPE
def test_threads_change_nothing_to_the_last_bit(shape, distorted):
    d = dimension(shape)
    cells = (12, 11) if d == 2 else (6, 5, 4)
    found = []
    for threads in (1, 2, 0):
        solid = FiniteElement(mesh=distorted(shape, cells), bulk_modulus=np.inf, material=NeoHooke(), threads=threads)
        assert len(solid._body.grid.blocks(0)[0]) > 1, "there is something to divide"
        u = 2e-4 * np.random.default_rng(0).uniform(-1.0, 1.0, solid.n_unknowns)
        p = 1e4 * np.random.default_rng(1).uniform(-1.0, 1.0, solid.rest_motion().multiplier.size)
        balance = solid.balance(Motion(u, 0.0 * u, p), tension(solid, 5e3), 0.0, tangent=True)
        found.append(
            (
                *(balance.force, balance.constraint, balance.stiffness.data, balance.constraint_gradient.data),
                np.array([solid.elastic_energy(u)]),
            )
        )
    for other in found[1:]:
        assert all(np.array_equal(left, right) for left, right in zip(found[0], other, strict=True))


@ANY_SHAPE
def test_the_order_of_the_cells_does_not_matter(shape, distorted, equilibrium):
    """Numbering differs: the bodies are compared where their nodes are."""
    places, values, volumes = [], [], []
    for shuffled in (False, True):
        solid = FiniteElement(
            mesh=distorted(shape, shuffled=shuffled),
            material=NeoHooke(shear_modulus=MU),
            bulk_modulus=np.inf,
            support=(Support(boundary="left"),),
            load=(Robin(boundary="right", normal=1e6),),
        )
        motion = equilibrium(solid, tension(solid, 4e3))
        positions = solid._body.grid.positions
        order = np.lexsort(np.round(positions, 9).T)
        full = solid._body.displacement(motion.displacement, 0.0).reshape(positions.shape)
        places.append(positions[order])
        values.append(full[order])
        volumes.append(solid.elastic_energy(motion.displacement))
    assert np.abs(places[0] - places[1]).max() < 1e-15
    assert np.abs(values[0]).max() > 1e-4
    assert np.abs(values[0] - values[1]).max() < 1e-9 * np.abs(values[0]).max()
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-9)
