"""Clamp: the stretch is prescribed."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, MacroSolid, Motion, Signal
from myobridge.parameters import integer, number, part


@final
@attrs.frozen(eq=False)
class Clamp(MacroSolid):
    r"""Fibres whose stretch is given (thesis, Model 3.1): the length clamp of the laboratory.

    .. math:: \lambda_i(t) = \text{path}_i(t)

    No unknowns: the population follows the path. The path has one value for all sites or one for each, so that
    a sweep over speeds or lengths is one run.

    Parameters
    ----------
    path : Signal
        Stretch [-] as a function of time.
    sites : int
        Number of independent fibres.
    length, area : float
        Rest length [m] and cross-section [m^2] of each; its volume scales energies, its area the reaction.
    """

    summary: ClassVar[str] = "stretch prescribed as a function of time or from a file (length clamp)"
    inertia: ClassVar[bool] = False

    path: Signal = part("signal", doc="stretch as a function of time")
    sites: int = integer(1, within="[1, inf)", doc="number of independent fibres")
    length: float = number(0.1, unit="m", within="(0, inf)", doc="rest length of each fibre")
    area: float = number(1e-4, unit="m^2", within="(0, inf)", doc="cross-section of each fibre")

    def __attrs_post_init__(self) -> None:
        shape = np.shape(self.path.value(0.0))
        if shape not in ((), (1,), (self.sites,)):
            raise ParameterError(
                "path", f"has {shape[0]} values; expected 1, or one for each of the {self.sites} sites"
            )
        if np.any(np.asarray(self.path.value(0.0)) <= 0.0):
            raise ParameterError("path", "starts at a stretch that is not positive; a stretch is 1 at rest")

    @property
    def n_unknowns(self) -> int:
        return 0

    @property
    def n_sites(self) -> int:
        return self.sites

    @cached_property
    def site_volumes(self) -> Array:
        return np.full(self.sites, self.area * self.length)

    def rest_motion(self) -> Motion:
        return Motion(np.empty(0), np.empty(0))

    def stretch(self, displacement: Array, time: float) -> Array:
        return np.array(np.broadcast_to(self.path.value(time), (self.sites,)), dtype=float)

    def stretch_rate(self, displacement: Array, velocity: Array, time: float) -> Array:
        return np.array(np.broadcast_to(self.path.rate(time), (self.sites,)), dtype=float)

    def reactions(self, motion: Motion, tension: Array, time: float) -> Mapping[str, Array]:
        return {"clamp": self.area * tension}

    def jumps(self) -> tuple[float, ...]:
        return self.path.jumps()


@hookimpl
def myobridge_macro_solids() -> dict[str, type[MacroSolid]]:
    return {"clamp": Clamp}
