"""Continuation in two parameters: load and bulk modulus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple, final

import attrs

from myobridge.errors import ParameterError, PluginError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    Array,
    ContinuationPath,
    ContinuationProblem,
    ContinuationStrategy,
    NewtonMethod,
    PathPoint,
)
from myobridge.parameters import integer, number, part
from myobridge_plugins.continuation.equilibrium import accepted, equilibrium, slope
from myobridge_plugins.continuation.last_tangent import LastTangent
from myobridge_plugins.continuation.stops import Watch, keep, next_stop

__all__ = ["TwoParameter"]


class Pair(NamedTuple):
    """Equilibria of the softest tissue and of the tissue itself at one level; a complaint where there are none."""

    soft: Array
    hard: Array
    iterations: int
    complaint: str = ""


@final
@attrs.frozen
class TwoParameter(ContinuationStrategy):
    r"""Continuation in level and bulk modulus (thesis [1]_, Method 4.5): at every level the tissue is hardened.

    .. math:: F(u; \ell, \gamma) = 0, \qquad \kappa(\gamma) = 10^{\,n_0 + \gamma (n_1 - n_0)}, \qquad
              \gamma: 0 \to 1

    The level is raised as by `natural`, in a tissue soft enough (:math:`\gamma = 0`) that Newton converges; at each
    level gamma is raised to 1 in the same way, and a last solution is that of the tissue itself, whatever its bulk
    modulus. Where the hardening fails although its steps were halved, the step of the level is halved.

    The path is continuous in the soft tissue only. Hardened states of neighbouring levels may lie on different
    branches: this method steps over limit points of the tissue itself, where `natural` ends and `arclength` goes round.

    Parameters
    ----------
    first_exponent, last_exponent : float
        n0 and n1, powers of ten of the bulk modulus [Pa]; where the tissue itself is softer, it stays as it is.
    step, smallest : float
        Largest and smallest step of the level [-].
    hardening, smallest_hardening : float
        Largest and smallest step of gamma [-].
    easy : int
        Newton iterations up to which a step is easy.
    newton : NewtonMethod, optional
        Method, tolerance, iterations, linear solver; unless given one that suits the size, to 1e-10 in at most 20
        iterations.

    Departures
    ----------
    The thesis ends at :math:`\kappa(1)`, close to incompressible; here every accepted state is one of the tissue
    itself. The soft tissue of the next level is reached from that of the last one, not from the hardened state.

    References
    ----------
    .. [1] Thesis, Methods 4.4 and 4.5; its bulk moduli are 1e4 and about 1e7 (its unit: Pa).
    """

    summary: ClassVar[str] = "at every level hardens the tissue from a low bulk modulus (thesis, Method 4.5)"
    softens: ClassVar[bool] = True

    first_exponent: float = number(4.0, within="[-300, 300]", doc="power of ten of the first bulk modulus in Pa")
    last_exponent: float = number(7.0, within="[-300, 300]", doc="power of ten of the last bulk modulus in Pa")
    step: float = number(0.1, within="(0, 1]", doc="largest step of the level")
    smallest: float = number(1e-4, within="(0, 1]", doc="smallest step of the level, at which it gives up")
    hardening: float = number(0.5, within="(0, 1]", doc="largest step of gamma")
    smallest_hardening: float = number(0.02, within="(0, 1]", doc="smallest step of gamma")
    easy: int = integer(6, within="[1, inf)", doc="iterations up to which a step is easy, and the next one larger")
    newton: NewtonMethod | None = part(
        "newton", None, doc="Newton's method; chosen by size unless given, to 1e-10 in at most 20 iterations"
    )

    def __attrs_post_init__(self) -> None:
        if not self.first_exponent < self.last_exponent:
            raise ParameterError(
                "last_exponent",
                f"is {self.last_exponent:g}; expected a number above first_exponent, {self.first_exponent:g}",
            )

    def trace(
        self,
        problem: ContinuationProblem,
        start: Array,
        *,
        stops: Sequence[float] = (),
        watch: Watch | None = None,
        earlier: Sequence[PathPoint] = (),
    ) -> ContinuationPath:
        softest = problem.softened(10.0**self.first_exponent)
        if softest is None:
            raise PluginError(
                "the continuation 'two_parameter' needs a tissue with a bulk modulus that can be lowered, and this "
                "problem offers none: use 'natural' or 'arclength', or a solid with the effect 'incompressibility'"
            )
        # One tangent of the softest tissue, to the next level; harder ones are too different.
        points, last = list(earlier), LastTangent(self.newton)
        level = points[-1].level if points else 0.0
        guess = points[-1].unknowns if points else start
        if points:  # of the path so far only hardened states are known
            again = equilibrium(softest, guess, level, self.newton, last)
            soft = again.unknowns if again.converged else guess
        else:
            pair = self._pair(problem, softest, guess, 0.0, last)
            if pair.complaint:
                return ContinuationPath((), False, f"no equilibrium at level 0 from the given start: {pair.complaint}.")
            soft = pair.soft
            keep(points, accepted(problem, pair.hard, 0.0, pair.iterations), watch)
        halvings, spent = 0, 0
        while points[-1].level < 1.0:
            here = points[-1].level
            step = self.step / 2.0**halvings
            stop = next_stop(points, stops)
            level = stop if here + step > stop - 0.5 * self.smallest else here + step
            guess = self._guess(softest, soft, here, level, last)
            pair = self._pair(problem, softest, guess, level, last)
            spent += pair.iterations
            if not pair.complaint:
                soft = pair.soft
                keep(points, accepted(problem, pair.hard, level, spent), watch)
                spent, halvings = 0, max(halvings - 1, 0)
            elif step / 2.0 < self.smallest:
                return ContinuationPath(tuple(points), False, self._advice(points, level, pair.complaint))
            else:
                halvings += 1
        return ContinuationPath(tuple(points), True)

    def _guess(self, softest: ContinuationProblem, soft: Array, here: float, level: float, last: LastTangent) -> Array:
        ahead = slope(softest, soft, here, last)
        if ahead is None:
            return soft
        guess = soft + (level - here) * ahead
        return guess if softest.admissible(guess) else soft

    def _pair(
        self,
        problem: ContinuationProblem,
        softest: ContinuationProblem,
        guess: Array,
        level: float,
        last: LastTangent,
    ) -> Pair:
        """Equilibrium of the softest tissue, and from there that of the tissue itself."""
        first = equilibrium(softest, guess, level, self.newton, last)
        if not first.converged:
            return Pair(guess, guess, first.iterations, f"{self._at(0.0)}: {first.reason}")
        spent, unknowns = first.iterations, first.unknowns
        gamma, halvings, hardened = 0.0, 0, LastTangent(self.newton)
        while gamma < 1.0:
            step = self.hardening / 2.0**halvings
            following = 1.0 if gamma + step > 1.0 - 0.5 * self.smallest_hardening else gamma + step
            harder = problem.softened(self._modulus(following))
            assert harder is not None
            found = equilibrium(harder, unknowns, level, self.newton, hardened)
            spent += found.iterations
            if found.converged:
                gamma, unknowns = following, found.unknowns
                halvings = max(halvings - 1, 0) if found.iterations <= self.easy else halvings
            elif step / 2.0 < self.smallest_hardening:
                return Pair(guess, guess, spent, f"{self._at(following)}: {found.reason}")
            else:
                halvings += 1
        own = equilibrium(problem, unknowns, level, self.newton, hardened)
        complaint = "" if own.converged else f"at the tissue's own bulk modulus: {own.reason}"
        return Pair(first.unknowns, own.unknowns, spent + own.iterations, complaint)

    def _modulus(self, gamma: float) -> float:
        return 10.0 ** (self.first_exponent + gamma * (self.last_exponent - self.first_exponent))

    def _at(self, gamma: float) -> str:
        return f"at gamma = {gamma:.3g}, a bulk modulus of {self._modulus(gamma):.3g} Pa"

    def _advice(self, points: list[PathPoint], level: float, complaint: str) -> str:
        last = points[-1]
        return (
            f"two_parameter continuation stopped at level {last.level:.6g} after {len(points)} points: no equilibrium "
            f"was found at level {level:.6g}, with steps down to {self.smallest:g} ({complaint}). The last state has "
            f"{last.negative_eigenvalues} negative eigenvalues. Try a smaller 'first_exponent', a smaller "
            "'smallest_hardening' or 'smallest', or a smaller full load; the strategy 'arclength' passes limit points."
        )


@hookimpl
def myobridge_continuations() -> dict[str, type[ContinuationStrategy]]:
    return {"two_parameter": TwoParameter}
