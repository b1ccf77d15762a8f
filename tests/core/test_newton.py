"""Newton's method: quadratic where it should be, careful where it must be, and honest when it fails."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given
from hypothesis import strategies as st

from myobridge.interfaces import NewtonProblem
from myobridge.solvers import Ordinary, newton


def anywhere(_: np.ndarray) -> bool:
    return True


@pytest.mark.parametrize("form", [np.asarray, sparse.csc_array])
def test_a_system_is_solved_dense_and_sparse(form) -> None:
    def evaluate(x: np.ndarray):
        return np.array([x[0] ** 2 + x[1] ** 2 - 4.0, x[0] - x[1]]), form([[2 * x[0], 2 * x[1]], [1.0, -1.0]]), 4.0

    found = newton(evaluate, np.array([1.0, 2.0]), admissible=anywhere)
    assert found.converged
    np.testing.assert_allclose(found.unknowns, np.sqrt(2.0), rtol=1e-14)
    assert found.iterations <= 7


def test_convergence_is_quadratic() -> None:
    errors: list[float] = []

    def evaluate(x: np.ndarray):
        errors.append(abs(float(x[0]) - np.sqrt(2.0)))
        return x**2 - 2.0, np.diag(2.0 * x), 2.0

    assert newton(evaluate, np.array([2.0]), admissible=anywhere).converged
    slopes = [np.log(b) / np.log(a) for a, b in pairwise(errors[1:4])]
    assert min(slopes) > 1.8, f"observed orders {slopes}"


@given(st.floats(-3.0, 3.0), st.floats(0.2, 5.0))
def test_a_linear_problem_takes_one_iteration(solution: float, stiffness: float) -> None:
    found = newton(
        lambda x: (stiffness * (x - solution), np.array([[stiffness]]), stiffness),
        np.array([10.0]),
        admissible=anywhere,
    )
    assert found.converged
    assert found.iterations <= 2
    assert found.unknowns[0] == pytest.approx(solution, abs=1e-14)


def test_it_never_leaves_the_admissible() -> None:
    seen: list[float] = []

    def evaluate(x: np.ndarray):
        seen.append(float(x[0]))
        return np.log(x), np.diag(1.0 / x), 1.0

    # From 8 the full step goes to 8 - 8 log 8 < 0.
    found = newton(evaluate, np.array([8.0]), admissible=lambda x: bool(x[0] > 0.0))
    assert found.converged
    assert found.unknowns[0] == pytest.approx(1.0, abs=1e-12)
    assert min(seen) > 0.0


FAILURES = {
    "the residual is not finite": (lambda x: (np.array([np.nan]), np.eye(1), 1.0), anywhere),
    "the tangent is singular": (lambda x: (np.ones(1), np.zeros((1, 1)), 1.0), anywhere),
    "no admissible point": (lambda x: (np.ones(1), np.eye(1), 1.0), lambda x: False),
    "did not converge in 30 iterations": (lambda x: (x**2 + 1.0, np.diag(2.0 * x), 1.0), anywhere),
}


@pytest.mark.parametrize("reason", FAILURES)
def test_failure_is_a_result_that_says_why(reason: str) -> None:
    evaluate, admissible = FAILURES[reason]
    found = newton(evaluate, np.array([0.7]), admissible=admissible)
    assert not found.converged
    assert reason in found.reason


def test_a_root_at_the_start_is_seen_at_once() -> None:
    found = newton(lambda x: (x.copy(), np.eye(1), 1.0), np.zeros(1), admissible=anywhere)
    assert found.converged
    assert found.iterations == 0


def test_a_residual_below_the_round_off_of_its_terms_is_nothing() -> None:
    """Two forces of 1e6 that cancel leave 1e-10: no smaller residual exists, and none must be asked for."""
    found = newton(lambda x: (np.array([1e-10]), np.eye(1), 1e6), np.zeros(1), admissible=anywhere)
    assert found.converged
    assert found.iterations == 0
    harder = newton(lambda x: (x - 1e-10, np.eye(1), 1e-3), np.zeros(1), admissible=anywhere)
    assert harder.converged
    assert harder.unknowns[0] == pytest.approx(1e-10, rel=1e-12)


def test_the_history_tells_every_iteration() -> None:
    found = newton(lambda x: (np.log(x), np.diag(1.0 / x), 1.0), np.array([8.0]), admissible=lambda x: bool(x[0] > 0.0))
    assert len(found.history) == found.iterations
    assert found.history[0].residual == pytest.approx(np.log(8.0))
    assert found.history[0].fraction == 0.25  # 8 - 16.6 and 8 - 8.3 are below zero
    assert found.history[-1].fraction == 1.0
    assert all(step.linear_iterations == 0 for step in found.history)


def test_growth_out_of_all_proportion_halves_the_step() -> None:
    """From 0.05 the correction of x^5 = 1 goes to 3e4, where the residual is 1e22: the way back is long."""

    class Quintic(NewtonProblem):
        def residual(self, unknowns: np.ndarray) -> tuple[np.ndarray, float]:
            return unknowns**5 - 1.0, 1.0

        def tangent(self, unknowns: np.ndarray) -> np.ndarray:
            return np.diag(5.0 * unknowns**4)

    far = Ordinary(growth=np.inf).solve(Quintic(), np.array([0.05]))
    assert not far.converged
    assert far.history[1].residual > 1e21
    near = Ordinary().solve(Quintic(), np.array([0.05]))
    assert near.converged
    assert near.unknowns[0] == pytest.approx(1.0, abs=1e-12)
    assert near.history[0].fraction < 1.0
    assert max(step.residual for step in near.history) <= 1e6
