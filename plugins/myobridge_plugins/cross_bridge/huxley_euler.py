r"""Moving frame with Euler's explicit step: kept to show why it fails."""

from __future__ import annotations

from typing import final

import attrs
import numpy as np

from myobridge.interfaces import Array, Fluxes, Promises
from myobridge_plugins.cross_bridge import window_layout as layout
from myobridge_plugins.cross_bridge.discretisation import Discretisation
from myobridge_plugins.cross_bridge.euler_kernels import react_riding
from myobridge_plugins.cross_bridge.window_kernels import slide_sites

__all__ = ["MovingFrameEuler"]


@final
@attrs.frozen
class MovingFrameEuler(Discretisation):
    r"""Cells that ride with the filament; the reaction by one explicit Euler step at the place where they stand.

    .. math::
        \rho_i \leftarrow \rho_i + \Delta t\,[k f(q_i) (a - \rho_i)^+ - g(q_i) \rho_i], \qquad
        q_i \leftarrow q_i + v \Delta t

    State: as for "exact", a header and the cells, shape (n_sites, HEADER + n_cells).
    Promises: in [0, 1] for steps up to 1 / max(f+g), 4.785 ms for the default rates; beyond, compressed heads become
    negative, and beyond twice that they grow. The oscillation is this stiffness, not a shock. A slide is exact.
    Departures: none.
    """

    @property
    def promises(self) -> Promises:
        return Promises(order=1, largest_step=1.0 / self.rates.fastest(self.high + layout.BLOCK / self.bins))

    @property
    def _n_cells(self) -> int:
        return layout.cells_of(self.low, self.high, self.bins)

    def initial_state(self, n_sites: int) -> Array:
        state = layout.empty_window(n_sites, self._n_cells, self.low, self.bins)
        if self.filled:
            layout.fill_window(state, self.rates.duty(), self.bins)
        return state

    def react(
        self, state: Array, activation: Array, overlap: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        if out is None:
            out = np.empty_like(state)
        flux = np.zeros((4, state.shape[0]))
        rates = (self.rates.f1, self.rates.g1, self.rates.g2, self.rates.g3)
        react_riding(
            state, out, out is not state, flux, self.bins, dt, activation, overlap, self.by_rate, rates, self.scale
        )
        return out, Fluxes(flux[0], flux[1], flux[2], flux[3])

    def slide(self, state: Array, displacement: Array, out: Array | None) -> Array:
        if out is None:
            out = np.empty_like(state)
        slide_sites((0, state.shape[0]), state, out, out is not state, np.empty(0), displacement, self.low, self.bins)
        return out

    def advance(
        self, state: Array, activation: Array, overlap: Array, displacement: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        """Euler's step of dt, then the slide."""
        out, reacted = self.react(state, activation, overlap, dt, out)
        before = self.moments(out)
        self.slide(out, displacement, out)
        work = self.scale * displacement * (before[:, 1] + 0.5 * displacement * before[:, 0])
        change = 0.5 * self.scale * (self.moments(out)[:, 2] - before[:, 2])
        nothing = np.zeros_like(work)
        return out, reacted.plus(Fluxes(nothing, nothing, work, change - work))

    def moments(self, state: Array) -> Array:
        return state[:, layout.Q0 : layout.Q2 + 1].copy()

    def density(self, state: Array) -> tuple[Array, Array]:
        """Centres of the cells and the attached fraction there."""
        start = state[:, layout.START, None]
        return start + (np.arange(self._n_cells) + 0.5) / self.bins, state[:, layout.HEADER :].copy()
