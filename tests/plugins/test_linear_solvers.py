"""Linear solvers against dense solves and each other: plain, saddle, with compliance, unsymmetric, singular."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest
import scipy.sparse as sparse

import myobridge as mb
from myobridge.errors import PluginError
from myobridge.interfaces import Factorisation, LinearSolver, LinearSystem, SystemSize
from myobridge.solvers import (
    Automatic,
    InertiaUnknown,
    SingularMatrix,
    UnsolvedSystem,
    absolute_product,
    bordered,
    choose,
    factorise,
    inertia,
    solve,
    stability,
)
from myobridge_plugins.linear_solver import pardiso
from myobridge_plugins.linear_solver.amg_gmres import AmgGmres
from myobridge_plugins.linear_solver.mumps import Mumps
from myobridge_plugins.linear_solver.pardiso import Pardiso
from myobridge_plugins.linear_solver.superlu import SuperLU

NAMES = mb.registry().names("linear_solver")
DIRECT = [name for name in NAMES if name != "amg_gmres"]


def solver(name: str) -> LinearSolver:
    found = mb.registry().find("linear_solver", name).cls()
    if found.obstacle():
        pytest.skip(found.obstacle())
    return found


SYSTEMS: dict[str, dict[str, Any]] = {
    "plane": {"dimension": 2, "cells": 3},
    "plane, soft": {"dimension": 2, "cells": 3, "bulk_modulus": 1e5},
    "space": {"dimension": 3, "cells": 2},
    "space, stiff fibres": {"dimension": 3, "cells": 2, "fibre": 3e5},
    "space, nearly incompressible": {"dimension": 3, "cells": 2, "bulk_modulus": 1e9},
}


def one_of(elastic_block: Callable[..., LinearSystem], name: str) -> LinearSystem:
    return elastic_block(**SYSTEMS[name])


def twisted(system: LinearSystem) -> LinearSystem:
    """With a follower load's unsymmetric stiffness, and the gradients at two points of a step."""
    n = system.stiffness.shape[0]
    skew = sparse.diags_array([np.full(n - 3, 1.0), np.full(n - 3, -1.0)], offsets=[3, -3])
    assert system.gradient is not None
    return attrs.evolve(
        system,
        stiffness=sparse.csr_array(system.stiffness + 0.05 * system.stiffness.diagonal().mean() * skew),
        gradient=sparse.csr_array(1.02 * system.gradient),
        symmetric=False,
    )


def right_side(system: LinearSystem) -> np.ndarray:
    return np.random.default_rng(1).standard_normal(system.n_unknowns)


@pytest.mark.parametrize("change", [None, twisted], ids=["symmetric", "unsymmetric"])
@pytest.mark.parametrize("kind", SYSTEMS)
@pytest.mark.parametrize("name", NAMES)
def test_every_solver_agrees_with_a_dense_solve(name: str, kind: str, change: Any, elastic_block: Any) -> None:
    system = one_of(elastic_block, kind)
    system = change(system) if change else system
    right = right_side(system)
    expected = np.linalg.solve(system.matrix().toarray(), right)
    factors = solver(name).factorise(system)
    found = factors.solve(right, 1e-10)
    assert np.linalg.norm(right - system.times(found)) <= 1e-10 * np.linalg.norm(right)
    condition = np.linalg.cond(system.matrix().toarray())
    # 1e-10 in the residual, times the condition, is what the error may be.
    assert np.linalg.norm(found - expected) <= 1e-10 * condition * np.linalg.norm(expected)
    assert (factors.iterations > 0) == (name == "amg_gmres")
    assert name in factors.describe()
    assert np.all(factors.solve(np.zeros_like(right)) == 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_one_field(name: str, elastic_block: Any) -> None:
    both = one_of(elastic_block, "space")
    system = LinearSystem(both.stiffness, rigid_motions=both.rigid_motions)
    right = right_side(system)
    found = solver(name).factorise(system).solve(right, 1e-10)
    assert np.linalg.norm(right - system.stiffness @ found) <= 1e-10 * np.linalg.norm(right)


@pytest.mark.parametrize("name", NAMES)
def test_a_matrix_without_an_inverse_is_an_error(name: str, elastic_block: Any) -> None:
    """A pressure that acts on nothing; and one pressure twice, which only a right side outside its range betrays."""
    system = one_of(elastic_block, "plane")
    assert system.gradient is not None
    n_u, m = system.gradient.shape[1], system.n_constraints
    empty = sparse.vstack([system.gradient, sparse.csr_array((1, n_u))], format="csr")
    twice = sparse.vstack([system.gradient, system.gradient[:1]], format="csr")
    found = solver(name)
    right = np.zeros(n_u + m + 1)
    right[-1] = 1.0
    for gradient in (empty, twice):
        broken = attrs.evolve(system, gradient=gradient, transposed_gradient=gradient)
        with pytest.raises((SingularMatrix, UnsolvedSystem)):
            found.factorise(broken).solve(right)


@pytest.mark.parametrize("name", NAMES)
def test_a_matrix_that_is_not_finite_is_an_error(name: str, elastic_block: Any) -> None:
    system = one_of(elastic_block, "plane")
    broken = system.stiffness.copy()
    broken.data[7] = np.nan
    with pytest.raises(SingularMatrix):
        solver(name).factorise(attrs.evolve(system, stiffness=broken))


def test_iterations_that_do_not_arrive_are_an_error_that_says_how_far(elastic_block: Any) -> None:
    factors = AmgGmres(max_iterations=10).factorise(one_of(elastic_block, "space"))
    with pytest.raises(UnsolvedSystem, match=r"left \d\.\de-\d\d of the right side after 1\d iterations.*superlu"):
        factors.solve(right_side(one_of(elastic_block, "space")))


def test_restarts_arrive_too(elastic_block: Any) -> None:
    system = one_of(elastic_block, "plane")
    factors = AmgGmres(restart=15).factorise(system)
    found = factors.solve(right_side(system), 1e-10)
    assert factors.iterations > 15
    assert np.linalg.norm(right_side(system) - system.times(found)) <= 1e-10 * np.linalg.norm(right_side(system))


def test_a_nearly_singular_matrix_is_not_solved_wrongly() -> None:
    """Two rows that differ by 1e-13: factors exist, and mean nothing."""
    matrix = sparse.csr_array(sparse.block_diag([np.array([[1.0, 1.0], [1.0, 1.0 + 1e-15]]), np.eye(200)]))
    with pytest.raises((SingularMatrix, UnsolvedSystem)):
        SuperLU().factorise(LinearSystem(matrix)).solve(np.arange(202.0))


def test_multigrid_is_the_same_every_time_and_leaves_the_global_generator_alone(elastic_block: Any) -> None:
    system = one_of(elastic_block, "space")
    np.random.seed(5)  # noqa: NPY002
    expected = np.random.rand()  # noqa: NPY002
    np.random.seed(5)  # noqa: NPY002
    first = AmgGmres().factorise(system).solve(right_side(system))
    assert np.random.rand() == expected  # noqa: NPY002
    np.testing.assert_array_equal(AmgGmres().factorise(system).solve(right_side(system)), first)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["plane", "space, stiff fibres"])
