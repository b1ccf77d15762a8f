r"""What all direct solvers share: refinement of the solution, and two proofs that it is one.

.. math:: r = b - A x, \qquad x \leftarrow x + A^{-1} r, \qquad
          \|r\| \le \max(\tau\,\|b\|,\; c\,\varepsilon\,\|A\|\,\|x\|)

The second bound is what round-off leaves of any stable elimination; above 1e-6 of `b` it is no excuse. A matrix that is
singular to round-off is found by two steps of inverse iteration from a fixed vector, which cost two solves, a small
part of a factorisation: factors of such a matrix exist as a rule, and are noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

import numpy as np

from myobridge.interfaces import Array, Factorisation, SystemSize
from myobridge.solvers import Inertia, SingularMatrix, UnsolvedSystem

__all__ = ["PRECISIONS", "DirectFactorisation", "in_single", "multifrontal_seconds"]

_EPS = float(np.finfo(float).eps)
# Steps of refinement; more than two gain nothing unless the factors are bad.
_REFINEMENTS = 3
# Tolerances above this are for corrections that need not be exact.
_ROUGH = 1e-6
# What a stable elimination leaves, in units of round-off.
_STABLE = 100.0
# A residual above this share of the right side is no solution.
_WORST = 1e-6
# Condition numbers beyond this are those of singular matrices.
_SINGULAR = 1e14
# Single precision: steps of refinement, and the share of a residual that a step may leave.
_MORE_REFINEMENTS = 30
_CONTRACTION = 0.1

# Of the factors; residuals are always in double precision.
PRECISIONS = ("double", "single")

# Unknowns beyond which multifrontal factors take more than 8 GB, in the plane and in space.
_LARGEST = {2: 2_000_000, 3: 120_000}


def multifrontal_seconds(size: SystemSize) -> float | None:
    """Roughly, CPU seconds of multifrontal factors; None where they would not fit and iterations can do without."""
    n = size.n_unknowns
    if size.structured and n > _LARGEST[size.dimension]:
        return None
    return 0.05 + (0.45 * (n / 6e3) ** 1.25 if size.dimension == 3 else 1.05 * (n / 58e3) ** 1.1)


def in_single(solve: Callable[[Any], Any]) -> Callable[[Array], Array]:
    """A solve in single precision for vectors in double, of any length: 1e-40 is zero in single precision."""

    def inverse(vector: Array) -> Array:
        size = float(np.linalg.norm(vector))
        if size == 0.0:
            return np.zeros_like(vector)
        return size * np.asarray(solve((vector / size).astype(np.float32)), dtype=np.float64)

    return inverse


@final
class DirectFactorisation(Factorisation):
    """Factors of a sparse matrix, as the function that applies its inverse.

    Factors in single precision contract the residual by about ``1e-7`` times the condition in each refinement. Where
    that is not below 0.1 they are no use and singular to this class; a right side for which they do not arrive gets
    factors in double precision.

    Parameters
    ----------
    matrix : sparse array, shape (n, n)
        The whole matrix, for residuals.
    inverse : callable
        Approximate solution of one right side.
    text : str
        What solves, for `describe` and for errors.
    known : Inertia, optional
        Signs of the eigenvalues, where the factors tell them.
    worth : float
        How many applications of `inverse` cost as much as the factors.
    double : callable, optional
        Where `inverse` is in single precision: makes the inverse in double precision.

    Raises
    ------
    SingularMatrix
        If the matrix is singular to round-off.
    """

    def __init__(
        self,
        matrix: Any,
        inverse: Callable[[Array], Array],
        text: str,
        known: Inertia | None = None,
        *,
        worth: float = 50.0,
        double: Callable[[], Callable[[Array], Array]] | None = None,
    ) -> None:
        self._matrix, self._inverse, self._text, self._known = matrix, inverse, text, known
        self._worth, self._double = worth, double
        self._exact: DirectFactorisation | None = None
        self._norm = float(abs(matrix).sum(axis=0).max())
        probe = np.random.default_rng(0).standard_normal(matrix.shape[0])
        for _ in range(2):
            probe /= np.linalg.norm(probe)
            before = probe
            with np.errstate(all="ignore"):
                probe = inverse(probe)
                longest = float(np.linalg.norm(probe))
            if not longest * self._norm < _SINGULAR:
                raise SingularMatrix
        # The probe is rich in what the matrix almost loses: no vector is solved worse.
        if double is not None and not float(np.linalg.norm(before - matrix @ probe)) < _CONTRACTION:
            raise SingularMatrix

    def solve(self, vector: Array, tolerance: float = 1e-12) -> Array:
        size = float(np.linalg.norm(vector))
        if size == 0.0:
            return np.zeros_like(vector)
        found = self._inverse(vector)
        best, missed = found, np.inf
        for refined in range((_REFINEMENTS if self._double is None else _MORE_REFINEMENTS) + 1):
            rest = vector - self._matrix @ found
            now = float(np.linalg.norm(rest))
            if not now < missed:
                break
            best, missed = found, now
            # One refinement unless little is asked for: it costs little, and small terms of the right side want it.
            if missed <= tolerance * size and (refined > 0 or tolerance > _ROUGH):
                return best
            found = found + self._inverse(rest)
        round_off = _STABLE * _EPS * self._norm * float(np.linalg.norm(best))
        if missed <= max(tolerance * size, min(round_off, _WORST * size)):
            return best
        if self._double is not None:
            # For this right side only: what the next one gets does not depend on those before it.
            self._exact = self._exact or DirectFactorisation(self._matrix, self._double(), self._text)
            return self._exact.solve(vector, tolerance)
        raise UnsolvedSystem(
            f"{self._text} left {missed / size:.1e} of the right side, allowed is {tolerance:.1e} or round-off "
            f"({round_off / size:.1e}): the matrix is close to singular"
        )

    def approximate(self, vector: Array) -> Array:
        return self._inverse(vector)

    @property
    def worth(self) -> float:
        return self._worth

    def inertia(self) -> Inertia | None:
        return self._known

    def describe(self) -> str:
        return self._text
