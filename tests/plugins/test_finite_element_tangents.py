r"""Derivatives of the finite-element solid: nothing is believed that differences do not confirm.

.. math:: f = \frac{\partial}{\partial u} \Bigl(W + \int \psi(\lambda) + \int p (J - 1)\Bigr), \qquad
          K = \frac{\partial f}{\partial u}, \qquad B = \frac{\partial c}{\partial u}, \qquad
          \sum_i V_i T_i \dot\lambda_i = f_{act} \cdot v
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from myobridge.interfaces import ActiveLaw, AffineLaw, LawValue, Motion
from myobridge_plugins.fibres.constant import Constant
from myobridge_plugins.load.pressure import Pressure
from myobridge_plugins.load.robin import Robin
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.guccione import Guccione
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.signal.ramp import Ramp

ANY_SHAPE = pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=5)


class Viscous(ActiveLaw):
    """T = 8e3 lambda^2 + 3e2 lambda' + 40 lambda lambda' [Pa]: depends on stretch and rate, and has no potential."""

    def evaluate(self, stretch, stretch_rate):
        tension = 8e3 * stretch**2 + (3e2 + 40.0 * stretch) * stretch_rate
        return LawValue(tension, 16e3 * stretch + 40.0 * stretch_rate, 3e2 + 40.0 * stretch)

    def scaled(self, factor):
        raise NotImplementedError


def make(distorted, shape, **changed):
    """A body with everything at once: two loads, of which one follows, a moving support, fibres along no axis."""
    flat = shape in ("triangle", "quadrilateral")
    given = {
        "mesh": distorted(shape),
        "material": MooneyRivlin(),
        "fibres": Constant(direction=(1.0, 0.5, -0.3)[: 2 if flat else 3]),
        "support": (Support(boundary="left", displacement=1e-4, scale=Ramp(slope=1.0)),),
        "load": (Pressure(boundary="top", pressure=2e4), Robin(boundary="right", normal=1e6, tangential=4e5)),
        "bulk_modulus": 3e5,
        "thickness": 0.7,
    }
    return FiniteElement(**(given | changed))


def somewhere(solid, seed, amplitude=4e-4):
    """A random motion, deformed by a few per cent."""
    generator = np.random.default_rng(seed)
    rest = solid.rest_motion()
    u = amplitude * generator.uniform(-1.0, 1.0, rest.displacement.size)
    v = 0.01 * generator.uniform(-1.0, 1.0, u.size)
    return Motion(u, v, 1e4 * generator.uniform(-1.0, 1.0, rest.multiplier.size))


def affine(solid, seed):
    generator = np.random.default_rng(seed)
    return AffineLaw(*(generator.uniform(low, high, solid.n_sites) for low, high in ((0.9, 1.1), (0, 2e4), (0, 4e5))))


def difference(function, at, direction, step):
    """Fourth-order central difference of `function` along `direction`."""
    values = [function(at + k * step * direction) for k in (-2.0, -1.0, 1.0, 2.0)]
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)


def close(found, expected, relative):
    assert np.linalg.norm(expected) > 0.0
    error = np.linalg.norm(found - expected) / np.linalg.norm(expected)
    assert error < relative, f"relative error {error:.2e}"


def turning(solid, motion, du):
    """What the stiffness leaves out: how the rate at a given velocity changes as fibres turn, as a force."""
    u, v = motion.displacement, motion.velocity
    changes = difference(lambda x: solid.stretch_rate(x, v, 0.5), u, du, 2e-7)
    stretch = solid.stretch(u, 0.5)
    sensitivity = Viscous().evaluate(stretch, 0.0 * stretch).rate_sensitivity
    law = AffineLaw(stretch, sensitivity * changes, 0.0 * stretch)
    return solid.balance(motion, law, 0.5).force - solid.balance(motion, None, 0.5).force


@ANY_SHAPE
@pytest.mark.parametrize("law", ["none", "affine", "viscous"])
@given(SEEDS)
@FEW
def test_tangents_are_derivatives(shape, law, distorted, seed):
    """Of force and constraint by displacement, multiplier and velocity, with all terms present.

    A random direction at a random point; the steps are those at which truncation and round-off are both about 1e-10.
    """
    solid = make(distorted, shape)
    motion = somewhere(solid, seed)
    active = {"none": None, "affine": affine(solid, seed), "viscous": Viscous()}[law]
    generator = np.random.default_rng(seed + 1)
    du, dp = (generator.uniform(-1.0, 1.0, x.size) for x in (motion.displacement, motion.multiplier))

    def at(**changed):
        return solid.balance(attrs.evolve(motion, **changed), active, 0.5)

    found = solid.balance(motion, active, 0.5, tangent=True)
    u, v, p = motion.displacement, motion.velocity, motion.multiplier
    assert not found.symmetric
    close(found.force, at().force, 1e-13)  # two compiled functions of the material: the same to round-off
    push = found.stiffness @ du
    if law == "viscous":
        push = push + turning(solid, motion, du)
    close(push, difference(lambda x: at(displacement=x).force, u, du, 2e-7), 1e-8)
    close(found.constraint_gradient @ du, difference(lambda x: at(displacement=x).constraint, u, du, 2e-7), 1e-8)
    close(found.constraint_gradient.T @ dp, difference(lambda x: at(multiplier=x).force, p, dp, 1.0), 1e-8)
    close(found.constraint_compliance @ dp, -difference(lambda x: at(multiplier=x).constraint, p, dp, 1e3), 1e-6)
    if law == "viscous":
        close(found.damping @ du, difference(lambda x: at(velocity=x).force, v, du, 1e-3), 1e-8)
        assert solid.balance(motion, active, 0.5, rate=False, tangent=True).damping is None
    else:
        assert found.damping is None


@ANY_SHAPE
def test_only_loads_that_follow_make_the_tangent_unsymmetric(shape, distorted):
    for loads, symmetric in (
        ((Robin(boundary="top", normal=1e6),), True),
        ((Pressure(boundary="top", pressure=2e4),), False),
    ):
        solid = make(distorted, shape, load=loads)
        found = solid.balance(somewhere(solid, 1), affine(solid, 1), 0.5, tangent=True)
        assert found.symmetric == symmetric
        skew = abs(found.stiffness - found.stiffness.T).max() / abs(found.stiffness).max()
        assert skew < 1e-13 if symmetric else skew > 1e-5
        external = solid.external_stiffness(somewhere(solid, 1).displacement, 0.5)
        assert (external is None) == symmetric


@ANY_SHAPE
@given(SEEDS)
@FEW
def test_force_is_the_gradient_of_the_energy(shape, distorted, seed):
    """Energy of tissue and bedding, potential of the law, and the constraint's share, in exact quadrature."""
    solid = make(distorted, shape, load=(Robin(boundary="right", normal=1e6, tangential=4e5),), bulk_modulus=np.inf)
    motion, law = somewhere(solid, seed), affine(solid, seed)
    du = np.random.default_rng(seed + 1).uniform(-1.0, 1.0, solid.n_unknowns)

    def energy(u):
        constraint = solid.balance(attrs.evolve(motion, displacement=u), None, 0.5).constraint
        fibres = solid.site_volumes @ law.potential(solid.stretch(u, 0.5))
        return solid.elastic_energy(u, 0.5) + fibres + motion.multiplier @ constraint

    force = solid.balance(motion, law, 0.5).force
    expected = difference(energy, motion.displacement, du, 2e-6)
    assert force @ du == pytest.approx(expected, rel=1e-8, abs=1e-9 * np.linalg.norm(force) * np.linalg.norm(du))


