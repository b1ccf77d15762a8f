"""Stimulation: the activation of all sites over time, from a signal and, where a scene calls for it, calcium."""

from __future__ import annotations

from functools import cached_property
from typing import final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.instant import just_before
from myobridge.interfaces import ActivationKinetics, Array, MacroSolid, Signal

__all__ = ["Stimulation", "located"]


def located(signal: Signal | None, solid: MacroSolid) -> Signal | None:
    """Activation of the sites of `solid`: the signal once it knows where they are.

    Raises
    ------
    ParameterError
        With the key as ``activation. ...``, if the signal does not fit the dimension of the solid.
    """
    if signal is None:
        return None
    try:
        return signal.located(solid.site_positions())
    except ParameterError as error:
        raise ParameterError(f"activation.{error.key}", error.problem) from None


@final
@attrs.frozen(eq=False)
class Stimulation:
    """Activation r [-], shape (n_sites,), of `n_sites` sites; 1 for ever without a signal.

    The state of the kinetics, shape (n_sites,), is passed in and out; it is empty without kinetics.
    """

    n_sites: int
    signal: Signal | None = None
    kinetics: ActivationKinetics | None = None

    @cached_property
    def _full(self) -> Array:
        full = np.ones(self.n_sites)
        full.flags.writeable = False
        return full

    @property
    def constant(self) -> bool:
        """Whether it is 1 for ever."""
        return self.signal is None and self.kinetics is None

    def initial_state(self) -> Array:
        """State of the kinetics at t = 0."""
        return np.empty(0) if self.kinetics is None else self.kinetics.initial_state(self.n_sites)

    def initial(self) -> Array:
        """Activation at t = 0."""
        if self.kinetics is not None:
            return self.kinetics.initial_state(self.n_sites)
        return self._full if self.signal is None else self._all_sites(self.signal.value(0.0))

    def before(self, time: float) -> Array:
        """Activation at a `time` just before the start [s]; that of the kinetics is its state at the start."""
        if self.kinetics is not None or self.signal is None:
            return self.initial()
        return self._all_sites(self.signal.value(time))

    def mean(self, state: Array, start: float, end: float) -> tuple[Array, Array]:
        """Mean activation from `start` to `end` [s], and the state there."""
        if self.constant:
            return self._full, state
        mean = self._full if self.signal is None else self._all_sites(self.signal.mean(start, end))
        if self.kinetics is None:
            return mean, state
        state, mean = self.kinetics.advance(state, mean, end - start)
        return mean, state

    def at(self, state: Array, start: float, time: float) -> Array:
        """Activation at `time` >= `start` [s]; `state` is that of the kinetics at `start`."""
        if self.kinetics is None or time <= start:
            return self.reached(state, time, time - start)
        return self.mean(state, start, time)[1]

    def reached(self, state: Array, time: float, dt: float) -> Array:
        """Activation at the end `time` of `dt` seconds [s], before a jump there; `state` is that at `time`."""
        if self.kinetics is not None:
            return state  # the state of the kinetics is the activation itself
        if self.signal is None:
            return self._full
        return self._all_sites(self.signal.value(just_before(time, dt) if dt > 0.0 else time))

    def _all_sites(self, value: Array) -> Array:
        return np.array(np.broadcast_to(value, (self.n_sites,)), dtype=float)
