"""Free bodies in random scenes: what a method promises to keep it keeps, and what must not matter does not.

A scene is a mesh (block or spindle, any size, any cells), an element pair, a material, a bulk modulus, fibres, an
activation, a step, and the throw that sets the body off: translation, rotation and a strain rate of constant volume.
Its heads pull from the first moment on, out of balance.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import Any

import attrs
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import myobridge as mb
from myobridge.bus import CouplingBus
from myobridge.interfaces import Array, MeshSource
from myobridge.ledger import Ledger
from myobridge.solvers import Ordinary
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.fibres.constant import Constant as Straight
from myobridge_plugins.fibres.harmonic import Harmonic
from myobridge_plugins.macro_solid.finite_element import discretisation
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.material.guccione import Guccione
from myobridge_plugins.material.holzapfel_ogden import HolzapfelOgden
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.material.transversely_isotropic import TransverselyIsotropic
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.mesh.spindle import Spindle
from myobridge_plugins.signal.constant import Constant
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.time_integrator.backward_euler import BackwardEuler
from myobridge_plugins.time_integrator.bdf2 import BDF2
from myobridge_plugins.time_integrator.energy_momentum import EnergyMomentum

TOLERANCE = 1e-9
STEPS = 4
SOLVER = Ordinary(tolerance=1e-12)
INTEGRATORS = {item.name: item.cls for item in mb.registry() if item.family == "time_integrator"}
MATERIALS = [MooneyRivlin(), NeoHooke(), Guccione(), TransverselyIsotropic(), HolzapfelOgden()]
CELLS = {2: ("triangle", "quadrilateral"), 3: ("tetrahedron", "hexahedron")}


@attrs.frozen
class Scene:
    """A free body, what its heads are told, the step [s], and the seed of its throw."""

    solid: FiniteElement
    model: Huxley
    activation: Any
    dt: float
    speed: float
    seed: int

    def velocity(self) -> Array:
        """Translation, rotation and strain at constant volume [m/s], all of about the same size."""
        random, places = np.random.default_rng(self.seed), self.solid._body.grid.positions
        d = places.shape[1]
        rate = random.normal(size=(d, d))
        rate -= np.trace(rate) / d * np.eye(d)
        centred = places - places.mean(axis=0)
        return (self.speed * (random.normal(size=d) + centred @ rate.T / np.ptp(places, axis=0).max())).ravel()

    def thrown(self, integrator: mb.TimeIntegrator) -> mb.Simulation:
        """Simulation of the body under way."""
        simulation = mb.Simulation(
            solid=self.solid,
            integrator=integrator,
            cross_bridges=self.model,
            activation=self.activation,
            dt=self.dt,
        )
        rest = simulation.motion
        simulation.motion = attrs.evolve(rest, velocity=self.velocity())
        kinetic = 0.5 * float(simulation.motion.velocity @ (self.solid.mass_matrix @ simulation.motion.velocity))
        simulation.ledger = Ledger(kinetic, 0.0, simulation.ledger.cross_bridge)
        return simulation


@st.composite
def meshes(draw: st.DrawFn) -> MeshSource:
    """Block or spindle of 10 to 100 mm, a few cells of any shape, lanes of a batch full or not."""
    d = draw(st.sampled_from([2, 2, 3]))
    shape = draw(st.sampled_from(CELLS[d]))
    length = draw(st.floats(0.01, 0.1))
    if d == 2 and draw(st.booleans()):
        width = length * draw(st.floats(0.2, 0.5))
        cells = draw(st.integers(2, 4))
        return Spindle(length=length, width=width, end_width=0.6 * width, cells=cells, across=1, shape=shape)
    size = [length, *(length * draw(st.floats(0.3, 1.0)) for _ in range(d - 1))]
    most = 3 if d == 2 else 1
    return Block(size=tuple(size), cells=(draw(st.integers(1, most)), draw(st.integers(1, most)), 1)[:d], shape=shape)


@st.composite
def scenes(draw: st.DrawFn, bulk_moduli: tuple[float | None, ...] = (math.inf, 1e9, 1e5, None)) -> Scene:
    """A free body in a random scene."""
    mesh = draw(meshes())
    d = 3 if isinstance(mesh, Block) and len(mesh.size) == 3 else 2
    seed = draw(st.integers(0, 2**32 - 1))
    direction = np.random.default_rng(seed).normal(size=d)
    fibres = draw(st.sampled_from([Straight(direction=tuple(direction)), Harmonic(start="left", end="right")]))
    level = draw(st.floats(0.0, 1.0))
    activation = draw(
        st.sampled_from(
            [
                Constant(level=level),
                Ramp(initial=level, final=1.0, end=5e-3),
                Sine(offset=0.5, amplitude=0.5 * level, frequency=50.0),
            ]
        )
    )
    solid = FiniteElement(
        mesh=mesh,
        material=draw(st.sampled_from(MATERIALS)),
        fibres=fibres,
        bulk_modulus=draw(st.sampled_from(bulk_moduli)),
        density=draw(st.floats(500.0, 2000.0)),
    )
    model = Huxley(bins=8, low=-4.0, high=8.0, p_max=10.0 ** draw(st.floats(3.0, math.log10(73e3))))
    dt = 10.0 ** draw(st.floats(-4.0, math.log10(5e-3)))
    return Scene(solid, model, activation, dt, draw(st.floats(0.1, 1.0)), seed)


def stepped(simulation, steps=STEPS):
    """Simulation after each step."""
    for _ in range(steps):
        simulation.step()
        yield simulation


# --- what is kept


def momenta_kept(scene, simulation, *, angular) -> None:
    solid, start = scene.solid, simulation.motion
    linear, turning = solid.momentum(start), solid.angular_momentum(start)
    mass, speed = float(solid._node_mass.sum()), np.abs(start.velocity).max()
    length = np.ptp(solid._body.grid.positions, axis=0).max()
    for _ in stepped(simulation):
        now = simulation.motion
        speed = max(speed, np.abs(now.velocity).max())
        assert np.abs(solid.momentum(now) - linear).max() <= TOLERANCE * mass * speed
        if angular:
            assert np.abs(solid.angular_momentum(now) - turning).max() <= TOLERANCE * mass * speed * length
    assert np.abs(simulation.motion.displacement).max() > 1e-2 * scene.speed * simulation.time, "it moved"
    assert np.abs(linear).max() > 1e-3 * mass * scene.speed


@given(scene=scenes())
@settings(max_examples=25)
def test_momenta_of_a_free_body(scene):
    momenta_kept(scene, scene.thrown(EnergyMomentum(newton=SOLVER)), angular=True)


OTHERS = [
    name for name, cls in sorted(INTEGRATORS.items()) if "momentum" in cls.conserves and cls is not EnergyMomentum
]


@pytest.mark.parametrize("name", OTHERS)
@given(data=st.data())
@settings(max_examples=6)
def test_momenta_that_other_methods_promise(name, data):
    cls = INTEGRATORS[name]
    free = name in ("symplectic_euler", "stoermer_verlet")  # they know no constraint
    scene = data.draw(scenes((None,) if free else (math.inf, 1e9, None)))
    # What survives a shock is another question: firm tissue, and heads that pull gently.
    firm = attrs.evolve(scene.solid, material=MooneyRivlin())
    scene = attrs.evolve(scene, solid=firm, model=attrs.evolve(scene.model, p_max=1e3))
    if cls.explicit:
        scene = attrs.evolve(scene, dt=2e-6)
    momenta_kept(scene, scene.thrown(cls()), angular="angular_momentum" in cls.conserves)


def test_backward_euler_does_not_keep_the_angular_momentum():
    """What is not promised is not kept: the checks above can fail."""
    scene = Scene(
        FiniteElement(mesh=Block(size=(0.05, 0.02), cells=(2, 1)), material=NeoHooke(), bulk_modulus=math.inf),
        Huxley(bins=8),
        Constant(level=1.0),
        2e-3,
        1.0,
        0,
    )
    simulation = scene.thrown(BackwardEuler(newton=SOLVER))
    before = scene.solid.angular_momentum(simulation.motion)
    simulation.run(0.02)
    after = scene.solid.angular_momentum(simulation.motion)
    assert np.abs(after - before).max() > 1e-4 * np.abs(before).max()


# --- energy


# Its guess stretches fibres that stiffen exponentially: the residual there is a hundred thousand times the forces.
BAD_GUESS = Scene(
    FiniteElement(
        mesh=Block(size=(0.01, 0.01), cells=(1, 1)),
        material=HolzapfelOgden(),
        fibres=Straight(direction=(0.18905338179353307, -0.5227484414807474)),
        bulk_modulus=math.inf,
        density=911.0,
    ),
    Huxley(bins=8, low=-4.0, high=8.0, p_max=1e3),
    Constant(level=0.0),
    0.004216965034285823,
    1.0,
    2,
)


@given(scene=scenes())
@example(scene=BAD_GUESS)
@settings(max_examples=25)
def test_energy_comes_from_attachment_and_goes_with_detachment(scene):
    """Energy-momentum: neither created nor lost in any step."""
    simulation = scene.thrown(EnergyMomentum(newton=SOLVER))
    start = simulation.ledger.kinetic
    kinetic = [start]
    for _ in stepped(simulation):
        assert abs(simulation.ledger.residual) <= TOLERANCE
        kinetic.append(simulation.ledger.kinetic)
    assert abs(simulation.ledger.drift) <= TOLERANCE
    assert simulation.ledger.external == 0.0
    assert np.ptp(kinetic) > 1e-8 * start, "energy was exchanged"


@given(scene=scenes())
@settings(max_examples=15)
def test_backward_euler_creates_no_energy_in_any_step(scene):
    """Observed, not proven: its constraint and its fibres are not linear in the displacement."""
    simulation = scene.thrown(BackwardEuler(newton=SOLVER))
    for _ in stepped(simulation):
        assert simulation.ledger.residual <= TOLERANCE


@given(scene=scenes())
@settings(max_examples=10)
def test_bdf2_never_has_more_energy_than_came_in(scene):
    """Observed as well. It may give back in one step what it took before, but never more."""
    simulation = scene.thrown(BDF2(newton=SOLVER))
    for _ in stepped(simulation, 2 * STEPS):
        assert simulation.ledger.drift <= TOLERANCE


@given(scene=scenes())
@settings(max_examples=20)
def test_power_through_the_bus_is_balanced(scene):
    """What the fibres do on the solid, found from the solid's energies alone, is what sliding takes from the heads."""
    simulation = scene.thrown(EnergyMomentum(newton=SOLVER))
    ledger, scale, worked = simulation.ledger, simulation.ledger.total, 0.0
    for _ in range(STEPS):
        solid, heads, numerical = ledger.kinetic + ledger.elastic, ledger.cross_bridge, ledger.numerical
        simulation.step()
        totals = simulation.bus.totals
        scale = max(scale, ledger.total)
        gained = ledger.kinetic + ledger.elastic - solid - (ledger.numerical - numerical - totals.numerical)
        assert abs(gained + totals.work) <= TOLERANCE * scale
        taken = ledger.cross_bridge - heads - totals.attached + totals.detached - totals.numerical
        assert abs(taken - totals.work) <= TOLERANCE * scale
        worked = max(worked, abs(totals.work))
    assert worked > 1e-12 * scale


