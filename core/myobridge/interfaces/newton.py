r"""Newton's methods: how a system of nonlinear equations is solved.

.. math:: F(x) = 0, \qquad F'(x_k)\,\delta_k = -F(x_k), \qquad x_{k+1} = x_k + \alpha_k\,\delta_k

A method sees a `NewtonProblem` only: the residual, its tangent, and what is physically possible. Unknowns and residuals
are vectors ``(n_unknowns,)``; whoever states the problem scales them so that one norm makes sense.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import attrs

from myobridge.interfaces.active_law import Array
from myobridge.interfaces.linear_solver import Factorisation, LinearSystem, SystemSize
from myobridge.interfaces.motion import Matrix

__all__ = ["KeptTangent", "NewtonMethod", "NewtonProblem", "NewtonResult", "NewtonStep", "NewtonTask"]


class NewtonProblem(ABC):
    """Equations to solve."""

    @abstractmethod
    def residual(self, unknowns: Array) -> tuple[Array, float]:
        """F(x), and the norm of the terms that cancel in it: a residual below their round-off is zero."""

    @abstractmethod
    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        """F'(x): a matrix, dense or sparse, or a system of two fields; mostly asked where the residual was last."""

    def admissible(self, unknowns: Array) -> bool:
        """Whether a point is physically possible (J > 0, stretch > 0)."""
        return True


class NewtonStep(NamedTuple):
    """One iteration: residual before it, share of the correction that was taken, iterations of the linear solver.

    The share is 1 unless the step was halved; a direct solver takes 0 iterations. `factorised` says whether the tangent
    was new.
    """

    residual: float
    fraction: float
    linear_iterations: int = 0
    factorised: bool = True


@attrs.frozen(eq=False)
class KeptTangent:
    """A tangent that outlives its solve, for problems much like the one it is of.

    Attributes
    ----------
    system : LinearSystem
        The tangent itself.
    factorisation : Factorisation or None
        Its factors; None after a checkpoint: whoever needs them factors the system again.
    work : ndarray
        What a method notes about it, such as the solves it has served; goes into checkpoints.
    arrays : mapping or None
        Matrices of the system by name, once it has been put into a memory.
    """

    system: LinearSystem
    factorisation: Factorisation | None
    work: Array
    arrays: Mapping[str, Array] | None = None


class NewtonResult(NamedTuple):
    """What a method found.

    Attributes
    ----------
    unknowns : ndarray, shape (n_unknowns,)
        Solution, or the last point.
    converged : bool
        Failure is a result, not an exception: the caller halves its step.
    iterations : int
        Corrections taken.
    reason : str
        Why it failed, in a sentence.
    history : tuple of NewtonStep
        How each iteration went.
    kept : KeptTangent or None
        A tangent near the solution, where the method keeps one: for the next solve.
    """

    unknowns: Array
    converged: bool
    iterations: int
    reason: str = ""
    history: tuple[NewtonStep, ...] = ()
    kept: KeptTangent | None = None


class NewtonTask(NamedTuple):
    """What a method is wanted for: many problems, each much like the one before.

    Attributes
    ----------
    size : SystemSize
        Of the linear systems.
    direct : bool
        Whether the linear solver that suits them factors, or iterates.
    path : bool
        A path of equilibria, whose step is controlled by the number of iterations; else steps in time.
    """

    size: SystemSize
    direct: bool
    path: bool = False


class NewtonMethod(ABC):
    """Abstract method; tolerances and limits are the attributes of a frozen class."""

    summary: ClassVar[str] = ""

    @classmethod
    def suits(cls, task: NewtonTask) -> bool:
        """Whether this is the method for a task where a scene names none; of small systems nobody is asked."""
        return False

    @abstractmethod
    def solve(self, problem: NewtonProblem, start: Array, kept: KeptTangent | None = None) -> NewtonResult:
        """Solve from `start`.

        Parameters
        ----------
        kept : KeptTangent, optional
            From the solve of a problem much like this one; a method that renews its tangent at once ignores it.
        """
