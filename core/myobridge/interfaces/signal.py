"""Signal: a function of time, for activation, loads and prescribed stretch alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from myobridge.interfaces.active_law import Array

__all__ = ["ActivationKinetics", "Signal"]


class Signal(ABC):
    """Abstract function of time; its unit is that of what it drives (activation [-], force [N], stretch [-]).

    A signal has one value for all sites, shape (), or one for each, shape (n_sites,).
    """

    summary: ClassVar[str] = ""

    @abstractmethod
    def value(self, time: float) -> Array:
        """Value at `time` [s]; at a jump, the value after it."""

    @abstractmethod
    def mean(self, start: float, end: float) -> Array:
        """Mean over ``start <= t <= end``, exact; the value where both agree."""

    def rate(self, time: float) -> Array:
        """Derivative after `time`, the signal's unit per second; by default a one-sided difference."""
        step = 1e-7
        return (self.value(time + step) - self.value(time)) / step

    def jumps(self) -> tuple[float, ...]:
        """Times at which value or slope jumps; a step ends there."""
        return ()

    def located(self, positions: Array) -> Signal:
        """The signal at reference `positions` (n_sites, dimension) [m]; this very one where space does not matter.

        What drives the sites of a solid is located once, before anything else is asked of it.

        Raises
        ------
        ParameterError
            If the signal asks for an axis that the positions do not have.
        """
        return self


class ActivationKinetics(ABC):
    """First stage between stimulation and activation, such as the release and uptake of calcium.

    Its state, shape (n_sites,), is passed in and out and stands in every checkpoint.
    """

    summary: ClassVar[str] = ""
    inherent_effects: ClassVar[frozenset[str]] = frozenset()

    @abstractmethod
    def initial_state(self, n_sites: int) -> Array:
        """Activation at the start [-], shape (n_sites,)."""

    @abstractmethod
    def advance(self, state: Array, stimulation: Array, dt: float) -> tuple[Array, Array]:
        """State after `dt` seconds of constant `stimulation` [-], and the mean activation, both (n_sites,)."""
