"""Loads: resultants in closed form, follower pressure on closed surfaces, stiffness, energy, messages."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem.quadrature import get_quadrature

from myobridge.build import build
from myobridge.errors import ParameterError
from myobridge.interfaces import Surface
from myobridge.registry import registry
from myobridge_plugins.load.normals import unit_normals

ELEMENTS = {"edge": skfem.ElementLineP2(), "triangle": skfem.ElementTriP2(), "quad": skfem.ElementQuad2()}
# Follower pressure on quadrilaterals: a product of three biquadratics, of degree 6 in each coordinate at most.
POINTS, WEIGHTS = {}, {}
for _kind, _element in ELEMENTS.items():
    POINTS[_kind], WEIGHTS[_kind] = get_quadrature(_element.refdom, 12)
SHAPES, SLOPES, NODES = {}, {}, {}
for _kind, _element in ELEMENTS.items():
    _nodes = np.array(_element.doflocs, dtype=np.float64)
    _values = [_element.lbasis(POINTS[_kind], i) for i in range(len(_nodes))]
    NODES[_kind] = _nodes
    SHAPES[_kind] = np.stack([value for value, _ in _values], axis=1)
    SLOPES[_kind] = np.stack([np.atleast_2d(slope).T for _, slope in _values], axis=1)


def load(name, **parameters):
    return build(registry(), "load", {"plugin": name, "boundary": "face", **parameters})


def surface(kind, positions, thickness=1.0):
    """Facets of one kind at given nodes, with their reference areas."""
    tangents = np.einsum("pad,fai->fpdi", SLOPES[kind], positions)
    if kind == "edge":
        size = thickness * np.linalg.norm(tangents[:, :, 0], axis=2)
    else:
        size = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
    return Surface("face", positions, SHAPES[kind], SLOPES[kind], WEIGHTS[kind], WEIGHTS[kind] * size, thickness)


def random_facets(kind, seed, curved, n=4):
    """Facets somewhere in space, flat or with every node moved."""
    generator = np.random.default_rng(seed)
    local = NODES[kind]
    dim = local.shape[1] + 1
    positions = local @ generator.standard_normal((n, dim - 1, dim)) + generator.standard_normal((n, 1, dim))
    if curved:
        positions = positions + 0.1 * generator.standard_normal(positions.shape)
    return surface(kind, positions, 0.3 if kind == "edge" else 1.0)


def ball(generator, amplitude=0.05):
    """Closed surface: a tetrahedron with six-node faces, all ten nodes moved; and the nodes of each face."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64)
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    nodes = np.vstack([corners, [0.5 * (corners[i] + corners[j]) for i, j in pairs]])
    nodes = nodes + amplitude * generator.uniform(-1.0, 1.0, nodes.shape)
    place = {frozenset(pair): 4 + k for k, pair in enumerate(pairs)}
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    # Nodes of scikit-fem's triangle: corners, then the middles of (0, 1), (1, 2), (0, 2).
    table = np.array([[a, b, c, *(place[frozenset(pair)] for pair in ((a, b), (b, c), (a, c)))] for a, b, c in faces])
    return nodes, table


def box(generator, amplitude=0.1):
    """Closed surface: a cube with nine-node faces on a lattice of 3 x 3 x 3 nodes, all moved."""
    lattice = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    table = []
    for axis in range(3):
        for side in (0.0, 1.0):
            first, second = ((axis + 1) % 3, (axis + 2) % 3)[:: 1 if side else -1]
            place = np.zeros((9, 3))
            place[:, axis], place[:, first], place[:, second] = side, NODES["quad"][:, 0], NODES["quad"][:, 1]
            table.append([int(np.argmin(np.sum((lattice - one) ** 2, axis=1))) for one in place])
    return lattice + amplitude * generator.uniform(-1.0, 1.0, lattice.shape), np.array(table)


