r"""Anderson acceleration of iterations with an approximate inverse `P` of the tangent, as a multisecant method [1]_.

.. math:: \gamma = \arg\min \|F_k - \Delta F\,\gamma\|, \qquad
          \delta_k = P\,(F_k - \Delta F\,\gamma) + \Delta X\,\gamma, \qquad x_{k+1} = x_k - \delta_k

The columns of :math:`\Delta X` and :math:`\Delta F` are the last few changes of unknowns and residuals: what they say
of the tangent is used, the approximate inverse answers for the rest.

References
----------
.. [1] H. Fang, Y. Saad, Numer. Linear Algebra Appl. 16 (2009) 197-221.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import final

import numpy as np

from myobridge.interfaces import Array
from myobridge.solvers import length_of

__all__ = ["Anderson"]

# Changes that depend on each other to this share say nothing new.
_DEPENDENT = 1e-10


@final
class Anderson:
    """Memory of the last changes.

    Parameters
    ----------
    depth : int
        How many are kept; with 0 nothing is accelerated.
    """

    def __init__(self, depth: int) -> None:
        self._changes: deque[Array] = deque(maxlen=depth)
        self._falls: deque[Array] = deque(maxlen=depth)

    def learn(self, change: Array, fall: Array) -> None:
        """Take note of a change of the unknowns and the change of the residual that it made."""
        size = length_of(fall)
        if 0.0 < size < np.inf:
            self._changes.append(change / size)
            self._falls.append(fall / size)

    def forget(self) -> None:
        """Begin anew, as after a change of the approximate inverse."""
        self._changes.clear()
        self._falls.clear()

    def correction(self, residual: Array, inverse: Callable[[Array], Array]) -> Array:
        """What to take from the unknowns."""
        if not self._falls:
            return inverse(residual)
        falls = np.column_stack(self._falls)
        shares = np.linalg.lstsq(falls, residual, rcond=_DEPENDENT)[0]
        correction = inverse(residual - falls @ shares)
        for share, change in zip(shares, self._changes, strict=True):
            correction += share * change
        return correction
