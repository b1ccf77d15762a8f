r"""Exact discretisation: cells that ride with the filament, cut where the rates jump."""

from __future__ import annotations

from typing import final

import attrs
import numpy as np

from myobridge.cache_lines import LINE, begins_a_line, rows_on_lines
from myobridge.interfaces import Array, Fluxes, Promises
from myobridge.threads import over_range
from myobridge_plugins.cross_bridge import window_layout as layout
from myobridge_plugins.cross_bridge.discretisation import Discretisation
from myobridge_plugins.cross_bridge.exact_kernels import step_sites
from myobridge_plugins.cross_bridge.window_kernels import gather_moments, slide_sites

__all__ = ["Exact"]

_HELD = np.zeros(1)
_NOTHING, _NOT_ASKED = np.zeros((0, 0)), np.zeros(0)
_CACHES = 2**25  # bytes


@final
@attrs.frozen
class Exact(Discretisation):
    r"""Cut cells in the moving frame, each piece solved exactly along its path; see `exact_kernels`.

    State: a header (start of the window, moments, occupied range, faces and means of the divided cells) and the means
    of the cells, shape (n_sites, HEADER + n_cells). Only the occupied range is read and written. A slide touches the
    header alone, unless the window moves; the cells at the new cut are divided by the next step.

    Promises: means in [0, 1] for every step, speed and activation; a slide shifts the moments exactly (heads that leave
    the window are the only loss); no limit on the step; order 2 in it on a smooth path, exact at constant speed.
    """

    @property
    def promises(self) -> Promises:
        return Promises()

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
        return self.advance(state, activation, overlap, _HELD, dt, out)

    def slide(self, state: Array, displacement: Array, out: Array | None) -> Array:
        return self._slid(state, displacement, out, _NOT_ASKED)

    def slide_and_gain(self, state: Array, displacement: Array, out: Array | None) -> tuple[Array, Array]:
        gained = np.empty(state.shape[0])
        found = self._slid(state, displacement, out, gained)
        gained *= 0.5 * self.scale
        return found, gained

    def _slid(self, state: Array, displacement: Array, out: Array | None, gained: Array) -> Array:
        found = rows_on_lines(state.shape) if out is None else out

        def part(first: int, last: int) -> None:
            slide_sites((first, last), state, found, found is not state, gained, displacement, self.low, self.bins)

        over_range(state.shape[0], part)
        return found

    def advance(
        self, state: Array, activation: Array, overlap: Array, displacement: Array, dt: float, out: Array | None
    ) -> tuple[Array, Fluxes]:
        if out is None:
            out = rows_on_lines(state.shape)
        if dt <= 0.0:
            everywhere = np.broadcast_to(displacement, state.shape[:1]).astype(float)
            return self.slide(state, everywhere, out), Fluxes.zero(state.shape[0])
        n, rates = state.shape[0], self.rates
        flux = np.empty((4, n))
        # What is larger than the caches is not found there by the next call either.
        past = out is not state and state.nbytes > _CACHES and begins_a_line(out) and state.shape[1] % LINE == 0

        def part(first: int, last: int) -> None:
            images = _NOTHING
            if out is not state:
                images = rows_on_lines((2, state.shape[1]))
                images[...] = 0.0
            step_sites(
                (first, last),
                state,
                out,
                images,
                past,
                flux,
                displacement,
                dt,
                activation,
                overlap,
                self.by_rate,
                (rates.f1, rates.g1, rates.g2, rates.g3),
                self.low,
                self.bins,
                self.scale,
            )

        over_range(n, part)
        return out, Fluxes(flux[0], flux[1], flux[2], flux[3])

    def moments(self, state: Array) -> Array:
        found = np.empty((state.shape[0], 3))

        def part(first: int, last: int) -> None:
            gather_moments((first, last), state, found)

        over_range(state.shape[0], part)
        return found

    def density(self, state: Array) -> tuple[Array, Array]:
        """Centres of the cells and their means."""
        start = state[:, layout.START, None]
        return start + (np.arange(self._n_cells) + 0.5) / self.bins, state[:, layout.HEADER :].copy()
