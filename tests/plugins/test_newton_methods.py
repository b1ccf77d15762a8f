"""Newton's methods against each other: the same solutions, and each saves what it promises to save."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge.interfaces import Array, LinearSystem, Matrix, NewtonMethod, NewtonProblem
from myobridge.solvers import Ordinary
from myobridge_plugins.linear_solver.amg_gmres import AmgGmres
from myobridge_plugins.newton.inexact import Inexact
from myobridge_plugins.newton.simplified import Simplified
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

METHODS: dict[str, type[NewtonMethod]] = {
    name: mb.registry().find("newton", name).cls for name in mb.registry().names("newton")
}


class Stiffening(NewtonProblem):
    """An incompressible block on springs that stiffen with the cube: A x + k u^3 = b."""

    def __init__(self, system: LinearSystem, load: float) -> None:
        self.system, self.tangents, self.residuals = system, 0, 0
        self.n = system.stiffness.shape[0]
        self.right = np.zeros(system.n_unknowns)
        self.right[: self.n] = load * np.random.default_rng(3).standard_normal(self.n)
        self.cubic = 1e8

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        self.residuals += 1
        force = self.system.times(unknowns) - self.right
        force[: self.n] += self.cubic * unknowns[: self.n] ** 3
        return force, float(np.linalg.norm(self.right))

    def tangent(self, unknowns: Array) -> LinearSystem:
        self.tangents += 1
        spring = sparse.diags_array(3.0 * self.cubic * unknowns[: self.n] ** 2)
        return attrs.evolve(self.system, stiffness=sparse.csr_array(self.system.stiffness + spring))


class FromFar(NewtonProblem):
    """exp(x) = 2, and whether it is known how large the terms are that cancel."""

    def __init__(self, known: bool) -> None:
        self._known = known

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        terms = float(np.linalg.norm(np.exp(unknowns))) + 3.0
        return np.exp(unknowns) - 2.0, terms if self._known else 1e-9

    def tangent(self, unknowns: Array) -> Matrix:
        return np.diag(np.exp(unknowns))


@pytest.mark.parametrize("name", METHODS)
def test_all_methods_find_the_same_solution(name: str, elastic_block: Any) -> None:
    problem = Stiffening(elastic_block(dimension=2, cells=3), 1.0)
    start = np.zeros(problem.right.size)
    expected = Ordinary().solve(problem, start)
    assert expected.iterations >= 4
    found = METHODS[name]().solve(problem, start)
    assert found.converged, found.reason
    assert np.linalg.norm(found.unknowns - expected.unknowns) <= 1e-9 * np.linalg.norm(expected.unknowns)
    assert len(found.history) == found.iterations
    residuals = [step.residual for step in found.history]
    assert residuals[0] == pytest.approx(np.linalg.norm(problem.right))
    assert residuals[-1] < 1e-3 * residuals[0]


@pytest.mark.parametrize("name", METHODS)
def test_a_residual_whose_square_overflows_is_only_too_large(name: str) -> None:
    """exp(x) = e^2 from where the whole correction leads to x = 490: exp(490) is a number, its square is not."""

    class Exponential(NewtonProblem):
        def residual(self, unknowns: Array) -> tuple[Array, float]:
            return np.exp(unknowns) - np.exp(2.0), 1.0

        def tangent(self, unknowns: Array) -> Matrix:
            return np.diag(np.exp(unknowns))

    start = np.array([-4.215, -4.2])
    whole = start - 1.0 + np.exp(2.0 - start)
    assert np.all((whole > 400.0) & (whole < 700.0))
    found = METHODS[name]().solve(Exponential(), start)
    assert found.converged, found.reason
    assert np.allclose(found.unknowns, 2.0, rtol=1e-8)


@pytest.mark.parametrize("name", METHODS)
def test_a_bad_guess_does_not_loosen_the_tolerance(name: str) -> None:
    """exp(x) = 2 from x = 20, where the residual is 5e8: a millionth of that is not enough."""
    found = METHODS[name](tolerance=1e-6).solve(FromFar(known=True), np.array([20.0, 19.0]))
    assert found.converged, found.reason
    assert np.linalg.norm(np.exp(found.unknowns) - 2.0) <= 1e-6 * 6.0


@pytest.mark.parametrize("name", METHODS)
def test_terms_that_are_not_known_do_not_tighten_it(name: str) -> None:
    """A solid need not say how large its terms are: then the first residual is all there is to compare with."""
    found = METHODS[name](tolerance=1e-6).solve(FromFar(known=False), np.array([20.0, 19.0]))
    assert found.converged, found.reason
    assert 1e-6 < np.linalg.norm(np.exp(found.unknowns) - 2.0) <= 1e-6 * np.exp(20.2)


@pytest.mark.parametrize("name", METHODS)
@settings(max_examples=20)
@given(solution=st.floats(0.1, 5.0), start=st.floats(0.1, 8.0))
def test_they_stay_where_the_problem_is_admissible(name: str, solution: float, start: float) -> None:
    """log(x / s) = 0 wants x > 0; from x > e s the whole correction leads below zero."""

    class Logarithm(NewtonProblem):
        def residual(self, unknowns: Array) -> tuple[Array, float]:
            assert unknowns[0] > 0.0
            return np.log(unknowns / solution), 1.0

        def tangent(self, unknowns: Array) -> Matrix:
            return np.diag(1.0 / unknowns)

        def admissible(self, unknowns: Array) -> bool:
            return bool(unknowns[0] > 0.0)

    found = METHODS[name]().solve(Logarithm(), np.array([start]))
    assert found.converged, found.reason
    assert found.unknowns[0] == pytest.approx(solution, rel=1e-10)


@pytest.mark.parametrize("name", METHODS)
def test_a_start_without_a_residual_is_said(name: str) -> None:
    class Nothing(NewtonProblem):
        def residual(self, unknowns: Array) -> tuple[Array, float]:
            return np.full(2, np.nan), 1.0

        def tangent(self, unknowns: Array) -> Matrix:
            return np.eye(2)

    found = METHODS[name]().solve(Nothing(), np.zeros(2))
    assert not found.converged
    assert found.reason == "the residual is not finite"


@pytest.mark.parametrize("name", METHODS)
def test_all_methods_serve_an_integrator_in_a_scene(name: str, scenes_of_newton: str) -> None:
    scene = mb.Scene.from_toml(scenes_of_newton.format(name))
    result = mb.run(scene)
    reference = mb.run(mb.Scene.from_toml(scenes_of_newton.format("ordinary")))
    np.testing.assert_allclose(result["tension"], reference["tension"], rtol=1e-8)
    assert mb.Scene.from_toml(scene.to_toml()) == scene


@pytest.fixture
def scenes_of_newton() -> str:
    return """
