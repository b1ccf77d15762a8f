r"""Error of a step, estimated from what the step before it promised (Milne's device).

.. math:: e = \frac{\lVert u_1 - u_p \rVert_\infty}{3 + 3/\omega}, \qquad
          u_p = u_0 + \Delta t \bigl(v_0 + \tfrac{\omega}{2} (v_0 - v_{-1})\bigr)

for methods of order 2, with :math:`\omega` the ratio of this step to the last: the predictor is that of Adams and
Bashforth, and the error constant that of the trapezoid. For order 1, and for the first step, :math:`u_p = u_0 +
\Delta t\,v_0` and half the difference.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import attrs
import numpy as np

from myobridge.interfaces import Array, Motion

__all__ = ["StepError"]


@final
@attrs.define(eq=False)
class StepError:
    """Estimate of the error of each step, and whether it is small enough.

    Attributes
    ----------
    tolerance : float
        Largest error of a displacement in one step [m].
    order : int
        Order of the integrator.
    estimate : float
        Of the last accepted step [m].
    dt : float
        Length of that step [s]; 0 before the first.
    velocity : ndarray
        At its beginning [m/s].
    """

    tolerance: float
    order: int
    estimate: float = 0.0
    dt: float = 0.0
    velocity: Array = attrs.field(factory=lambda: np.empty(0))

    def of(self, start: Motion, end: Motion, dt: float) -> float:
        """Estimated error [m] of a step from `start` to `end`."""
        if start.displacement.size == 0:
            return 0.0
        predicted, share = start.displacement + dt * start.velocity, 0.5
        if self.order > 1 and self.dt > 0.0:
            ratio = dt / self.dt
            predicted = predicted + 0.5 * dt * ratio * (start.velocity - self.velocity)
            share = 1.0 / (3.0 + 3.0 / ratio)
        return share * float(np.abs(end.displacement - predicted).max())

    def accept(self, start: Motion, dt: float, estimate: float) -> None:
        """Remember a step that was taken."""
        self.estimate, self.dt, self.velocity = estimate, dt, start.velocity

    @property
    def room(self) -> bool:
        """Whether a step twice as long would still be good, with a margin of two."""
        return self.estimate * 2.0 ** (self.order + 1) <= 0.5 * self.tolerance

    def scalars(self) -> Mapping[str, float]:
        """Numbers that a checkpoint needs; `velocity` is the array."""
        return {"estimate": self.estimate, "dt": self.dt}