def ring(generator, n=7):
    """Closed line: a polygon of three-node edges, run through with the inside on the left."""
    angle = 2.0 * np.pi * np.arange(2 * n) / (2 * n)
    nodes = np.stack([np.cos(angle), np.sin(angle)], axis=1) * generator.uniform(0.8, 1.2, (2 * n, 1))
    corner = 2 * np.arange(n)
    return nodes, np.stack([corner, (corner + 2) % (2 * n), corner + 1], axis=1)


CLOSED = {"edge": ring, "triangle": ball, "quad": box}
KINDS = pytest.mark.parametrize("kind", ELEMENTS)
SEEDS = st.integers(0, 2**32 - 1)


def enclosed(kind, facets, displacement):
    """Volume inside a closed surface (2D: area times thickness), by the divergence of x / dim."""
    deformed = facets.positions + displacement
    tangents = np.einsum("pad,fai->fpdi", facets.slopes, deformed)
    if kind == "edge":
        normal = facets.thickness * np.stack([tangents[:, :, 0, 1], -tangents[:, :, 0, 0]], axis=2)
    else:
        normal = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    place = np.einsum("pa,fai->fpi", facets.shapes, deformed)
    return np.einsum("p,fpi,fpi", facets.weights, place, normal) / facets.dimension


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS, curved=st.booleans())
def test_resultants_of_dead_loads(kind, seed, curved):
    facets = random_facets(kind, seed, curved)
    area = facets.areas.sum()
    generator = np.random.default_rng(seed + 1)
    displacement = generator.standard_normal(facets.positions.shape)
    vector = generator.standard_normal(facets.dimension)
    gravity = np.eye(facets.dimension)[-1] * -9.81
    for what, expected in (
        (load("traction", traction=vector), vector * area),
        (load("force", force=vector), vector),
        (load("hanging_mass", mass=2.5), 2.5 * gravity),
        (load("hanging_mass", mass=2.5, gravity=vector), 2.5 * vector),
    ):
        force = what.nodal_force(facets, displacement, 0.0)
        assert force.shape == facets.positions.shape
        np.testing.assert_allclose(force.sum(axis=(0, 1)), expected, rtol=1e-12, atol=1e-13 * np.abs(expected).max())
        # Dead: neither the displacement nor the time matters, and there is no stiffness.
        assert what.dead
        np.testing.assert_array_equal(what.nodal_force(facets, 0.0 * displacement, 3.0), force)
        assert what.nodal_stiffness(facets, displacement, 0.0) is None
        assert what.energy(facets, displacement) == 0.0


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS)
def test_a_uniform_traction_on_a_flat_facet_acts_at_its_middle(kind, seed):
    facets = random_facets(kind, seed, curved=False, n=1)
    vector = np.random.default_rng(seed).standard_normal(facets.dimension)
    force = load("traction", traction=vector).nodal_force(facets, np.zeros_like(facets.positions), 0.0)
    corners = facets.positions[0][np.all(np.isin(NODES[kind], (0.0, 1.0)), axis=1)]
    moment = np.einsum("fai,faj->ij", facets.positions, force)
    expected = facets.areas.sum() * np.outer(corners.mean(axis=0), vector)
    np.testing.assert_allclose(moment, expected, atol=1e-12 * np.abs(expected).max())


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS, curved=st.booleans())
def test_the_mass_has_its_inertia(kind, seed, curved):
    facets = random_facets(kind, seed, curved)
    mass = load("hanging_mass", mass=2.5).nodal_mass(facets)
    n_nodes = facets.positions.shape[1]
    assert mass.shape == (4, n_nodes, n_nodes)
    assert mass.sum() == pytest.approx(2.5, rel=1e-13)
    np.testing.assert_allclose(mass, mass.transpose(0, 2, 1), atol=1e-15 * mass.max())
    assert np.linalg.eigvalsh(mass).min() > 0.0
    # The weight is the mass times gravity, node by node.
    weight = load("hanging_mass", mass=2.5).nodal_force(facets, np.zeros_like(facets.positions), 0.0)
    np.testing.assert_allclose(weight[:, :, -1], -9.81 * mass.sum(axis=2), rtol=1e-12, atol=1e-14)
    assert load("traction", traction=[1.0] * facets.dimension).nodal_mass(facets) is None


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS)
def test_pressure_on_a_closed_surface(kind, seed):
    """No resultant, no torque; the work of inflation is pressure times volume; the stiffness is that of an energy."""
    generator = np.random.default_rng(seed)
    nodes, table = CLOSED[kind](generator)
    facets = surface(kind, nodes[table], 0.3 if kind == "edge" else 1.0)
    moved = 0.1 * generator.standard_normal(nodes.shape)
    follower = load("pressure", pressure=700.0)
    force = follower.nodal_force(facets, moved[table], 0.0)
    total, size = np.zeros_like(nodes), np.abs(force).max()
    np.add.at(total, table, force)
    np.testing.assert_allclose(total.sum(axis=0), 0.0, atol=1e-12 * size)
    moment = np.einsum("ai,aj->ij", nodes + moved, total)
    np.testing.assert_allclose(moment, moment.T, atol=1e-12 * size)
    assert enclosed(kind, facets, 0.0) > 0.0
    volume = enclosed(kind, facets, moved[table])
    np.testing.assert_allclose(moment, -700.0 * volume * np.eye(facets.dimension), atol=1e-11 * size)
    stiffness = np.zeros((*nodes.shape, *nodes.shape))
    np.add.at(
        stiffness.transpose(0, 2, 1, 3),
        (table[:, :, None], table[:, None, :]),
        follower.nodal_stiffness(facets, moved[table], 0.0).transpose(0, 1, 3, 2, 4),
    )
    np.testing.assert_allclose(stiffness, stiffness.transpose(2, 3, 0, 1), atol=1e-12 * size)
    assert np.abs(stiffness).max() > 0.01 * size


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS, curved=st.booleans())
def test_stiffness_is_the_derivative_of_the_force(kind, seed, curved):
    """Forces are at most quadratic in the displacement, so central differences are exact."""
    facets = random_facets(kind, seed, curved)
    displacement = np.random.default_rng(seed).standard_normal(facets.positions.shape)
    for what in (load("pressure", pressure=-40.0), load("robin", normal=30.0, tangential=7.0)):
        assert not what.dead
        stiffness = what.nodal_stiffness(facets, displacement, 0.0)
        found = np.empty_like(stiffness)
        for node, axis in np.ndindex(*facets.positions.shape[1:]):
            step = np.zeros_like(displacement)
            step[:, node, axis] = 0.5
            ahead, behind = (what.nodal_force(facets, displacement + sign * step, 0.0) for sign in (1, -1))
            found[:, :, :, node, axis] = behind - ahead
        np.testing.assert_allclose(stiffness, found, atol=1e-12 * np.abs(stiffness).max())


