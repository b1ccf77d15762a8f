r"""Equilibria of a solid and its fibres as tension, load or both grow: what a continuation strategy sees.

.. math:: F(x, \ell) = \begin{pmatrix} f_{int}(u, p) + s_T\,f_{act}(u) - s_F\,f_{ext}(u) \\ \sigma\,c(u, p)
          \end{pmatrix} = 0, \qquad x = \begin{pmatrix} u \\ p / \sigma \end{pmatrix}

with the scales of tension and load :math:`s_T, s_F`, each 1 or :math:`s = \ell\,s_{end}`, and the unit of the
multiplier :math:`\sigma` (`MacroSolid.multiplier_scale`), which balances the tangent

.. math:: \begin{pmatrix} K & \sigma B^T \\ \sigma B & -\sigma^2 C \end{pmatrix}, \qquad
          K = \partial f / \partial u - (s_F - 1)\,\partial f_{ext} / \partial u .
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, final

import attrs
import numpy as np

from myobridge.interfaces import (
    ActiveLaw,
    Array,
    Balance,
    ContinuationProblem,
    CrossBridgeModel,
    Factorisation,
    LinearSystem,
    MacroSolid,
    Matrix,
    Motion,
)

if TYPE_CHECKING:
    pass

__all__ = ["Equilibria", "SteadyTension"]


@final
@attrs.frozen(eq=False)
class SteadyTension:
    """Isometric steady tension of a cross-bridge model at all sites.

    Attributes
    ----------
    model : CrossBridgeModel
    activation : ndarray, shape (n_sites,)
        Activation r [-].
    unit : ndarray, shape (n_sites,)
        Nominal tension that the model counts in, `p_max` times the sarcomere density [Pa].
    """

    model: CrossBridgeModel
    activation: Array
    unit: Array

    def law(self, stretch: Array, scale: float) -> ActiveLaw:
        """Law [Pa] that holds at `stretch`, times `scale`."""
        return self.model.steady_law(self.activation, stretch).scaled(scale * self.unit)


@final
class Equilibria(ContinuationProblem):
    """Equilibria of a solid; loads and supports are taken at one time.

    Parameters
    ----------
    solid : MacroSolid
    tension : SteadyTension, optional
        Without, the solid is passive.
    of : {"tension", "load", "tension_and_load"}
        What the scale multiplies.
    to : float
        Scale at level 1.
    time : float
        When loads and supports are looked at [s].
    """

    def __init__(
        self, solid: MacroSolid, tension: SteadyTension | None, *, of: str, to: float = 1.0, time: float = 0.0
    ) -> None:
        self.solid = solid
        self.tension = tension
        self.of = of
        self.to = to
        self.time = time
        rest = solid.rest_motion()
        self.n_displacements = rest.displacement.size
        self.n_constraints = rest.multiplier.size
        self._unit = solid.multiplier_scale if self.n_constraints else 1.0
        self._still = np.zeros(self.n_displacements)
        self._rest = rest
        self._latest: tuple[Array, float, Balance] | None = None
        self._softer: dict[float, Equilibria | None] = {}

    # ------------------------------------------------------------------ states

    @property
    def start(self) -> Array:
        """Unknowns of the solid at rest."""
        return np.concatenate([self._rest.displacement, self._rest.multiplier / self._unit])

    def motion(self, unknowns: Array) -> Motion:
        """Motion of the solid, without velocity."""
        n = self.n_displacements
        return Motion(unknowns[:n], self._still, self._unit * unknowns[n:])

    def scales(self, level: float) -> tuple[float, float]:
        """Scales of tension and load at a level."""
        scale = self.to * level
        return (1.0 if self.of == "load" else scale), (1.0 if self.of == "tension" else scale)

    def law(self, unknowns: Array, level: float) -> ActiveLaw | None:
        """Active law [Pa] at a state; None without cross-bridges."""
        if self.tension is None:
            return None
        stretch = self.solid.stretch(unknowns[: self.n_displacements], self.time)
        return self.tension.law(stretch, self.scales(level)[0])

    # ------------------------------------------------------------------ what a strategy asks

    def residual(self, unknowns: Array, level: float) -> Array:
        balance = self._balance(unknowns, level)
        force, load = balance.force, self.scales(level)[1]
        if load != 1.0:
            force = force + (1.0 - load) * self._external(unknowns)
        if balance.constraint is None:
            return force
        return np.concatenate([force, self._unit * balance.constraint])

    def system(self, unknowns: Array, level: float) -> LinearSystem:
        """Tangent, field by field."""
        balance = self._balance(unknowns, level, tangent=True)
        stiffness, load = balance.stiffness, self.scales(level)[1]
        assert stiffness is not None
        if load != 1.0:
            from_load = self.solid.external_stiffness(unknowns[: self.n_displacements], self.time)
            if from_load is not None:
                stiffness = stiffness - (1.0 - load) * from_load
        if balance.constraint_gradient is None:
            return LinearSystem(
                stiffness, rigid_motions=self.solid.rigid_motions(), symmetric=balance.symmetric or load == 0.0
            )
        gradient = self._unit * balance.constraint_gradient
        compliance = balance.constraint_compliance
        return LinearSystem(
            stiffness,
            gradient,
            gradient,
            None if compliance is None else self._unit**2 * compliance,
            self.solid.rigid_motions(),
            balance.symmetric or load == 0.0,
        )

    def tangent(self, unknowns: Array, level: float) -> Matrix | LinearSystem:
        system = self.system(unknowns, level)
        return system.stiffness if self.n_constraints == 0 and isinstance(system.stiffness, np.ndarray) else system

    def level_derivative(self, unknowns: Array, level: float) -> Array:
        found = np.zeros(unknowns.size)
        n = self.n_displacements
        if self.of != "load" and self.tension is not None:
            motion = self.motion(unknowns)
            law = self.tension.law(self.solid.stretch(motion.displacement, self.time), 1.0)
            # A solid applies the tension linearly: the difference is the active force, whatever the scale.
            active = self.solid.balance(motion, law, self.time, rate=False).force
            found[:n] += self.to * (active - self.solid.balance(motion, None, self.time, rate=False).force)
        if self.of != "tension":
            found[:n] -= self.to * self._external(unknowns)
        return found

    def negative_eigenvalues(self, unknowns: Array, level: float, factorisation: Factorisation | None = None) -> int:
        from myobridge.solvers import InertiaUnknown, SingularMatrix, stability

        try:
            return stability(self.system(unknowns, level), factorisation)
        except (InertiaUnknown, SingularMatrix):
            return -1

    def admissible(self, unknowns: Array) -> bool:
        return bool(np.all(np.isfinite(unknowns))) and self.solid.admissible(
            unknowns[: self.n_displacements], self.time
        )

    def magnitude(self, unknowns: Array, level: float) -> float:
        balance = self._balance(unknowns, level)
        return math.hypot(balance.magnitude, self._unit * balance.constraint_magnitude)

    def weights(self) -> Array:
        return np.concatenate([np.ones(self.n_displacements), np.zeros(self.n_constraints)])

    def softened(self, bulk_modulus: float) -> Equilibria | None:
        if bulk_modulus not in self._softer:  # at every level the same few are asked for
            solid = self.solid.softened(bulk_modulus)
            self._softer[bulk_modulus] = (
                None if solid is None else Equilibria(solid, self.tension, of=self.of, to=self.to, time=self.time)
            )
        return self._softer[bulk_modulus]

    # ------------------------------------------------------------------ inside

    def _external(self, unknowns: Array) -> Array:
        return self.solid.external_force(unknowns[: self.n_displacements], self.time)

    def _balance(self, unknowns: Array, level: float, *, tangent: bool = False) -> Balance:
        """Balance under tension at its scale and full load; that of the last state is kept."""
        if self._latest is not None:
            there, at, balance = self._latest
            if at == level and (balance.stiffness is not None or not tangent) and np.array_equal(there, unknowns):
                return balance
        law = self.law(unknowns, level)
        balance = self.solid.balance(self.motion(unknowns), law, self.time, rate=False, tangent=tangent)
        self._latest = (unknowns.copy(), level, balance)
        return balance
