r"""Upwind discretisation: a fixed grid, the method of the thesis, kept as a baseline."""

from __future__ import annotations

from typing import final

import attrs
import numpy as np

from myobridge.interfaces import Array, Fluxes, Promises
from myobridge.work import count
from myobridge_plugins.cross_bridge.discretisation import Discretisation
from myobridge_plugins.cross_bridge.euler_kernels import react_fixed, transport

__all__ = ["Upwind"]


@final
@attrs.frozen
class Upwind(Discretisation):
    r"""First-order upwind transport on a fixed grid, Strang splitting, explicit Euler half steps of the reaction.

    .. math:: \rho_i \leftarrow \rho_i - \frac{\Delta t}{2 \Delta q}
        \left[v (\rho_{i+1} - \rho_{i-1}) - |v| (\rho_{i+1} - 2 \rho_i + \rho_{i-1})\right]

    State: attached fraction at the centres of the cells, shape (n_sites, n_cells).
    Promises: in [0, 1] for steps up to 2 / max(f+g), 9.569 ms for the default rates, because a reaction takes two half
    steps; a slide takes as many equal steps as Courant's condition asks for, and heads that reach an end of the window
    leave it. Its diffusion *adds* the energy :math:`\tfrac12 Q_0 (|v| \Delta q - v^2 \Delta t)` a time: no exact slide.
    Departures: the thesis has v and |v| interchanged, and loses heads through the ends of a window that is too small.
    """

    @property
    def promises(self) -> Promises:
        # Of first order in the grid. In the step the error of its diffusion only falls once a step is less than a cell.
        return Promises(exact_slide=False, order=0, largest_step=2.0 / self.rates.fastest(self.high))

    @property
    def _centres(self) -> Array:
        first, last = round(self.low * self.bins), round(self.high * self.bins)
        return (np.arange(first, last) + 0.5) / self.bins

    def initial_state(self, n_sites: int) -> Array:
        q = self._centres
        rho = self.rates.steady_state(q, 0.0) if self.filled else np.zeros_like(q)
        return np.tile(rho, (n_sites, 1))

    def react(
        self, state: Array, activation: Array, overlap: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        return self._react(state, activation, overlap, dt, 2, out)

    def _react(
        self, state: Array, activation: Array, overlap: Array, dt: float, n_steps: int, out: Array | None
    ) -> tuple[Array, Fluxes]:
        out = _copied(state, out)
        flux = np.zeros((4, state.shape[0]))
        rates = (self.rates.f1, self.rates.g1, self.rates.g2, self.rates.g3)
        first = (round(self.low * self.bins) + 0.5) / self.bins
        react_fixed(out, flux, first, self.bins, dt, n_steps, activation, overlap, self.by_rate, rates, self.scale)
        return out, Fluxes(flux[0], flux[1], flux[2], flux[3])

    def slide(self, state: Array, displacement: Array, out: Array | None) -> Array:
        out = _copied(state, out)
        count("bin_steps", state.shape[1] * np.ceil(np.abs(displacement) * self.bins).sum())
        transport(out, displacement, self.bins)
        return out

    def advance(
        self, state: Array, activation: Array, overlap: Array, displacement: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        """Euler's step of dt/2, transport, Euler's step of dt/2."""
        out, first = self._react(state, activation, overlap, 0.5 * dt, 1, out)
        before = self.moments(out)
        self.slide(out, displacement, out)
        work = self.scale * displacement * (before[:, 1] + 0.5 * displacement * before[:, 0])
        change = 0.5 * self.scale * (self.moments(out)[:, 2] - before[:, 2])
        nothing = np.zeros_like(work)
        slid = Fluxes(nothing, nothing, work, change - work)
        out, last = self._react(out, activation, overlap, 0.5 * dt, 1, out)
        return out, first.plus(slid).plus(last)

    def moments(self, state: Array) -> Array:
        q = self._centres
        return state @ np.stack([np.ones_like(q), q, q * q], axis=1) / self.bins

    def density(self, state: Array) -> tuple[Array, Array]:
        """Centres of the cells and the attached fraction there."""
        return np.tile(self._centres, (state.shape[0], 1)), state.copy()


def _copied(state: Array, out: Array | None) -> Array:
    if out is None:
        return state.copy()
    if out is not state:
        out[...] = state
    return out
