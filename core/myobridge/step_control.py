"""Step control: which time comes next, half the step after a failure, regrowth after successes."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence

import attrs

from myobridge.errors import StepFailed

__all__ = ["StepControl"]

# Two times closer than this fraction of a step are the same time.
_SAME = 1e-6


@attrs.define
class StepControl:
    """Steps on a grid of multiples of `dt`, with stops in between.

    The next time depends on the present one, the step and the stops alone, never on where a run was interrupted, so
    that a resumed run takes the very same steps.

    Attributes
    ----------
    dt : float
        Nominal step [s].
    halvings : int
        How often the step is halved at present.
    successes : int
        Steps since the last change of the step.
    """

    dt: float
    halvings: int = 0
    successes: int = 0

    MAX_HALVINGS = 12
    REGROW_AFTER = 4

    def next(self, time: float, stops: Sequence[float], end: float) -> tuple[float, float]:
        """Next time and the step to it [s]; `stops` are sorted times (jumps) that no step may cross."""
        dt = self.dt / 2**self.halvings
        position = time / dt
        cell = math.floor(position + _SAME)
        target = (cell + 1) * dt
        on_grid = abs(position - cell) < _SAME
        index = bisect_right(stops, time + _SAME * dt)
        first = min(stops[index], end) if index < len(stops) else end
        if first < target - _SAME * dt:
            return first, first - time
        # The step itself, not the difference of two rounded times: all full steps are equal to the last bit.
        return target, dt if on_grid else target - time

    def failed(self, time: float, reason: str, tried: float) -> None:
        """Halve the step until it is shorter than the one `tried` [s]: a stop may have cut that one short.

        Raises
        ------
        StepFailed
            After 12 halvings.
        """
        if self.halvings >= self.MAX_HALVINGS:
            raise StepFailed(
                f"the step at t = {time:.6g} s failed even after {self.MAX_HALVINGS} halvings "
                f"(dt = {self.dt / 2**self.halvings:.3g} s): {reason}. Try a smaller step, a gentler load, "
                "or another integrator or coupling; the result so far is kept."
            )
        self.halvings += 1
        while self.halvings < self.MAX_HALVINGS and self.dt / 2**self.halvings > 0.75 * tried:
            self.halvings += 1
        self.successes = 0

    def succeeded(self, time: float, *, room: bool = True) -> None:
        """Double a halved step after a few successes, where the coarser grid has a point and there is `room` for it."""
        self.successes += 1
        if room and self.halvings and self.successes >= self.REGROW_AFTER:
            coarse = time / (self.dt / 2 ** (self.halvings - 1))
            if abs(coarse - round(coarse)) < _SAME:
                self.halvings -= 1
                self.successes = 0
