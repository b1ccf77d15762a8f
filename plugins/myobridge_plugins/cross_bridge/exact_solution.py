r"""Exact solution of the two-state equation along a piecewise linear path, for tests and studies.

Along a label (a head's place on its filament) the equation is an ordinary one with piecewise linear rates. At constant
speed :math:`\int p\,dt` is known in every region, so the attached fraction at a label is exact to round-off:

.. math:: \rho \leftarrow \rho_\infty + (\rho - \rho_\infty)\,e^{-\int (r f + g)\,dt}

As a function of the label it is smooth between the labels that stood at q=0 or q=1 when the speed changed; the moments
are Gauss sums between these. There are neither cells nor a window.
"""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array
from myobridge_plugins.cross_bridge.rates import Rates

__all__ = ["carried", "exact_moments"]


def carried(rates: Rates, rho: Array, q: Array, displacement: float, dt: float, activation: float = 1.0) -> Array:
    """Attached fraction of heads that stood at `q` and are carried by `displacement` in `dt` seconds at constant speed.

    Parameters
    ----------
    rho, q : ndarray, same shape
        Attached fraction [-] and displacement [reach] before.
    displacement : float
        Path [reach]; 0 holds the filament.
    dt : float
        Time [s], positive.
    """
    c, F = activation * rates.f1 + rates.g1, rates.duty(activation)
    G = rates.g1 + rates.g3
    if abs(displacement) < 1e-150:  # shorter paths would overflow below, and are none
        low, high = (q < 0.0) * dt, np.where(q >= 1.0, G * q - rates.g3, 0.0) * dt
        within = F + (rho - F) * np.exp(-c * q.clip(0.0, 1.0) * dt)
        return np.where((q >= 0.0) & (q < 1.0), within, rho * np.exp(-rates.g2 * low - high))
    v = displacement / dt
    # Fractions of the path at which it meets q=0 and q=1; no difference of near numbers, however short the path.
    at0, at1 = np.clip(-q / displacement, 0.0, 1.0), np.clip((1.0 - q) / displacement, 0.0, 1.0)
    low = dt * (at0 if v > 0.0 else 1.0 - at0)
    in_mid, m = dt * np.abs(at1 - at0), np.clip(q, 0.0, 1.0)
    mid = in_mid * (m + 0.5 * v * in_mid)
    in_high, h = dt * (1.0 - at1 if v > 0.0 else at1), np.maximum(q, 1.0)
    high = in_high * (G * (h + 0.5 * v * in_high) - rates.g3)
    before, after = (rates.g2 * low, high) if displacement > 0.0 else (high, rates.g2 * low)
    return (F + (rho * np.exp(-before) - F) * np.exp(-c * mid)) * np.exp(-after)


def exact_moments(
    rates: Rates,
    times: Array,
    positions: Array,
    filled: bool = True,
    activation: Array | float = 1.0,
    spacing: float = 0.05,
    points: int = 6,
) -> Array:
    """Moments Q0, Q1, Q2 at `times` along the path through `positions`, shape (n_times, 3).

    Parameters
    ----------
    times, positions : ndarray, shape (n_times,)
        Corners of the path [s], [reach]; the speed is constant between them.
    filled : bool
        Start in the isometric steady state at full activation, or empty.
    activation : ndarray, shape (n_times - 1,), or float
        Activation between the corners [-].
    spacing, points : float, int
        Longest interval of the quadrature [reach] and Gauss points in each.
    """
    activation = np.broadcast_to(np.asarray(activation, dtype=float), times.size - 1)
    corners = np.concatenate([-positions, 1.0 - positions])
    filler = np.arange(corners.min(), corners.max(), spacing)
    faces = np.unique(np.concatenate([corners, filler]))
    faces = faces[np.concatenate([[True], np.diff(faces) > 1e-13])]
    nodes, weights = np.polynomial.legendre.leggauss(points)
    width = np.diff(faces)
    labels = (faces[:-1, None] + 0.5 * width[:, None] * (1.0 + nodes)).ravel()
    mass = (0.5 * width[:, None] * weights).ravel()
    q = labels + positions[0]
    rho = np.where((q > 0.0) & (q < 1.0), rates.duty(), 0.0) if filled else np.zeros_like(q)
    moments = np.empty((times.size, 3))
    for k, position in enumerate(positions):
        if k > 0:
            path = position - positions[k - 1]
            rho = carried(rates, rho, labels + positions[k - 1], path, times[k] - times[k - 1], activation[k - 1])
        q = labels + position
        moments[k] = [mass @ rho, mass @ (rho * q), mass @ (rho * q * q)]
    return moments