@ANY_SHAPE
@given(SEEDS)
@FEW
def test_bulk_energy_is_that_of_the_pressure_it_makes(shape, distorted, seed):
    """With p = kappa Pi (J - 1) the constraint holds, and the gradient of the energy is the force."""
    solid = make(distorted, shape, load=())
    motion = somewhere(solid, seed)
    softness = solid.balance(motion, None, 0.0, tangent=True).constraint_compliance

    def obeyed(u):
        import scipy.sparse.linalg as linalg

        gap = solid.balance(attrs.evolve(motion, displacement=u, multiplier=0.0 * motion.multiplier), None, 0.5)
        return linalg.spsolve(softness.tocsc(), gap.constraint)

    there = attrs.evolve(motion, multiplier=obeyed(motion.displacement))
    balance = solid.balance(there, None, 0.5)
    assert np.linalg.norm(balance.constraint) < 1e-13 * balance.constraint_magnitude
    du = np.random.default_rng(seed + 1).uniform(-1.0, 1.0, solid.n_unknowns)
    expected = difference(lambda u: solid.elastic_energy(u, 0.5), motion.displacement, du, 2e-6)
    scale = np.linalg.norm(balance.force) * np.linalg.norm(du)
    assert balance.force @ du == pytest.approx(expected, rel=1e-8, abs=1e-9 * scale)


@ANY_SHAPE
@given(SEEDS)
@settings(max_examples=10)
def test_power_of_the_tension_is_the_same_at_the_sites_and_at_the_nodes(shape, distorted, seed):
    """The identity on which every ledger rests: the solid pulls through the transpose of its stretch gradient."""
    solid = make(distorted, shape, support=())
    motion, law = somewhere(solid, seed), affine(solid, seed)
    active = solid.balance(motion, law, 0.0).force - solid.balance(motion, None, 0.0).force
    u, v = motion.displacement, motion.velocity
    tension = law.evaluate(solid.stretch(u, 0.0), np.zeros(solid.n_sites)).tension
    power = solid.site_volumes * tension * solid.stretch_rate(u, v, 0.0)
    assert np.abs(power).sum() > 1e-3
    assert abs(power.sum() - active @ v) < 1e-12 * np.abs(power).sum()


@ANY_SHAPE
def test_stretch_rate_is_the_rate_of_the_stretch(shape, distorted):
    """Where the support moves too."""
    solid = make(distorted, shape)
    motion = somewhere(solid, 2)
    u, v = motion.displacement, motion.velocity
    expected = difference(lambda t: solid.stretch(u + t * v, 0.5 + t), 0.0, 1.0, 1e-3)
    close(solid.stretch_rate(u, v, 0.5), expected, 1e-9)


@pytest.mark.parametrize("shape", ["triangle", "hexahedron"])
def test_a_strict_body_softened_is_the_body_of_that_bulk_modulus(shape, distorted):
    """One formulation for every bulk modulus, infinity included."""
    strict = make(distorted, shape, bulk_modulus=np.inf, material=Guccione())
    soft = make(distorted, shape, bulk_modulus=4e4, material=Guccione())
    motion = somewhere(strict, 3)
    softened = strict.softened(4e4)
    left, right = (solid.balance(motion, None, 0.5, tangent=True) for solid in (softened, soft))
    assert np.array_equal(left.force, right.force)
    assert np.array_equal(left.constraint, right.constraint)
    assert abs(left.constraint_compliance - right.constraint_compliance).max() == 0.0
    assert strict.balance(motion, None, 0.5, tangent=True).constraint_compliance is None
    assert strict.softened(1e9).softened(4e4).bulk_modulus == 4e4
    assert make(distorted, shape, bulk_modulus=None).softened(1e4) is None