@pytest.mark.parametrize("shift", [0.0, 2e-3, 6e-3])
def test_stability_is_that_of_the_eigenvalues(name: str, kind: str, shift: float, elastic_block: Any) -> None:
    """Where a solver cannot tell it says so; where it iterates it may count too few, and never none."""
    system = one_of(elastic_block, kind)
    n = system.stiffness.shape[0]
    stiffness = system.stiffness - shift * system.stiffness.diagonal().mean() * sparse.eye_array(n)
    system = attrs.evolve(system, stiffness=sparse.csr_array(stiffness))
    true = int((np.linalg.eigvalsh(system.matrix().toarray()) < 0.0).sum()) - system.n_constraints
    assert (true > 0) == (shift > 0.0)
    factors = solver(name).factorise(system)
    known = factors.inertia()
    if name == "superlu":
        assert known is None
    elif name == "amg_gmres":
        assert known is not None
        assert min(true, 1) <= known.negative - system.n_constraints <= true
    else:
        assert known == (true + system.n_constraints, 0, n - true)
    assert min(true, 1) <= stability(system, factors) <= true
    assert stability(system) == true


def only_amg(monkeypatch: Any) -> None:
    """As for a body too large for factors."""
    import myobridge.solvers.choice as choice

    monkeypatch.setattr(choice, "installed", lambda **_: {"amg_gmres": AmgGmres()})


def test_stability_that_nobody_can_tell_is_not_called_stable(elastic_block: Any, monkeypatch: Any) -> None:
    """With compliance the iterations can only find what is unstable, and a proof does not fit beyond some size."""
    only_amg(monkeypatch)
    system = one_of(elastic_block, "space, nearly incompressible")
    with pytest.raises(InertiaUnknown, match="not counted"):
        stability(system)
    n = system.stiffness.shape[0]
    soft = sparse.csr_array(system.stiffness - 6e-3 * system.stiffness.diagonal().mean() * sparse.eye_array(n))
    assert stability(attrs.evolve(system, stiffness=soft)) > 0


def test_the_choice_and_its_reason() -> None:
    alone = {"superlu": SuperLU(), "amg_gmres": AmgGmres()}
    assert choose(SystemSize(5_000, 3), alone).name == "superlu"
    assert choose(SystemSize(50_000, 3), alone).name == "amg_gmres"
    assert choose(SystemSize(50_000, 2), alone).name == "superlu"
    assert choose(SystemSize(50_000, 3, structured=False), alone).name == "superlu"
    assert choose(SystemSize(50_000, 3), alone | {"pardiso": Pardiso()}).name == "pardiso"
    assert choose(SystemSize(500, 3), alone | {"pardiso": Pardiso()}).name == "superlu"
    assert choose(SystemSize(200_000, 3), alone | {"pardiso": Pardiso()}).name == "amg_gmres"
    assert choose(SystemSize(200_000, 3, structured=False), alone | {"mumps": Mumps()}).name == "mumps"
    assert choose(SystemSize(50_000, 3), {"mumps": Mumps(), "pardiso": Pardiso()}).name == "pardiso"
    assert choose(SystemSize(50_000, 3), alone).reason == "50000 unknowns in 3D: about 6.8 s a system, superlu 29 s"
    with pytest.raises(PluginError, match="no installed linear solver is for a system of 9 unknowns in 2D"):
        choose(SystemSize(9, 2, structured=False), {"amg_gmres": AmgGmres()})