[scene]
effects = ["cross_bridges"]
duration = 0.01
step = 1e-3
[solid]
plugin = "chain"
springs = 4
length = 0.1
[cross_bridges]
plugin = "distributed_moment"
[integrator]
plugin = "quasi_static"
newton = {{ plugin = "{}", tolerance = 1e-11 }}
"""


def test_the_simplified_method_factorises_less(elastic_block: Any) -> None:
    problem = Stiffening(elastic_block(dimension=2, cells=3), 0.02)
    start = np.zeros(problem.right.size)
    ordinary = Ordinary().solve(problem, start)
    tangents = problem.tangents
    problem.tangents = 0
    found = Simplified().solve(problem, start)
    assert found.converged
    assert found.iterations > ordinary.iterations
    factorised = sum(step.factorised for step in found.history)
    assert problem.tangents < tangents
    assert factorised < ordinary.iterations
    assert found.kept is not None
    # The next problem, a little further on, begins with the tangent of the last one.
    further = Stiffening(problem.system, 0.0201)
    again = Simplified(tolerance=1e-8).solve(further, found.unknowns, found.kept)
    assert again.converged
    assert further.tangents == 0
    assert not any(step.factorised for step in again.history)


def test_a_kept_tangent_that_leads_nowhere_is_left_for_the_ordinary_method(elastic_block: Any) -> None:
    problem = Stiffening(elastic_block(dimension=2, cells=3), 1.0)
    start = np.zeros(problem.right.size)
    # Ten thousand times softer, with the sign wrong: the first corrections are useless.
    useless = attrs.evolve(problem.system, stiffness=-1e-4 * problem.system.stiffness)
    from myobridge.interfaces import KeptTangent
    from myobridge.solvers import factorise

    found = Simplified().solve(problem, start, KeptTangent(useless, factorise(useless), np.array([1.0, 0.0, np.inf])))
    assert found.converged, found.reason
    expected = Ordinary().solve(problem, start).unknowns
    assert np.linalg.norm(found.unknowns - expected) <= 1e-9 * np.linalg.norm(expected)


def test_the_inexact_method_saves_linear_iterations(elastic_block: Any) -> None:
    problem = Stiffening(elastic_block(dimension=3, cells=2), 1.0)
    start = np.zeros(problem.right.size)
    ordinary = Ordinary(linear=AmgGmres(), tolerance=1e-10).solve(problem, start)
    inexact = Inexact(linear=AmgGmres(), tolerance=1e-10).solve(problem, start)
    assert ordinary.converged, ordinary.reason
    assert inexact.converged, inexact.reason
    spent = [sum(step.linear_iterations for step in found.history) for found in (ordinary, inexact)]
    assert spent[1] < 0.8 * spent[0], f"linear iterations: ordinary {spent[0]}, inexact {spent[1]}"
    assert np.linalg.norm(inexact.unknowns - ordinary.unknowns) <= 1e-7 * np.linalg.norm(ordinary.unknowns)


@pytest.mark.parametrize("name", METHODS)
def test_an_unsolved_linear_system_is_the_reason(name: str, elastic_block: Any) -> None:
    problem = Stiffening(elastic_block(dimension=3, cells=2), 1.0)
    method = METHODS[name](linear=AmgGmres(max_iterations=1))  # pyright: ignore[reportCallIssue]
    found = method.solve(problem, np.zeros(problem.right.size))
    assert not found.converged
    assert "the linear system of iteration 1 is not solved: amg_gmres left" in found.reason


def test_a_newton_method_is_a_part_of_an_integrator() -> None:
    assert QuasiStatic(newton=Simplified(contraction=0.1)).newton == Simplified(contraction=0.1)
    with pytest.raises(mb.ParameterError, match="contraction"):
        Simplified(contraction=1.5)
