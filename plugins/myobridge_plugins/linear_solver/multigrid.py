r"""One cycle of algebraic multigrid on a stiffness: an approximate inverse, symmetric where the stiffness is.

.. math:: \hat K^{-1}: \quad x \leftarrow p_d(D^{-1}K)\,D^{-1} b, \quad
          x \leftarrow x + P\,\hat K_1^{-1} P^T (b - K x), \quad x \leftarrow \text{smoothed again}

Smoothed aggregation (Vanek et al. [1]_) by pyamg, which is told the rigid motions; prolongations of small energy
(Mandel et al. [2]_) keep the iterations nearly the same on finer meshes. In space the finest level, where all the time
goes, is ours: blocks of a node's three numbers in single precision, and Chebyshev's polynomial of degree d of the
block-scaled matrix, whose rows threads share (Adams et al. [3]_); coarser levels are pyamg's. In the plane, and where
nothing is known of nodes, all levels are pyamg's.

References
----------
.. [1] P. Vanek, J. Mandel, M. Brezina, Computing 56 (1996) 179-196.
.. [2] J. Mandel, M. Brezina, P. Vanek, Computing 62 (1999) 205-228.
.. [3] M. Adams, M. Brezina, J. Hu, R. Tuminaro, J. Comput. Phys. 188 (2003) 593-610.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, final

import numpy as np

from myobridge.interfaces import Array
from myobridge.threads import over_range
from myobridge_plugins.linear_solver.node_blocks import in_node_blocks

__all__ = ["Cycle", "cycle_of"]

# Blocks of unknowns, one an aggregate of nodes, of the coarsest level, which is solved directly.
_COARSEST = 200
# Steps of the smoother before and after the coarser levels, and the part of the spectrum that it takes on.
_DEGREE, LOWEST, HIGHEST = 3, 1.0 / 20.0, 1.1
# Products that its largest eigenvalue is estimated from.
_POWERS = 12
_ENERGY = ("energy", {"krylov": "cg", "maxiter": 3, "degree": 1})


class Cycle(ABC):
    """An approximate inverse; ``cycle @ vector`` applies it."""

    sizes: tuple[int, ...]
    """Rows of the levels, the finest first."""

    @abstractmethod
    def __matmul__(self, vector: Array) -> Array: ...


def cycle_of(matrix: Any, rigid_motions: Array | None) -> Cycle:
    """A cycle for a symmetric matrix (CSR); `rigid_motions` has six columns in space, three in the plane."""
    if rigid_motions is not None and rigid_motions.shape[1] == 6:
        return _Space(matrix, rigid_motions)
    return _Plain(_hierarchy(matrix, rigid_motions))


@final
class _Plain(Cycle):
    """All levels by pyamg, a W-cycle."""

    def __init__(self, hierarchy: Any) -> None:
        self.sizes = tuple(level.A.shape[0] for level in hierarchy.levels)
        self._operator = hierarchy.aspreconditioner(cycle="W")

    def __matmul__(self, vector: Array) -> Array:
        return self._operator @ vector


@final
class _Space(Cycle):
    """The finest level in blocks of three, with Chebyshev's smoother."""

    def __init__(self, matrix: Any, rigid_motions: Array) -> None:
        import pyamg

        blocks, motions, places = in_node_blocks(matrix, rigid_motions)
        self._places: Any = places
        # The finest level has no smoother of pyamg's.
        smoothers: Any = [None, "block_gauss_seidel"]
        hierarchy = _hierarchy(blocks, motions, smooth=_ENERGY, presmoother=smoothers, postsmoother=smoothers)
        self.sizes = tuple(level.A.shape[0] for level in hierarchy.levels)
        self._rows, self._whole = blocks.shape[0] // 3, blocks.shape[0] == matrix.shape[0]
        self._matrix = (blocks.indptr, blocks.indices, blocks.data.astype(np.float32))
        self._inverse = _inverses(blocks)
        self._steps = chebyshev_steps(self._largest())
        levels = hierarchy.levels
        self._coarser: Any = None
        if len(levels) > 1:
            self._prolong, self._restrict = levels[0].P, levels[0].R
            coarsest: Any = _Coarsest()  # its types want the name of a solver
            rest = pyamg.MultilevelSolver(levels[1:], coarse_solver=coarsest)
            self._coarser = rest.aspreconditioner(cycle="W")

    def __matmul__(self, vector: Array) -> Array:
        if self._whole:
            return self._apply(vector)
        right = np.zeros(3 * self._rows)
        right[self._places] = vector
        return self._apply(right)[self._places]

    def _apply(self, right: Array) -> Array:
        from myobridge_plugins.linear_solver.chebyshev_kernels import residual, start

        right = np.ascontiguousarray(right, dtype=np.float64)
        found, step, spare = np.empty_like(right), np.empty_like(right), np.empty_like(right)
        share = self._steps[0][0]
        over_range(self._rows, lambda a, b: start(self._inverse, right, share, step, found, a, b))
        found, spare = self._smooth(self._steps[1:], right, found, spare, step)
        if self._coarser is not None:
            over_range(self._rows, lambda a, b: residual(*self._matrix, right, found, spare, a, b))
            found += self._prolong @ (self._coarser @ (self._restrict @ spare))
        return self._smooth(self._steps, right, found, spare, step)[0]

    def _smooth(
        self, steps: list[tuple[float, float]], right: Array, found: Array, spare: Array, step: Array
    ) -> tuple[Array, Array]:
        """The point after the steps, and memory that is free again."""
        for share, kept in steps:
            self._descend(right, found, share, kept, step, spare)
            found, spare = spare, found
        return found, spare

    def _descend(self, right: Array, x: Array, share: float, kept: float, step: Array, out: Array) -> None:
        """``step = share D^-1 (right - K x) + kept step; out = x + step``."""
        from myobridge_plugins.linear_solver.chebyshev_kernels import descend

        matrix, inverse = self._matrix, self._inverse
        over_range(self._rows, lambda a, b: descend(*matrix, inverse, right, x, share, kept, step, out, a, b))

    def _largest(self) -> float:
        """Largest eigenvalue of the block-scaled matrix, by the power method: a few per cent too small."""
        vector = np.random.default_rng(0).standard_normal(3 * self._rows)
        zero, image, unused, found = np.zeros_like(vector), np.zeros_like(vector), np.empty_like(vector), 1.0
        for _ in range(_POWERS):
            vector /= np.linalg.norm(vector)
            self._descend(zero, vector, 1.0, 0.0, image, unused)
            found = float(np.linalg.norm(image))
            vector, image = image, vector
        return found