def test_a_stranger_joins_the_choice_by_what_it_costs() -> None:
    class Fast(LinearSolver):
        def seconds(self, size: SystemSize) -> float:
            return 1e-9

        def factorise(self, system: LinearSystem) -> Factorisation:
            raise NotImplementedError

    solvers = {"superlu": SuperLU(), "fast": Fast()}
    assert choose(SystemSize(5_000, 3), solvers).name == "fast"


def test_automatic_tells_what_it_chose(elastic_block: Any, monkeypatch: Any) -> None:
    import myobridge.solvers.choice as choice

    monkeypatch.setattr(choice, "installed", lambda: {"superlu": SuperLU(), "amg_gmres": AmgGmres()})
    system = one_of(elastic_block, "space")
    assert "superlu" in Automatic().factorise(system).describe()
    only_amg(monkeypatch)
    factors = Automatic().factorise(system)
    assert "amg_gmres" in factors.describe()
    assert "in 3D" in factors.describe()
    factors.solve(right_side(system), 1e-8)
    assert factors.iterations > 0
    monkeypatch.undo()
    # The plane is recognised by its rigid motions, or by its rows.
    flat = one_of(elastic_block, "plane")
    for one in (flat, attrs.evolve(flat, rigid_motions=None)):
        assert "in 2D" in Automatic().factorise(one).describe()


def test_a_solver_that_is_absent_says_what_to_install() -> None:
    absent = [name for name in NAMES if mb.registry().find("linear_solver", name).cls().obstacle()]
    if not absent:
        pytest.skip("every solver is installed")
    for name in absent:
        with pytest.raises(PluginError, match="install"):
            factorise(sparse.eye_array(300, format="csr"), mb.registry().find("linear_solver", name).cls())


def test_a_border_of_a_system_is_that_of_its_matrix(elastic_block: Any) -> None:
    random = np.random.default_rng(2)
    for kind in ("plane", "plane, soft"):
        system = one_of(elastic_block, kind)
        column, row = random.standard_normal((2, system.n_unknowns))
        whole = bordered(system, column, row, 3.0)
        assert isinstance(whole, LinearSystem)
        expected = bordered(system.matrix(), column, row, 3.0).toarray()  # pyright: ignore
        # The last unknown of both is the level.
        np.testing.assert_array_equal(whole.matrix().toarray(), expected)
        vector = random.standard_normal(whole.n_unknowns)
        np.testing.assert_allclose(expected @ solve(whole, vector), vector, atol=1e-9)
        np.testing.assert_allclose(absolute_product(whole, vector), np.abs(expected) @ np.abs(vector), rtol=1e-12)
    plain = LinearSystem(system.stiffness)
    border = [random.standard_normal(plain.n_unknowns) for _ in range(2)]
    np.testing.assert_array_equal(
        bordered(plain, *border, 3.0).matrix().toarray(),  # pyright: ignore
        bordered(plain.stiffness, *border, 3.0).toarray(),  # pyright: ignore
    )


def test_inertia_of_a_direct_solver_is_the_proven_one(elastic_block: Any) -> None:
    system = one_of(elastic_block, "plane, soft")
    for name in DIRECT:
        found = mb.registry().find("linear_solver", name).cls()
        if not found.obstacle() and name != "superlu":
            assert found.factorise(system).inertia() == inertia(system.matrix())
    assert stability(system) == 0


@pytest.mark.parametrize("alone", [True, False], ids=["stiffness", "nothing on the diagonal"])
def test_pardiso_pivots_in_pairs_where_it_must(alone: bool, elastic_block: Any, monkeypatch: Any) -> None:
    """A chain with nothing on the diagonal leaves 1x1 pivots nothing to stand on."""
    if Pardiso().obstacle():
        pytest.skip(Pardiso().obstacle())
    made, kinds = pardiso._Call.__init__, []

    def spied(self: Any, matrix: Any, settings: dict[int, int], kind: int, *, single: bool) -> None:
        kinds.append(settings[21])
        made(self, matrix, settings, kind, single=single)

    monkeypatch.setattr(pardiso._Call, "__init__", spied)
    links = np.random.default_rng(0).uniform(0.5, 2.0, 399)
    chain = LinearSystem(sparse.csr_array(sparse.diags_array([links, links], offsets=[1, -1])))
    system = one_of(elastic_block, "space") if alone else chain
    right = right_side(system)
    found = Pardiso().factorise(system).solve(right, 1e-10)
    assert np.linalg.norm(right - system.times(found)) <= 1e-10 * np.linalg.norm(right)
    assert kinds == ([2] if alone else [2, 1])