def test_pressure_pushes_inwards():
    """On the right edge of a 2D body, of length 2 and depth 0.3, and on the upper face of a 3D one of area 6."""
    edge = surface("edge", np.array([[[1.0, 0.0], [1.0, 2.0], [1.0, 1.0]]]), 0.3)
    force = load("pressure", pressure=10.0).nodal_force(edge, np.zeros((1, 3, 2)), 0.0)
    np.testing.assert_allclose(force.sum(axis=(0, 1)), [-6.0, 0.0], atol=1e-14)
    # Simpson's weights of the three nodes.
    np.testing.assert_allclose(force[0, :, 0], [-1.0, -1.0, -4.0], atol=1e-14)
    face = surface("quad", np.column_stack([2.0 * NODES["quad"][:, 0], 3.0 * NODES["quad"][:, 1], np.zeros(9)])[None])
    force = load("pressure", pressure=10.0).nodal_force(face, np.zeros((1, 9, 3)), 0.0)
    np.testing.assert_allclose(force.sum(axis=(0, 1)), [0.0, 0.0, -60.0], atol=1e-13)
    # Stretched twice along x, the face is twice as large and so is the force.
    stretched = np.zeros((1, 9, 3))
    stretched[0, :, 0] = face.positions[0, :, 0]
    force = load("pressure", pressure=10.0).nodal_force(face, stretched, 0.0)
    np.testing.assert_allclose(force.sum(axis=(0, 1)), [0.0, 0.0, -120.0], atol=1e-13)