def chebyshev_steps(largest: float) -> list[tuple[float, float]]:
    """Shares of residual and of the step before, for each step of Chebyshev's iteration.

    Source: Y. Saad, Iterative Methods for Sparse Linear Systems (2003), algorithm 12.1.
    """
    low, high = LOWEST * largest, HIGHEST * largest
    middle, radius = 0.5 * (high + low), 0.5 * (high - low)
    ratio, steps = radius / middle, [(1.0 / middle, 0.0)]
    for _ in range(_DEGREE - 1):
        following = 1.0 / (2.0 * middle / radius - ratio)
        steps.append((2.0 * following / radius, following * ratio))
        ratio = following
    return steps


def _inverses(blocks: Any) -> Array:
    """Inverses of the diagonal blocks, pseudo-inverses where one is singular."""
    from pyamg.util.utils import get_block_diag

    diagonal = get_block_diag(blocks, blocksize=3, inv_flag=False)
    try:
        return np.asarray(np.linalg.inv(diagonal), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(diagonal), dtype=np.float64)


def _hierarchy(matrix: Any, rigid_motions: Array | None, **options: Any) -> Any:
    import pyamg

    with _same_random_numbers():
        return pyamg.smoothed_aggregation_solver(
            matrix,
            B=rigid_motions,
            max_coarse=_COARSEST,
            coarse_solver=_Coarsest(),
            improve_candidates=None,
            **options,
        )


@contextmanager
def _same_random_numbers() -> Iterator[None]:
    """pyamg estimates spectral radii from random vectors of the global generator: the same ones every time."""
    state = np.random.get_state()  # noqa: NPY002
    np.random.seed(0)  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(state)  # noqa: NPY002


@final
class _Coarsest:
    """Solves on the coarsest level: Cholesky's factors, or a pseudo-inverse where it is not positive definite.

    pyamg's default is a pseudo-inverse by singular values: a third of the whole solve at 30 000 unknowns.
    """

    def __init__(self) -> None:
        self._inverse: Callable[[Array], Array] | None = None

    def __call__(self, matrix: Any, vector: Array) -> Array:
        if self._inverse is None:
            import scipy.linalg as linalg

            dense = matrix.toarray()
            try:
                factor = linalg.cho_factor(0.5 * (dense + dense.T), check_finite=False)
                self._inverse = lambda right: linalg.cho_solve(factor, right, check_finite=False)
            except linalg.LinAlgError:
                inverse = linalg.pinvh(0.5 * (dense + dense.T))
                self._inverse = lambda right: inverse @ right
        return self._inverse(vector)
