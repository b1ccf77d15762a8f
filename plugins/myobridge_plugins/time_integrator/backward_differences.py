"""The stage of backward differences over two steps, which BDF2 and Bathe's method share."""

from __future__ import annotations

from myobridge.interfaces import Array
from myobridge.solvers import Formula

__all__ = ["backward_differences"]


def backward_differences(velocity: Array, moved: Array, gained: Array, ratio: float, time: float, dt: float) -> Formula:
    r"""Stage at the end of a step `dt` from `time`, after a step that `moved` displacements and `gained` velocities.

    .. math:: v_1 = \frac{\alpha d - \beta d_0}{\Delta t}, \qquad
              a_1 = \frac{\alpha (v_1 - v_0) - \beta (v_0 - v_{-1})}{\Delta t}, \qquad
              \alpha = \frac{1 + 2 \omega}{1 + \omega}, \quad \beta = \frac{\omega^2}{1 + \omega}

    Parameters
    ----------
    velocity : ndarray
        :math:`v_0` [m/s].
    moved, gained : ndarray
        Changes of displacement :math:`d_0` [m] and velocity :math:`v_0 - v_{-1}` [m/s] over the step before.
    ratio : float
        omega, this step over the one before; 0 makes it backward Euler.
    """
    a, b = (1.0 + 2.0 * ratio) / (1.0 + ratio), ratio * ratio / (1.0 + ratio)
    drift = (-b / dt) * moved
    return Formula(
        time,
        dt,
        rate=a / dt,
        velocity=drift,
        curvature=(a / dt) ** 2,
        acceleration=(a / dt) * (drift - velocity) - (b / dt) * gained,
    )
