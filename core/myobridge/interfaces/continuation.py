r"""Continuation: follow a path of equilibria as a parameter grows, for scenes without time.

.. math:: F(u, \ell) = 0, \qquad \ell: 0 \to 1

A strategy sees a `ContinuationProblem` only: the residual, its derivatives and the verdict on stability. Every accepted
point carries its iteration count and the inertia of its tangent, so that an unstable state is never silently accepted.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import ClassVar

import attrs
import numpy as np

from myobridge.interfaces.active_law import Array
from myobridge.interfaces.linear_solver import Factorisation, LinearSystem
from myobridge.interfaces.motion import Matrix

__all__ = ["ContinuationPath", "ContinuationProblem", "ContinuationStrategy", "PathPoint"]


class ContinuationProblem(ABC):
    """Equilibrium problem with one parameter."""

    @abstractmethod
    def residual(self, unknowns: Array, level: float) -> Array:
        """F(u, l), shape (n_unknowns,)."""

    @abstractmethod
    def tangent(self, unknowns: Array, level: float) -> Matrix | LinearSystem:
        """dF/du, shape (n_unknowns, n_unknowns): dense, sparse, or a system of two fields."""

    @abstractmethod
    def level_derivative(self, unknowns: Array, level: float) -> Array:
        """dF/dl, shape (n_unknowns,)."""

    @abstractmethod
    def negative_eigenvalues(self, unknowns: Array, level: float, factorisation: Factorisation | None = None) -> int:
        """Negative eigenvalues of the tangent beyond those of a stable state: 0 is stable, -1 not known.

        Strategies hand over the factorisation of the tangent where they have one; it may know the answer.
        """

    def admissible(self, unknowns: Array) -> bool:
        """Whether the state is physically possible."""
        return True

    def magnitude(self, unknowns: Array, level: float) -> float:
        """Norm of the terms that cancel in the residual, whose round-off it cannot beat; unless said, the full load."""
        return float(np.linalg.norm(self.level_derivative(unknowns, level)))

    def weights(self) -> Array | float:
        """Weight of each unknown in the length of a change, so that units can be mixed; 0 leaves a multiplier out."""
        return 1.0

    def softened(self, bulk_modulus: float) -> ContinuationProblem | None:
        """The same problem, with the same unknowns, of a tissue whose bulk modulus [Pa] is at most this.

        None where there is no bulk modulus to lower.
        """
        return None


@attrs.frozen(eq=False)
class PathPoint:
    """Accepted point of a path: unknowns, level, Newton iterations spent, negative eigenvalues.

    Of these 0 is stable, -1 not known.
    """

    unknowns: Array
    level: float
    iterations: int
    negative_eigenvalues: int


@attrs.frozen(eq=False)
class ContinuationPath:
    """Points found; `completed` False when the path ends early, and then `reason` says where, why and what to try."""

    points: tuple[PathPoint, ...]
    completed: bool
    reason: str = ""


class ContinuationStrategy(ABC):
    """Abstract strategy; step sizes and limits are the attributes of a frozen class.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    softens : bool
        Whether it asks the problem for softer ones (`ContinuationProblem.softened`).
    """

    summary: ClassVar[str] = ""
    softens: ClassVar[bool] = False

    @abstractmethod
    def trace(
        self,
        problem: ContinuationProblem,
        start: Array,
        *,
        stops: Sequence[float] = (),
        watch: Callable[[PathPoint], object] | None = None,
        earlier: Sequence[PathPoint] = (),
    ) -> ContinuationPath:
        """Follow the path from `start` at level 0 to level 1, keeping every accepted point.

        Parameters
        ----------
        start : ndarray, shape (n_unknowns,)
            Where the equilibrium at level 0 is sought.
        stops : sequence of float
            Levels in (0, 1), rising, at which a point of the path must lie exactly, each the first time it is reached.
        watch : callable, optional
            Told every point as soon as it is accepted; what it raises ends the tracing.
        earlier : sequence of PathPoint
            Last points of a path that ended early, in order, to be continued: `start` is not looked at, the answer
            begins with them, and `watch` is told new ones only. Two of them tell the direction of the path.
        """
