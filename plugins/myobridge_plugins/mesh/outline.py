r"""Outline of a muscle with tendons: how thick it is at each place along its length.

.. math:: w(s) = w_e + (w_b - w_e)\,\sin^2\!\Big(\pi\,\frac{s - \tau}{1 - 2\tau}\Big), \quad \tau \le s \le 1 - \tau;
          \qquad w = w_e \text{ beyond}

with w_b at the belly, w_e at the ends, and the share tau of the length that each tendon takes. The slope is
continuous: no corner where the tendon begins, so no singular stress there.
"""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np

from myobridge.interfaces import Array

__all__ = ["Outline"]


@attrs.frozen
class Outline:
    """Thickness `belly` in the middle, `end` at the ends [m]; `tendon` is the share of each tendon, in [0, 0.5)."""

    belly: float
    end: float
    tendon: float

    def at(self, s: Array) -> Array:
        """Thickness [m] at the share s of the length."""
        inside = np.clip((s - self.tendon) / (1.0 - 2.0 * self.tendon), 0.0, 1.0)
        return self.end + (self.belly - self.end) * np.sin(np.pi * inside) ** 2

    @property
    def slenderness(self) -> float:
        r"""Integral of 1/w over the share of the length [1/m]; the muscle's part is (1 - 2 tau) / sqrt(w_e w_b)."""
        return 2.0 * self.tendon / self.end + (1.0 - 2.0 * self.tendon) / math.sqrt(self.end * self.belly)

    def levels(self, cells: int, refinements: int = 0) -> Array:
        """Ends of the cells along the length, in shares of it: each as long as the body is thick there, up to a factor.

        The tendons end between cells. A refinement halves every cell, and keeps the old ends.
        """
        tendon = max(round(cells * self.tendon / self.end / self.slenderness), 1) if self.tendon > 0.0 else 0
        muscle = 2**refinements * max(cells - 2 * tendon, 2)
        outer = np.linspace(0.0, self.tendon, 2**refinements * tendon, endpoint=False)
        # tan(pi s) of the place s in the muscle grows in proportion to that of the place among the cells.
        turns = np.arange(muscle) / muscle - 0.5
        inner = np.arctan(np.tan(np.pi * turns[1:]) * math.sqrt(self.belly / self.end)) / np.pi + 0.5
        inner = self.tendon + (1.0 - 2.0 * self.tendon) * np.concatenate([[0.0], inner])
        return np.concatenate([outer, inner, [1.0 - self.tendon], 1.0 - outer[::-1]])

    def parts(self, s: Array) -> dict[str, Any]:
        """Cells of each part, from the share s of the length at their middle; without tendons the muscle alone."""
        left, right = s < self.tendon, s > 1.0 - self.tendon
        found: dict[str, Any] = {"muscle": np.flatnonzero(~left & ~right)}
        if self.tendon > 0.0:
            found |= {
                "tendon_left": np.flatnonzero(left),
                "tendon_right": np.flatnonzero(right),
                "tendon": np.flatnonzero(left | right),
            }
        return found