# --- what must not matter


def _in_any_order(solid: FiniteElement, seed: int) -> FiniteElement:
    """The same body with its cells, nodes and sites numbered at random, and not along a curve."""
    random, other = np.random.default_rng(seed), attrs.evolve(solid)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(discretisation, "_curve", lambda centres, cells: random.permutation(cells.size))
        assert other._body.n_sites == solid.n_sites
    return other


@given(scene=scenes(), seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15)
def test_the_order_of_the_sites_does_not_matter(scene, seed):
    """Other numbers, other lanes, other neighbours in a batch; compared where nodes and sites are."""
    found = []
    places = scene.solid._body.grid.positions, _sites(scene.solid)
    for solid in (scene.solid, _in_any_order(scene.solid, seed)):
        simulation = attrs.evolve(scene, solid=solid).thrown(EnergyMomentum(newton=SOLVER))
        for _ in stepped(simulation):
            pass
        nodes = solid._body.grid.positions
        moved = simulation.motion.displacement.reshape(nodes.shape)[_nearest(nodes, places[0])]
        heads = simulation.bus.moments()[_nearest(_sites(solid), places[1])]
        found.append((moved, heads, simulation.ledger.entries()))
    (first, heads, ledger), (second, other_heads, other_ledger) = found
    assert np.abs(first).max() > 1e-2 * scene.speed * scene.dt
    assert np.abs(first - second).max() <= TOLERANCE * np.abs(first).max()
    assert np.abs(heads - other_heads).max() <= 1e-7 * max(np.abs(heads).max(), 1e-3)
    for name in ("kinetic", "elastic", "attached", "detached"):
        assert other_ledger[name] == pytest.approx(ledger[name], rel=1e-7, abs=1e-9 * ledger["kinetic"]), name