@KINDS
@settings(max_examples=10)
@given(seed=SEEDS, curved=st.booleans())
def test_bedding_stores_the_work_that_it_takes(kind, seed, curved):
    facets = random_facets(kind, seed, curved)
    normals = unit_normals(facets)
    bedding = load("robin", normal=30.0, tangential=7.0)
    uniform = np.random.default_rng(seed).standard_normal(facets.dimension)
    displacement = np.broadcast_to(uniform, facets.positions.shape)
    along = normals @ uniform
    expected = 0.5 * np.sum(facets.areas * (30.0 * along**2 + 7.0 * (uniform @ uniform - along**2)))
    assert bedding.energy(facets, displacement) == pytest.approx(expected, rel=1e-12)
    force = bedding.nodal_force(facets, displacement, 0.0)
    pushed = facets.areas[:, :, None] * (7.0 * uniform + 23.0 * along[:, :, None] * normals)
    np.testing.assert_allclose(force.sum(axis=(0, 1)), -pushed.sum(axis=(0, 1)), rtol=1e-11, atol=1e-12)


def test_scale_is_a_function_of_time():
    ramp = {"plugin": "ramp", "initial": 0.0, "final": 2.0, "start": 1.0, "end": 3.0}
    facets = random_facets("triangle", 0, curved=True)
    still = np.zeros_like(facets.positions)
    for name, parameters in (
        ("traction", {"traction": [1.0, 2.0, 3.0]}),
        ("force", {"force": [1.0, 2.0, 3.0]}),
        ("pressure", {"pressure": 4.0}),
    ):
        plain, scaled = load(name, **parameters), load(name, **parameters, scale=ramp)
        for time, share in ((0.0, 0.0), (1.5, 0.5), (2.0, 1.0), (9.0, 2.0)):
            expected = share * plain.nodal_force(facets, still, time)
            np.testing.assert_allclose(scaled.nodal_force(facets, still, time), expected, rtol=1e-14)
        assert (plain.jumps(), scaled.jumps()) == ((), (1.0, 3.0))
    stiffness = scaled.nodal_stiffness(facets, still, 1.5)
    np.testing.assert_allclose(stiffness, 0.5 * plain.nodal_stiffness(facets, still, 1.5), rtol=1e-14)
    many = load("pressure", pressure=4.0, scale={"plugin": "constant", "level": [1.0, 2.0]})
    with pytest.raises(ParameterError, match="scale: has 2 values; expected one for the whole boundary"):
        many.nodal_force(facets, still, 0.0)


@pytest.mark.parametrize(
    ("name", "parameters", "key"),
    [
        ("traction", {"traction": [1.0, 2.0]}, "traction"),
        ("traction", {"traction": 5.0}, "traction"),
        ("force", {"force": [1.0, 2.0]}, "force"),
        ("hanging_mass", {"mass": 1.0, "gravity": [0.0, -9.81]}, "gravity"),
    ],
)
def test_the_wrong_dimension_is_told(name, parameters, key):
    facets = random_facets("triangle", 0, curved=False)
    said = rf"{key}: is .*; boundary 'face' is that of a 3D body: expected a list of 3 numbers"
    with pytest.raises(ParameterError, match=said):
        load(name, **parameters).nodal_force(facets, np.zeros_like(facets.positions), 0.0)


def test_what_is_missing_is_told():
    with pytest.raises(ParameterError, match="boundary: is missing"):
        build(registry(), "load", {"plugin": "pressure", "pressure": 1.0})
    with pytest.raises(ParameterError, match=r"mass: is -1.0; expected a number in \[0, inf\) \[kg\]"):
        load("hanging_mass", mass=-1.0)
