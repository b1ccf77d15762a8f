"""Factors that are kept: fewer of them, the same answers, and a way back from every tangent that is of no use."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge.equilibria import Equilibria
from myobridge.interfaces import (
    AffineLaw,
    Array,
    Factorisation,
    KeptTangent,
    LinearSystem,
    Motion,
    NewtonMethod,
    NewtonProblem,
    NewtonTask,
    SystemSize,
)
from myobridge.solvers import (
    HeldTangent,
    Ordinary,
    UnsolvedSystem,
    factorise,
    fgmres,
    method_for,
    method_for_size,
)
from myobridge.solvers.kept import recalled
from myobridge.work import counted
from myobridge_plugins.continuation.natural import Natural
from myobridge_plugins.linear_solver.amg_gmres import AmgGmres
from myobridge_plugins.linear_solver.pardiso import Pardiso
from myobridge_plugins.linear_solver.superlu import SuperLU
from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.macro_solid.spring import Spring
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.newton.anderson import Anderson
from myobridge_plugins.newton.inexact import Inexact
from myobridge_plugins.newton.simplified import Simplified

KEEPING = {"simplified": Simplified, "inexact": Inexact}
INTEGRATORS = ("midpoint", "energy_momentum", "quasi_static")
DT = 1e-3


@pytest.fixture(scope="module")
def solid() -> FiniteElement:
    """506 unknowns, strictly incompressible, with a dead force across."""
    return FiniteElement(
        mesh=Block(size=(0.1, 0.05), cells=(10, 5)),
        material=MooneyRivlin(),
        support=(Support(boundary="left"),),
        load=(Traction(boundary="right", traction=(0.0, 3e3)),),
        bulk_modulus=math.inf,
        threads=1,
    )


def contraction(solid: FiniteElement, integrator: str, method: NewtonMethod, steps: int = 8) -> tuple[Motion, Any]:
    """A body that contracts by 73 kPa of tension, stiff about where each step begins; motion and counts of work."""
    one = mb.registry().find("time_integrator", integrator).cls(newton=method)
    motion, memory = solid.rest_motion(), {}
    with counted() as work:
        for k in range(steps):
            stretch = solid.stretch(motion.displacement, k * DT)
            share = (k + 1) / steps
            law = AffineLaw(stretch, np.full_like(stretch, share * 7.3e4), np.full_like(stretch, share * 1e6))
            motion, memory, report = one.step(solid, law, motion, memory, k * DT, DT)
            assert report.converged, report.reason
    return motion, work


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", KEEPING)
def test_one_factorisation_serves_many_steps_of_the_same_motion(name: str, integrator: str, solid: Any) -> None:
    expected, ordinary = contraction(solid, integrator, Ordinary(tolerance=1e-11))
    found, kept = contraction(solid, integrator, KEEPING[name](tolerance=1e-11))
    size = np.abs(expected.displacement).max()
    assert size > 1e-3, "something must have moved"
    assert np.abs(found.displacement - expected.displacement).max() <= 1e-8 * size
    pressure = np.abs(expected.multiplier).max()
    assert np.abs(found.multiplier - expected.multiplier).max() <= 1e-7 * pressure
    assert ordinary["factorisations"] >= 16
    assert kept["factorisations"] <= 3, kept


@pytest.mark.parametrize("name", KEEPING)
def test_multigrid_is_set_up_once_and_again(name: str, solid: Any) -> None:
    """Set-up is cheap and its own system changes: kept within a step, and renewed when iterations become dearer."""
    expected, ordinary = contraction(solid, "quasi_static", Ordinary(tolerance=1e-9, linear=AmgGmres()), 4)
    found, kept = contraction(solid, "quasi_static", KEEPING[name](tolerance=1e-9, linear=AmgGmres()), 4)
    assert np.abs(found.displacement - expected.displacement).max() <= 1e-6 * np.abs(expected.displacement).max()
    assert kept["factorisations"] < ordinary["factorisations"]


def test_the_answer_reaches_round_off_like_that_of_the_ordinary_method(solid: Any) -> None:
    """At 1e-12 and below, where a kept tangent no longer gains: the residual is what round-off leaves."""
    expected, _ = contraction(solid, "quasi_static", Ordinary(tolerance=1e-15), 3)
    for method in (Simplified(tolerance=1e-15), Inexact(tolerance=1e-15)):
        found, work = contraction(solid, "quasi_static", method, 3)
        off = np.abs(found.displacement - expected.displacement).max()
        assert off <= 1e-12 * np.abs(expected.displacement).max()
        assert work["factorisations"] <= 4, "round-off is no reason for a new tangent"


@pytest.mark.parametrize("linear", [SuperLU, Pardiso])
def test_factors_in_single_precision_reach_every_tolerance(linear: Any, solid: Any) -> None:
    single = linear(precision="single")
    if single.obstacle():
        pytest.skip(single.obstacle())
    expected, _ = contraction(solid, "midpoint", Ordinary(tolerance=1e-12))
    for name, method in KEEPING.items():
        found, work = contraction(solid, "midpoint", method(tolerance=1e-12, linear=single))
        off = np.abs(found.displacement - expected.displacement).max() / np.abs(expected.displacement).max()
        assert off <= 1e-9, name
        assert work["factorisations"] <= 3, (name, work)


@pytest.mark.parametrize("linear", [SuperLU, Pardiso])
def test_single_precision_is_refined_and_left_where_it_fails(linear: Any, elastic_block: Any) -> None:
    single = linear(precision="single")
    if single.obstacle():
        pytest.skip(single.obstacle())
    system = elastic_block(dimension=2, cells=3, fibre=3e5)
    right = np.random.default_rng(0).standard_normal(system.n_unknowns)
    factors = single.factorise(system)
    assert "in single precision" in factors.describe()
    rough = np.linalg.norm(right - system.times(factors.approximate(right))) / np.linalg.norm(right)
    assert 1e-9 < rough < 1e-2, "these factors would be in double precision"
    found = factors.solve(1e-60 * right, 1e-12)  # 1e-60 is nothing in single precision
    assert np.linalg.norm(1e-60 * right - system.times(found)) <= 1e-12 * np.linalg.norm(1e-60 * right)
    # A chain of 20 000 springs: its condition is 2e8, more than single precision has digits.
    n = 20_000
    chain = LinearSystem(
        sparse.diags_array([np.full(n, 2.0), np.full(n - 1, -1.0), np.full(n - 1, -1.0)], offsets=[0, 1, -1])
    )
    again = single.factorise(chain)
    assert "single" not in again.describe()
    pulled = np.ones(n)
    assert np.linalg.norm(pulled - chain.times(again.solve(pulled, 1e-8))) <= 1e-8 * np.linalg.norm(pulled)


class Cubic(NewtonProblem):
    """A x + c x^3 = b."""

    def __init__(self, system: LinearSystem, load: float = 1.0) -> None:
        self.system, self.n = system, system.stiffness.shape[0]
        self.right = np.zeros(system.n_unknowns)
        self.right[: self.n] = load * np.random.default_rng(3).standard_normal(self.n)

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        force = self.system.times(unknowns) - self.right
        force[: self.n] += 1e8 * unknowns[: self.n] ** 3
        return force, float(np.linalg.norm(self.right))

    def tangent(self, unknowns: Array) -> LinearSystem:
        spring = sparse.diags_array(3e8 * unknowns[: self.n] ** 2)
        return attrs.evolve(self.system, stiffness=sparse.csr_array(self.system.stiffness + spring))


def kept(system: LinearSystem) -> KeptTangent:
    return KeptTangent(system, factorise(system), np.array([1.0, 10.0, np.inf]))


BROKEN = {
    "of the wrong sign": lambda system: attrs.evolve(system, stiffness=-system.stiffness),
    "of a tenth of the step": lambda system: attrs.evolve(
        system, stiffness=sparse.csr_array(system.stiffness + 1e2 * sparse.diags_array(system.stiffness.diagonal()))
    ),
    "ten thousand times too soft": lambda system: attrs.evolve(system, stiffness=1e-4 * system.stiffness),
    "without a constraint": lambda system: attrs.evolve(
        system, compliance=sparse.csr_array(1e6 * sparse.eye_array(system.n_constraints))
    ),
}


@pytest.mark.parametrize("name", KEEPING)
@pytest.mark.parametrize("how", BROKEN)
def test_a_kept_tangent_that_is_of_no_use_costs_a_new_one_and_no_more(how: str, name: str, elastic_block: Any) -> None:
    problem = Cubic(elastic_block(dimension=2, cells=3))
    start = np.zeros(problem.right.size)
    expected = Ordinary().solve(problem, start)
    with counted() as work:
        found = KEEPING[name]().solve(problem, start, kept(BROKEN[how](problem.system)))
        spent = work["factorisations"] - 1  # the broken one is factored here too
    assert found.converged, found.reason
    assert np.linalg.norm(found.unknowns - expected.unknowns) <= 1e-9 * np.linalg.norm(expected.unknowns)
    assert spent <= expected.iterations
    assert not all(step.factorised for step in found.history)


def test_factors_that_are_gone_are_made_again_from_the_same_matrix(elastic_block: Any) -> None:
    """What a checkpoint leaves: the next solve is the same to the last bit."""
    problem = Cubic(elastic_block(dimension=2, cells=3), 0.02)
    for method in (Simplified(), Inexact()):
        first = method.solve(problem, np.zeros(problem.right.size)).kept
        assert first is not None
        further = Cubic(problem.system, 0.021)
        expected = method.solve(further, np.zeros(problem.right.size), first)
        found = method.solve(further, np.zeros(problem.right.size), attrs.evolve(first, factorisation=None))
        np.testing.assert_array_equal(found.unknowns, expected.unknowns)
        assert expected.kept is not None
        assert found.kept is not None
        np.testing.assert_array_equal(found.kept.work, expected.kept.work)
        assert found.history == expected.history


def test_other_lengths_of_a_step_go_on_with_the_same_factors(solid: Any) -> None:
    """Halved and regrown steps: the mass weighs four times more, or less, and the answers stay those of new ones."""
    found = {}
    for name, method in (("ordinary", Ordinary(tolerance=1e-11)), ("simplified", Simplified(tolerance=1e-11))):
        one = mb.registry().find("time_integrator", "midpoint").cls(newton=method)
        motion, memory, time = solid.rest_motion(), {}, 0.0
        with counted() as work:
            for dt in (1e-3, 5e-4, 2.5e-4, 5e-4, 1e-3, 1e-3):
                motion, memory, report = one.step(solid, None, motion, memory, time, dt)
                assert report.converged, report.reason
                time += dt
            found[name] = motion, work["factorisations"]
    motion, expected = found["simplified"][0], found["ordinary"][0]
    assert np.abs(motion.velocity - expected.velocity).max() <= 1e-7 * np.abs(expected.velocity).max()
    assert found["simplified"][1] <= 6 < found["ordinary"][1]


class Priced(Factorisation):
    """Factors worth a given number of applications."""

    def __init__(self, worth: float) -> None:
        self._worth = worth

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        return vector

    @property
    def worth(self) -> float:
        return self._worth


@given(worth=st.floats(1.0, 200.0), costs=st.lists(st.integers(1, 60), min_size=1, max_size=40))
def test_factors_are_kept_as_long_as_that_lowers_the_average(worth: float, costs: list[int]) -> None:
    tangent: KeptTangent | None = KeptTangent(LinearSystem(np.eye(1)), Priced(worth), np.array([0.0, 0.0, np.inf]))
    averages = []
    for k, cost in enumerate(costs, start=1):
        held = HeldTangent(tangent, None)
        held.charge(cost)
        tangent = held.handed_on()
        averages.append((worth + sum(costs[:k])) / k)
        if tangent is None:
            # This solve cost more than all of them on the average, factors included: one like it would raise that.
            assert k > 1
            assert cost > averages[-1]
            assert all(later <= earlier + 1e-9 for earlier, later in pairwise(averages[:-1]))
            return
        assert k == 1 or cost <= averages[-1] + 1e-9


@settings(max_examples=30)
@given(
    size=st.integers(1, 30), seed=st.integers(0, 99), off=st.floats(0.0, 0.5), tolerance=st.sampled_from([1e-2, 1e-9])
)
def test_fgmres_reaches_the_residual_in_as_many_iterations_as_unknowns(
    size: int, seed: int, off: float, tolerance: float
) -> None:
    random = np.random.default_rng(seed)
    matrix = np.eye(size) + off * random.standard_normal((size, size)) / math.sqrt(size)
    other = np.linalg.inv(matrix + 0.1 * random.standard_normal((size, size)) / math.sqrt(size))
    right = random.standard_normal(size)
    found, spent = fgmres(lambda x: matrix @ x, lambda x: other @ x, right, tolerance, size)
    assert np.linalg.norm(right - matrix @ found) <= tolerance * np.linalg.norm(right)
    assert spent <= size
    # The smallest residual in the space: the exact preconditioner takes one iteration.
    assert fgmres(lambda x: matrix @ x, lambda x: np.linalg.solve(matrix, x), right, 1e-9, size)[1] == 1


def test_fgmres_that_does_not_arrive_says_how_far_it_came() -> None:
    matrix = np.roll(np.eye(12), 1, axis=0)  # no residual falls before the last iteration
    right = np.eye(12)[0]
    with pytest.raises(UnsolvedSystem, match=r"left 1\.0e\+00 of the right side after 11 iterations"):
        fgmres(lambda x: matrix @ x, lambda x: x, right, 1e-6, 11)
    assert fgmres(lambda x: matrix @ x, lambda x: x, right, 1e-6, 12)[1] == 12
    with pytest.raises(UnsolvedSystem, match="not finite"):
        fgmres(lambda x: matrix @ x, lambda x: np.nan * x, right, 1e-6, 11)


@settings(max_examples=30)
@given(size=st.integers(1, 5), seed=st.integers(0, 99))
def test_anderson_solves_linear_equations_in_as_many_iterations_as_unknowns(size: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix = np.eye(size) + 0.5 * random.standard_normal((size, size)) / math.sqrt(size)
    right, unknowns = random.standard_normal(size), np.zeros(size)
    past, residual = Anderson(size), -right
    for _ in range(size + 1):
        if np.linalg.norm(residual) <= 1e-10 * np.linalg.norm(right):
            break
        following = unknowns - past.correction(residual, lambda vector: vector)
        fall = (matrix @ following - right) - residual
        past.learn(following - unknowns, fall)
        unknowns, residual = following, residual + fall
    conditions = np.linalg.cond(matrix) ** 2
    assert np.linalg.norm(matrix @ unknowns - right) <= 1e-9 * conditions * np.linalg.norm(right)


def test_earlier_iterations_correct_an_old_tangent(elastic_block: Any) -> None:
    problem = Cubic(elastic_block(dimension=2, cells=3), 1.0)
    start = np.zeros(problem.right.size)
    old = kept(problem.tangent(0.5 * Ordinary().solve(problem, start).unknowns))
    plain, accelerated = (Simplified(depth=depth, tolerance=1e-10).solve(problem, start, old) for depth in (0, 5))
    assert accelerated.converged
    assert not any(step.factorised for step in accelerated.history)
    assert accelerated.iterations < 0.7 * plain.iterations


def test_what_is_kept_is_symmetric_where_it_almost_is_rough_and_stored_once(solid: Any, elastic_block: Any) -> None:
    one = mb.registry().find("time_integrator", "midpoint").cls(newton=Simplified())
    memory = one.step(solid, None, solid.rest_motion(), {}, 0.0, DT).memory
    assert memory["kept/mark"][0] == 1.0
    assert "kept/transposed_gradient/data" in memory
    assert not any(name.startswith("kept/gradient") for name in memory)
    again = recalled(memory, solid)
    assert again is not None
    assert again.system.gradient is again.system.transposed_gradient
    assert again.factorisation is not None
    assert "in single precision" in again.factorisation.describe()
    # Half of a skew part is more than a symmetric matrix can stand for.
    system = elastic_block(dimension=2, cells=3)
    n = system.stiffness.shape[0]
    skew = sparse.diags_array([np.full(n - 3, 1.0), np.full(n - 3, -1.0)], offsets=[3, -3])
    for share, symmetric in ((0.01, True), (1.0, False)):
        turned = system.stiffness + share * system.stiffness.diagonal().mean() * skew
        held = HeldTangent(None, SuperLU())
        held.renew(attrs.evolve(system, stiffness=sparse.csr_array(turned), symmetric=False))
        assert held.system.symmetric is symmetric
        assert abs(held.system.stiffness - held.system.stiffness.T).max() == 0.0 or not symmetric
        assert "single" not in held.factors.describe(), "a solver that is named is taken as it is"


def test_paths_of_equilibria_hand_their_factors_on(solid: Any) -> None:
    expected, found = {}, {}
    for method, into in ((Ordinary(tolerance=1e-10), expected), (None, found)):
        problem = Equilibria(solid, None, of="load", to=1.0)
        with counted() as work:
            path = Natural(step=0.125, newton=method).trace(problem, problem.start)
            into["work"] = work["factorisations"]
        assert path.completed, path.reason
        into["end"], into["levels"] = path.points[-1].unknowns, [point.level for point in path.points]
        assert [point.negative_eigenvalues for point in path.points] == [0] * len(path.points)
    assert found["levels"] == expected["levels"]
    assert np.linalg.norm(found["end"] - expected["end"]) <= 1e-8 * np.linalg.norm(expected["end"])
    # At each of nine levels, three iterations, a slope and the verdict, which may not be counted here.
    assert 3 * found["work"] < expected["work"], (found["work"], expected["work"])


def test_the_choice_of_a_method(solid: Any) -> None:
    assert method_for(Spring()).name == "ordinary"
    assert method_for(solid).name == "simplified"
    assert method_for(solid, path=True).name == "inexact"
    assert method_for_size(SystemSize(300, 3)).name == "ordinary"
    # Where the linear solver iterates, the true tangent is what it should iterate on.
    small = SystemSize(50_000, 3)
    assert Inexact.suits(NewtonTask(small, direct=False))
    assert not Simplified.suits(NewtonTask(small, direct=False))
    assert not any(cls.suits(NewtonTask(small, direct=True)) for cls in (Inexact, Ordinary))
    assert method_for(solid).reason
