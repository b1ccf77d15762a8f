"""The cycle of algebraic multigrid: linear, symmetric, the same on any number of threads, no worse on finer meshes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse

from myobridge.interfaces import LinearSystem
from myobridge_plugins.linear_solver import multigrid
from myobridge_plugins.linear_solver.amg_gmres import AmgGmres
from myobridge_plugins.linear_solver.chebyshev_kernels import descend, residual, start
from myobridge_plugins.linear_solver.node_blocks import in_node_blocks

KINDS = {"plane": {"dimension": 2, "cells": 8}, "space": {"dimension": 3, "cells": 4}}


def parts(system: LinearSystem) -> tuple[Any, np.ndarray]:
    assert system.rigid_motions is not None
    return sparse.csr_matrix(system.stiffness), system.rigid_motions


def with_rollers(system: LinearSystem) -> tuple[Any, np.ndarray]:
    """Without some components of some nodes: of one, of two, and of the first and the last number."""
    matrix, motions = parts(system)
    n = matrix.shape[0]
    kept = np.setdiff1d(np.arange(n), [0, 4, 9, 10, 17, 21, 23, n - 1])
    return sparse.csr_matrix(matrix[kept][:, kept]), motions[kept]


@pytest.mark.parametrize("change", [parts, with_rollers])
def test_blocks_hold_the_matrix(change: Callable[..., Any], elastic_block: Any) -> None:
    matrix, motions = change(elastic_block(**KINDS["space"]))
    blocks, carried, places = in_node_blocks(matrix, motions)
    assert blocks.blocksize == (3, 3)
    whole = sparse.csr_matrix(blocks)
    assert abs(whole[places][:, places] - matrix).max() == 0.0
    assert np.array_equal(carried[places], motions)
    # Each number stands in the row of its component; those that are missing couple with nothing.
    assert np.array_equal(places % 3, np.argmax(motions[:, :3], axis=1))
    missing = np.setdiff1d(np.arange(whole.shape[0]), places)
    assert missing.size == (0 if change is parts else whole.shape[0] - matrix.shape[0])
    assert np.all(carried[missing] == 0.0)
    assert np.all(whole.diagonal()[missing] > 0.0)
    assert abs(whole[missing]).sum() == pytest.approx(whole.diagonal()[missing].sum())


@pytest.mark.parametrize(("kind", "change"), [("plane", parts), ("space", parts), ("space", with_rollers)])
def test_a_cycle_is_linear_symmetric_and_positive(kind: str, change: Callable[..., Any], elastic_block: Any) -> None:
    matrix, motions = change(elastic_block(**KINDS[kind]))
    cycle = multigrid.cycle_of(matrix, motions)
    assert len(cycle.sizes) > 1
    x, y = np.random.default_rng(3).standard_normal((2, matrix.shape[0]))
    one, other = cycle @ x, cycle @ y
    assert np.allclose(cycle @ (2.0 * x - 3e-9 * y), 2.0 * one - 3e-9 * other, rtol=0.0, atol=1e-12 * np.abs(one).max())
    assert abs(y @ one - x @ other) <= 1e-12 * np.linalg.norm(one) * np.linalg.norm(y)
    assert x @ one > 1e-3 * np.linalg.norm(one) * np.linalg.norm(x)


@pytest.mark.parametrize("change", [parts, with_rollers])
def test_a_cycle_takes_most_of_the_error(change: Callable[..., Any], elastic_block: Any) -> None:
    """In the norm of the energy, from errors of all kinds: smooth, rough, random."""
    matrix, motions = change(elastic_block(**KINDS["space"]))
    cycle = multigrid.cycle_of(matrix, motions)
    rng = np.random.default_rng(0)
    rough = rng.standard_normal(matrix.shape[0])
    smooth = sparse.linalg.spsolve(sparse.csc_matrix(matrix), motions.sum(axis=1))
    for error in (rough, smooth, smooth * (1.0 + 0.1 * rough)):
        left = error - cycle @ (matrix @ error)
        assert left @ (matrix @ left) < 0.5 * error @ (matrix @ error)


def test_threads_give_the_same_numbers(elastic_block: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    matrix, motions = parts(elastic_block(**KINDS["space"]))
    cycle = multigrid.cycle_of(matrix, motions)
    right = np.random.default_rng(0).standard_normal(matrix.shape[0])
    expected = cycle @ right

    def in_three(n: int, part: Callable[[int, int], object]) -> None:
        for a, b in ((2 * n // 3, n), (0, n // 5), (n // 5, 2 * n // 3)):
            part(a, b)

    monkeypatch.setattr(multigrid, "over_range", in_three)
    assert np.array_equal(cycle @ right, expected)
    assert np.linalg.norm(expected) > 0.0


def test_iterations_hardly_grow_with_the_mesh(elastic_block: Any) -> None:
    """Eight times the cells: 31 and 33 iterations."""
    found = []
    for cells in (3, 6):
        system = elastic_block(dimension=3, cells=cells)
        factors = AmgGmres().factorise(system)
        factors.solve(np.random.default_rng(1).standard_normal(system.n_unknowns), 1e-8)
        found.append(factors.iterations)
    print(f"\n{found[0]} and {found[1]} iterations to 1e-8")
    assert 5 < found[0] <= 35
    assert found[1] <= 1.2 * found[0]


def test_the_smoother_is_chebyshevs_iteration(elastic_block: Any) -> None:
    """The compiled rows against products by scipy, to the single precision of the matrix."""
    matrix, motions = parts(elastic_block(**KINDS["space"]))
    blocks = in_node_blocks(matrix, motions)[0]
    m, n = blocks.shape[0] // 3, blocks.shape[0]
    rng = np.random.default_rng(2)
    right, x, step, inverse = (rng.standard_normal(size) for size in (n, n, n, (m, 3, 3)))
    rows = (blocks.indptr, blocks.indices, blocks.data.astype(np.float32))
    out, kept = np.full(n, np.nan), step.copy()
    bound = 1e-6 * float(abs(matrix).sum(axis=1).max()) * np.abs(x).max()
    missed = right - matrix @ x
    residual(*rows, right, x, out, 0, m)
    assert np.allclose(out, missed, rtol=0.0, atol=bound)
    descend(*rows, inverse, right, x, 0.7, 0.3, kept, out, 0, m)
    expected = 0.7 * np.einsum("mik,mk->mi", inverse, missed.reshape(m, 3)).ravel() + 0.3 * step
    assert np.allclose(kept, expected, rtol=0.0, atol=bound * 3.0 * np.abs(inverse).max())
    assert np.array_equal(out, x + kept)
    start(inverse, right, 0.7, kept, out, 0, m)
    assert np.allclose(out, 0.7 * np.einsum("mik,mk->mi", inverse, right.reshape(m, 3)).ravel(), rtol=1e-12)
    assert np.array_equal(out, kept)


def test_the_steps_are_as_small_as_a_polynomial_can_be() -> None:
    """What is left of the eigenvalues that they take on is Chebyshev's bound, and reached at both ends."""
    low, high = multigrid.LOWEST * 2.0, multigrid.HIGHEST * 2.0
    value = np.linspace(low, high, 401)
    x, step = np.zeros_like(value), np.zeros_like(value)
    steps = multigrid.chebyshev_steps(2.0)
    for share, kept in steps:
        step = share * (1.0 - value * x) + kept * step
        x = x + step
    left = 1.0 - value * x
    bound = 1.0 / np.cosh(len(steps) * np.arccosh((high + low) / (high - low)))
    assert np.abs(left).max() == pytest.approx(bound, rel=1e-12)
    assert np.abs(left[[0, -1]]) == pytest.approx(bound, rel=1e-12)
