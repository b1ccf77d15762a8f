r"""The tangent that a method holds on to: its factors, and the account by which they are renewed.

.. math:: c_k > \frac{1}{k} \Bigl(W + \sum_{j \le k} c_j\Bigr)

`c` are the applications of the factors in each solve since they were made, `W` what the factors are worth in such
applications (`Factorisation.worth`). The right side is what a solve has cost on the average, factors included. As long
as the last solve cost less than that, keeping the factors lowers the average; from then on it is cheaper to begin anew.
No clock is read: a run does not depend on what else the machine does.
"""

from __future__ import annotations

from typing import final

import numpy as np

from myobridge.interfaces import Factorisation, KeptTangent, LinearSolver, LinearSystem, Matrix
from myobridge.solvers.choice import Automatic, factorise
from myobridge.solvers.linear import norm_of

__all__ = ["HeldTangent"]

# Asymmetry, relative, up to which the symmetric part serves: its factors cost half as much, and nothing is exact here.
_ASYMMETRY = 0.3


@final
class HeldTangent:
    """Tangent of a method that does not make a new one for every iteration.

    Parameters
    ----------
    kept : KeptTangent, optional
        From an earlier solve. Where its factors are gone, as after a checkpoint, the same ones are made again.
    linear : LinearSolver, optional
        Chosen by size unless given, and then rough: factors in single precision where they hold.

    Attributes
    ----------
    fresh : bool
        Whether the tangent is of this solve.
    """

    def __init__(self, kept: KeptTangent | None, linear: LinearSolver | None) -> None:
        self._linear = linear or Automatic().rough()
        self._kept = kept
        self._spent = 0
        self.fresh = False
        # Applications for each digit of a linear system, of the last one and of the best one.
        self._rate, self._least = 0.0, np.inf if kept is None else float(kept.work[2])
        if kept is not None and kept.factorisation is None:
            self._kept = KeptTangent(kept.system, factorise(kept.system, self._linear), kept.work, kept.arrays)

    @property
    def empty(self) -> bool:
        """Whether there is no tangent yet."""
        return self._kept is None

    @property
    def system(self) -> LinearSystem:
        """What was factored: the tangent, or one near it."""
        assert self._kept is not None
        return self._kept.system

    @property
    def factors(self) -> Factorisation:
        """Its factors."""
        assert self._kept is not None
        assert self._kept.factorisation is not None
        return self._kept.factorisation

    @property
    def overdrawn(self) -> bool:
        """Whether this solve alone has cost more than new factors."""
        return self._spent > self.factors.worth

    def renew(self, tangent: Matrix | LinearSystem) -> None:
        """Take another tangent.

        Raises
        ------
        SingularMatrix
            If it has no inverse; the earlier one stays.
        """
        system = _nearby(tangent if isinstance(tangent, LinearSystem) else LinearSystem(tangent, symmetric=False))
        self._kept = KeptTangent(system, factorise(system, self._linear), np.array([0.0, 0.0, np.inf]))
        self._spent, self.fresh = 0, True
        self._rate, self._least = 0.0, np.inf

    def charge(self, applications: int, digits: float = 0.0) -> None:
        """Note applications of the factors; where they solved a system, the digits of its residual too."""
        self._spent += applications
        if digits > 0.0:
            self._rate = applications / digits
            self._least = min(self._rate, self._least)

    def worn(self, digits: float) -> bool:
        """Whether a system solved to these digits would cost more than with new factors, these included.

        What they would take is known from the best of the systems since the factors were made.
        """
        return (self._rate - self._least) * digits > self.factors.worth

    def handed_on(self) -> KeptTangent | None:
        """The tangent for the next solve, with its account; None where a new one is cheaper."""
        if self._kept is None:
            return None
        if self._spent == 0:  # no solve to count
            return self._kept
        solves, spent = self._kept.work[0] + 1.0, self._kept.work[1] + self._spent
        if solves > 1.0 and self._spent * solves > self.factors.worth + spent:
            return None
        kept = self._kept
        return KeptTangent(kept.system, kept.factorisation, np.array([solves, spent, self._least]), kept.arrays)


def _nearby(system: LinearSystem) -> LinearSystem:
    """The system in the form in which it is kept and recalled, and symmetric where it almost is."""
    import scipy.sparse as sparse

    if isinstance(system.stiffness, np.ndarray):
        return system
    stiffness = sparse.csr_array(system.stiffness)
    acting, gradient = system.transposed_gradient, system.gradient
    compliance = None if system.compliance is None else sparse.csr_array(system.compliance)
    acting = None if acting is None else sparse.csr_array(acting)
    gradient = acting if gradient is system.transposed_gradient else sparse.csr_array(gradient)
    symmetric = system.symmetric
    if not symmetric:
        turned = sparse.csr_array(stiffness.T)
        near = norm_of(stiffness - turned) <= _ASYMMETRY * norm_of(stiffness)
        if near and acting is not None and gradient is not None and gradient is not acting:
            near = norm_of(acting - gradient) <= _ASYMMETRY * norm_of(gradient)
        if near:
            stiffness, gradient, symmetric = sparse.csr_array(0.5 * (stiffness + turned)), acting, True
    return LinearSystem(stiffness, acting, gradient, compliance, system.rigid_motions, symmetric)