def _sites(solid: FiniteElement) -> Array:
    """Places of the sites, a little towards the middle of their cells: some lie on a face, where another one lies."""
    places, cells = solid.site_positions(), solid._body.grid.cell_of_point[: solid.n_sites]
    middle = np.stack([np.bincount(cells, x) / np.bincount(cells) for x in places.T], axis=1)
    return places + 0.1 * (middle[cells] - places)


def _nearest(places: Array, sought: Array) -> np.ndarray:
    """Numbers of the places where the sought ones are; they differ by round-off."""
    distance, numbers = cKDTree(places).query(sought)
    assert distance.max() < 1e-9 * np.ptp(places)
    assert np.unique(numbers).size == len(places)
    return numbers


@functools.cache
def path_of_a_body() -> tuple[mb.Simulation, list[Array], Array]:
    """A contraction, the stretches at the end of its steps, and those at the start."""
    solid = FiniteElement(mesh=Block(size=(0.05, 0.02), cells=(3, 1)), material=NeoHooke(), bulk_modulus=math.inf)
    scene = Scene(solid, Huxley(bins=16), Ramp(initial=0.2, final=1.0, end=5e-3), 1e-3, 0.5, 3)
    simulation = scene.thrown(EnergyMomentum(newton=SOLVER))
    start = simulation.bus.stretch.copy()
    return simulation, [simulation.bus.stretch.copy() for _ in stepped(simulation, 6)], start


