r"""Balance of a body over a whole step, a discrete gradient of all its energies, and the works of the step.

.. math:: f = \int F_m S : \nabla N + f_{bedding} - f_{external}, \qquad
          f \cdot (u_1 - u_0) = \Delta W + \Delta \Psi + p \cdot \Delta c + W_{viscous} - W_{external}

The stress is that of `step_point_kernels`. Loads act where the body is half-way, at half-time. Bedding is linear, so
that there its work is the change of its energy. With the energy of volume :math:`\tfrac{\kappa}{2} \lVert \Pi(J-1)
\rVert^2` the multiplier that acts adds

.. math:: W_{numerical} = \bigl(\tfrac12 (\pi_0 + \pi_1) - p\bigr) \cdot (c_1 - c_0), \qquad
          \pi = \kappa M_p^{-1} c, \quad c = \int \psi (J - 1)

which is :math:`-\lVert p_1 - p_0 \rVert^2 / 2 \kappa` for that of the end, and nothing for the mean. Where the volume
is kept no energy is in it, and :math:`-p \cdot (c_1 - c_0)` is what the solver's tolerance leaves.
"""

from __future__ import annotations

import math
from typing import final

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, Balance, LawValue, Motion, Works
from myobridge_plugins.macro_solid.finite_element.body import Body
from myobridge_plugins.macro_solid.finite_element.forces import at_points, cancelled, volume_change, with_constraint
from myobridge_plugins.macro_solid.finite_element.step_assembly import StepSums, step_sums

__all__ = ["Step"]


@final
class Step:
    """A step of a body between two motions.

    Parameters
    ----------
    body : Body
    start, end : Motion
    law : ActiveLaw or None
    times : (float, float)
        Of the two motions [s]: supports stand where they are then.
    multiplier : ndarray or None
        Acts in the force [Pa]; that of `end` where it is None.
    bulk_modulus, viscosity : float or None
        [Pa] and [Pa s].
    """

    def __init__(
        self,
        body: Body,
        start: Motion,
        end: Motion,
        law: ActiveLaw | None,
        times: tuple[float, float],
        multiplier: Array | None,
        bulk_modulus: float | None,
        viscosity: float | None,
    ) -> None:
        self.body, self.multiplier = body, end.multiplier
        self.law = law if body.n_sites else None
        self.dt = times[1] - times[0]
        self.acting = end.multiplier if multiplier is None else multiplier
        self.bulk_modulus = bulk_modulus
        self.drag = (viscosity or 0.0) / self.dt
        self.first = body.displacement(start.displacement, times[0])
        self.last = body.displacement(end.displacement, times[1])
        self.change = self.last - self.first
        self.middle = self.first + 0.5 * self.change
        self.half_time = 0.5 * (times[0] + times[1])

    def balance(self, *, tangent: bool) -> Balance:
        """Balance of the free numbers (see `MacroSolid.step_balance`)."""
        body, free = self.body, self.body.free
        answer, _ = self._answer()
        sums = self._sums(answer, tangent=tangent)
        external = body.loading.external(self.middle, self.half_time)
        largest = body.modulus + sums.magnitude + float(np.abs(self.acting).max(initial=0.0))
        if answer is not None:
            largest += cancelled(2.0 * answer.stiffness)  # by the stretch at the end: half of the law's own
        found = Balance(
            (sums.force + body.loading.bedding(self.middle, self.half_time) - external)[free],
            magnitude=largest * body.section + float(np.linalg.norm(external)),
            symmetric=False,
        )
        pattern = body.assembly.pattern
        found = with_constraint(
            body,
            found,
            sums.constraint,
            sums.constraint_gradient if tangent else None,
            self.multiplier,
            self.bulk_modulus,
        )
        if not tangent:
            return found
        matrix = pattern.stiffness.matrix(sums.stiffness)
        for stored in (True, False):
            added = body.loading.stiffness(self.middle, self.half_time, stored=stored)
            if added is not None:
                matrix = matrix + 0.5 * added[free][:, free]
        found = found._replace(stiffness=matrix)
        if self.acting.size:
            found = found._replace(acting_gradient=pattern.gradient.matrix(sums.acting_gradient))
        return found

    def works(self) -> Works:
        """Works of the step (see `MacroSolid.step_works`)."""
        body = self.body
        answer, moved = self._answer()
        external = float(body.loading.external(self.middle, self.half_time) @ self.change)
        taken = 0.0
        held = self.change[body.held.all_numbers]
        if self.drag or held.any():
            sums = self._sums(answer, tangent=False)
            taken = sums.taken
            pulled = sums.force + body.loading.bedding(self.middle, self.half_time)
            pulled -= body.loading.external(self.middle, self.half_time)
            external += float(pulled[body.held.all_numbers] @ held)
        active = 0.0
        if answer is not None and self.law is not None and not self.law.has_potential:
            active = -float(np.dot(body.grid.volumes[: body.n_sites] * answer.tension, moved))
        return Works(external, active, taken, self._volume_work())

    def _answer(self) -> tuple[LawValue | None, Array]:
        """Tension of the step with its derivative by the stretch at the end, and the change of the stretch."""
        if self.law is None:
            return None, np.empty(0)
        assembly, n = self.body.assembly, self.body.n_sites
        before, after = (assembly.kinematics(full).stretch[:n] for full in (self.first, self.last))
        moved = after - before
        found = self.law.evaluate(before + 0.5 * moved, moved / self.dt)
        slope = 0.5 * found.stiffness
        if found.rate_sensitivity is not None:
            slope = slope + found.rate_sensitivity / self.dt
        return LawValue(found.tension, slope), moved

    def _sums(self, answer: LawValue | None, *, tangent: bool) -> StepSums:
        body = self.body
        tension = None if answer is None else at_points(body, answer.tension)
        slope = None if answer is None else at_points(body, answer.stiffness)
        pressure = body.pressure(self.acting)
        given = (self.first, self.change, pressure, tension, slope, self.drag, body.modulus)
        return step_sums(body.assembly, *given, tangent=tangent)

    def _volume_work(self) -> float:
        """Work [J] of the acting multiplier that no change of stored energy accounts for, with the opposite sign."""
        body = self.body
        if not self.acting.size:
            return 0.0
        before, after = (volume_change(body, full) for full in (self.first, self.last))
        stored = np.zeros_like(self.acting)
        if self.bulk_modulus is not None and math.isfinite(self.bulk_modulus):
            stored = 0.5 * self.bulk_modulus * body.projection(before + after)
        return float((stored - self.acting) @ (after - before))
