"""Inertia against the eigenvalues of numpy: dense and sparse, definite, indefinite, singular, saddle."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from myobridge.solvers import Inertia, InertiaUnknown, inertia


def grid(n: int) -> sparse.csc_array:
    """Laplacian of an n x n grid; its eigenvalues are 4 sin^2(i pi / 2(n+1)) + 4 sin^2(j pi / 2(n+1))."""
    line = sparse.diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    return sparse.csc_array(sparse.kron(line, sparse.eye_array(n)) + sparse.kron(sparse.eye_array(n), line))


def grid_eigenvalues(n: int) -> np.ndarray:
    one = 4.0 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1))) ** 2
    return (one[:, None] + one).ravel()


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 40), spread=st.floats(0.0, 3.0))
def test_random_dense_matrices(seed: int, n: int, spread: float) -> None:
    random = np.random.default_rng(seed)
    matrix = random.normal(size=(n, n))
    matrix = np.outer(*[10.0 ** random.uniform(-spread, spread, n)] * 2) * (matrix + matrix.T)
    eigenvalues = np.linalg.eigvalsh(matrix)
    if np.abs(eigenvalues).min() < 1e-12 * np.abs(eigenvalues).max():
        return
    found = inertia(matrix)
    assert found == (int((eigenvalues < 0).sum()), 0, int((eigenvalues > 0).sum()))
    assert inertia(sparse.csc_array(matrix)) == found


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(210, 300), shift=st.floats(-3.0, 3.0).map(lambda x: round(x, 3)))
def test_random_sparse_matrices(seed: int, n: int, shift: float) -> None:
    """Beyond the size at which a dense copy is made: random springs between random nodes, and a shift."""
    random = np.random.default_rng(seed)
    half = sparse.random(n, n, density=2.0 / n, random_state=random, data_rvs=random.standard_normal)
    matrix = sparse.csc_array(half + half.T + shift * sparse.eye_array(n))
    eigenvalues = np.linalg.eigvalsh(matrix.toarray())
    found = inertia(matrix)
    sure = int((eigenvalues < -1e-6).sum())
    assert sure <= found.negative <= int((eigenvalues < 0.0).sum())
    assert sum(found) == n
    assert found.zero <= int((np.abs(eigenvalues) < 1e-6).sum())


@pytest.mark.parametrize("shift", [0.0, 0.03, 0.5, 2.1, 5.0, 9.0])
def test_a_shifted_grid_has_the_eigenvalues_below_the_shift(shift: float) -> None:
    eigenvalues = grid_eigenvalues(20) - shift
    found = inertia(grid(20) - shift * sparse.eye_array(400))
    assert found == (int((eigenvalues < 0).sum()), 0, int((eigenvalues > 0).sum()))


def test_the_sparse_count_is_proven_without_a_dense_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    module = importlib.import_module("myobridge.solvers.inertia")
    monkeypatch.setattr(module, "_of_dense", lambda matrix: pytest.fail("made a dense copy"))
    assert inertia(grid(50) - 0.5 * sparse.eye_array(2500)).negative == int((grid_eigenvalues(50) < 0.5).sum())
    assert inertia(saddle(20, 0.0, 1e5)).negative == 100


def saddle(n: int, shift: float, stiffness: float) -> sparse.csc_array:
    """Stiffness of a grid, and the constraint that the sums over its 2 x 2 patches vanish, in small units."""
    patches = sparse.kron(sparse.eye_array(n // 2), np.ones((1, 2)))
    constraint = 1e-4 * sparse.kron(patches, patches)
    matrix = stiffness * (grid(n) - shift * sparse.eye_array(n * n))
    return sparse.csc_array(sparse.block_array([[matrix, constraint.T], [constraint, None]]))


@pytest.mark.parametrize("n", [10, 16])  # a dense copy below 200 rows, factors above
@pytest.mark.parametrize("shift", [0.0, 0.5, 3.9, 7.3])
def test_a_saddle_matrix_has_one_for_each_constraint_when_stable(n: int, shift: float) -> None:
    constraints = (n // 2) ** 2
    matrix = saddle(n, shift, 1e5)
    rows = matrix[n * n :, : n * n].toarray()
    kernel = np.linalg.svd(rows)[2][constraints:]
    inside = np.linalg.eigvalsh(kernel @ matrix[: n * n, : n * n].toarray() @ kernel.T)
    assert inertia(matrix).negative == constraints + int((inside < 0).sum())
    assert inertia(matrix).zero == 0


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(2, 25), data=st.data())
def test_random_dense_saddles(seed: int, n: int, data: st.DataObject) -> None:
    m = data.draw(st.integers(1, n))
    random = np.random.default_rng(seed)
    half = random.normal(size=(n, n))
    stiffness = half @ half.T + 0.1 * np.eye(n)
    constraint = np.linalg.qr(random.normal(size=(n, m)))[0]
    matrix = np.block([[1e5 * stiffness, constraint], [constraint.T, np.zeros((m, m))]])
    assert inertia(matrix) == (m, 0, n)


@pytest.mark.parametrize(("shift", "unstable"), [(0.0, False), (-0.5, True)])
def test_one_factorisation_proves_a_stable_saddle(monkeypatch, shift: float, unstable: bool) -> None:
    """With the constraints named: one count where the state is stable, more where it is not, the same answer always."""
    rng = np.random.default_rng(1)
    n, n_constraints = 300, 40
    line = sparse.diags_array([-np.ones(n - 1), np.full(n, 2.0), -np.ones(n - 1)], offsets=[-1, 0, 1])
    gradient = sparse.random_array((n_constraints, n), density=0.02, rng=rng) + sparse.eye_array(n_constraints, n)
    blocks = [[line + shift * sparse.eye_array(n), gradient.T], [gradient, None]]
    saddle = sparse.block_array(blocks, format="csc")
    counts: list[int] = []
    module = importlib.import_module("myobridge.solvers.inertia")
    count = module._count
    monkeypatch.setattr(module, "_count", lambda *given: counts.append(1) or count(*given))
    found = inertia(saddle, n_constraints)
    eigenvalues = np.linalg.eigvalsh(saddle.toarray())
    assert found.negative == np.sum(eigenvalues < 0.0)
    assert (found.negative > n_constraints) == unstable
    assert (len(counts) == 1) != unstable


@pytest.mark.parametrize("form", [np.asarray, sparse.csc_array])
def test_an_eigenvalue_that_is_zero_counts_as_zero(form) -> None:
    free = np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert inertia(form(free)) == Inertia(0, 1, 1)
    assert inertia(form(np.zeros((3, 3)))) == Inertia(0, 3, 0)
    assert inertia(np.zeros((0, 0))) == (0, 0, 0)


def test_a_free_sparse_body_has_one_zero() -> None:
    difference = sparse.diags_array([-np.ones(300), np.ones(300)], offsets=[0, 1], shape=(300, 301))
    assert inertia(difference.T @ difference) == Inertia(0, 1, 300)


def test_of_an_unsymmetric_matrix_the_symmetric_part_is_judged() -> None:
    matrix = np.array([[1.0, 4.0], [-4.0, 1.0]])
    assert inertia(matrix) == Inertia(0, 0, 2)
    assert inertia(matrix + np.array([[0.0, 4.0], [4.0, 0.0]])) == Inertia(1, 0, 1)
    skew = sparse.diags_array([np.full(399, 5.0), np.full(399, -5.0)], offsets=[1, -1])
    assert inertia(grid(20) + skew) == Inertia(0, 0, 400)
    sheared = sparse.kron(sparse.eye_array(150), np.array([[1.0, 4.0], [0.0, 1.0]]))
    assert inertia(sheared) == Inertia(150, 0, 150)


@pytest.mark.parametrize("matrix", [np.diag([1.0, np.nan]), sparse.diags_array(np.full(300, np.inf))])
def test_a_matrix_that_is_not_finite_is_refused(matrix) -> None:
    with pytest.raises(InertiaUnknown, match="not finite"):
        inertia(matrix)