@given(sizes=st.lists(st.integers(1, 23), min_size=4, max_size=20))
@settings(max_examples=20)
def test_the_size_of_a_batch_does_not_matter(sizes):
    """Sites in batches of any sizes, along the same path: the same heads to the last bit."""
    simulation, path, start = path_of_a_body()
    volumes, n = simulation.solid.site_volumes, simulation.solid.n_sites
    cuts = [0, *(cut for cut in np.cumsum(sizes) if cut < n), n]
    assert np.ptp(path[-1]) * simulation.bus.model.gear > 0.1
    for first, last in itertools.pairwise(cuts):
        here = slice(first, last)
        bus = CouplingBus(
            simulation.bus.model, volumes[here], start[here], activation=Ramp(initial=0.2, final=1.0, end=5e-3)
        )
        for number, stretch in enumerate(path):
            bus.begin(1e-3 * number, 1e-3)
            bus.react(5e-4)
            bus.slide(stretch[here])
            bus.react(5e-4)
            bus.commit()
        np.testing.assert_array_equal(bus.population, simulation.bus.population[here])


@pytest.mark.parametrize("cells", [(12, 11), (4, 3, 3)], ids=["2D", "3D"])
def test_the_number_of_threads_does_not_matter(cells):
    """To the last bit, with blocks to share out and lanes that are not full."""
    d, found = len(cells), []
    for threads in (1, 2):
        solid = FiniteElement(
            mesh=Block(size=(0.05, 0.03, 0.03)[:d], cells=cells),
            material=NeoHooke(),
            bulk_modulus=math.inf,
            viscosity=10.0,
            threads=threads,
        )
        assert len(solid._body.grid.blocks(0)[0]) > 1, "there is something to share out"
        scene = Scene(solid, Huxley(bins=8), Constant(level=1.0), 1e-3, 0.5, 1)
        simulation = scene.thrown(EnergyMomentum(newton=SOLVER))
        simulation.step()
        found.append((simulation.motion.displacement, simulation.motion.multiplier, simulation.bus.population))
    assert np.abs(found[0][0]).max() > 1e-4
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)
