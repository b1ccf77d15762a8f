"""Compiled kernels of the explicit schemes: Euler's step of the reaction, upwind transport on a fixed grid."""

from __future__ import annotations

import math

import numba as nb

from myobridge_plugins.cross_bridge.window_kernels import copy_row
from myobridge_plugins.cross_bridge.window_layout import FAST, FIRST, HEADER, LAST, Q0, Q1, Q2, START, cut_at

__all__ = ["react_fixed", "react_riding", "transport"]


@nb.njit(**FAST)
def _euler(cells, q, dq, dt, f, a, g1, g2, g3):
    r"""One explicit Euler step of cells centred at q, q + dq, ...: energies attached and detached, unscaled.

    .. math:: \rho \leftarrow \rho + \Delta t\,(f (a-\rho)^+ - g \rho)
    """
    attached = detached = 0.0
    for i in range(cells.size):
        m = q + i * dq
        rho = cells[i]
        gain = f * m * max(a - rho, 0.0) * dt if 0.0 < m < 1.0 else 0.0
        loss = (g2 if m < 0.0 else g1 * m + g3 * max(m - 1.0, 0.0)) * rho * dt
        cells[i] = rho + gain - loss
        attached += gain * m * m
        detached += loss * m * m
    return attached, detached


@nb.njit(**FAST)
def react_fixed(out, flux, q, bins, dt, n_steps, activation, overlap, by_rate, rates, scale):
    """`n_steps` Euler steps, `dt` in all, of cells on a fixed grid that begins with its centre at `q`; in place."""
    f1, g1, g2, g3 = rates
    for site in range(out.shape[0]):
        o = overlap[site] if overlap.size > 1 else overlap[0]
        f = activation[site] * f1 if by_rate else f1
        a = o if by_rate else activation[site] * o
        for _ in range(n_steps):
            attached, detached = _euler(out[site], q, 1.0 / bins, dt / n_steps, f, a, g1, g2, g3)
            flux[0, site] += 0.5 * scale / bins * attached
            flux[1, site] += 0.5 * scale / bins * detached


@nb.njit(**FAST)
def react_riding(state, out, copy, flux, bins, dt, activation, overlap, by_rate, rates, scale):
    """One Euler step of cells that ride with the filament: `state` to `out`."""
    f1, g1, g2, g3 = rates
    dq = 1.0 / bins
    for site in range(out.shape[0]):
        row = out[site]
        if copy:
            copy_row(state[site], row)
        o = overlap[site] if overlap.size > 1 else overlap[0]
        f = activation[site] * f1 if by_rate else f1
        a = o if by_rate else activation[site] * o
        cell = math.floor(cut_at(row[START], bins))
        first, last = min(int(row[FIRST]), cell), max(int(row[LAST]), cell + bins + 1)
        q = row[START] + (first + 0.5) * dq
        cells = row[HEADER + first : HEADER + last]
        attached, detached = _euler(cells, q, dq, dt, f, a, g1, g2, g3)
        s0 = s1 = s2 = 0.0
        for i in range(cells.size):
            m = q + i * dq
            s0 += cells[i]
            s1 += cells[i] * m
            s2 += cells[i] * m * m
        row[Q0], row[Q1], row[Q2] = dq * s0, dq * s1, dq * s2
        row[FIRST], row[LAST] = first, last
        flux[0, site] = 0.5 * scale * dq * attached
        flux[1, site] = 0.5 * scale * dq * detached


@nb.njit(**FAST)
def transport(out, displacement, bins):
    r"""First-order upwind transport in as many equal steps as Courant's condition asks for; in place.

    .. math:: \rho_i \leftarrow \rho_i - |\nu| (\rho_i - \rho_{i \mp 1}), \quad |\nu| = |x| / (n\,\Delta q) \le 1
    """
    n = out.shape[1]
    for site in range(out.shape[0]):
        cells = out[site]
        x = displacement[site] * bins
        steps = math.ceil(abs(x))
        nu = abs(x) / steps if steps > 0 else 0.0
        for _ in range(min(steps, 2 * n + 2)):
            if x > 0.0:
                for i in range(n - 1, 0, -1):
                    cells[i] -= nu * (cells[i] - cells[i - 1])
                cells[0] -= nu * cells[0]
            else:
                for i in range(n - 1):
                    cells[i] -= nu * (cells[i] - cells[i + 1])
                cells[n - 1] -= nu * cells[n - 1]
        for i in range(n):  # denormal numbers are slow, and products of them no longer ordered
            cells[i] = cells[i] if abs(cells[i]) > 1e-30 else 0.0
