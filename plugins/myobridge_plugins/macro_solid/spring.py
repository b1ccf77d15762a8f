"""Spring: one mass on one passive spring, with cross-bridges in parallel."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import ActiveLaw, Array, Balance, MacroSolid, Motion, Signal
from myobridge.parameters import number, part

_NO_FORCE = np.zeros(1)
_NO_FORCE.flags.writeable = False


@final
@attrs.frozen(eq=False)
class Spring(MacroSolid):
    r"""Mass on a linear spring with cross-bridges in parallel (thesis, Model 4.10).

    .. math:: m \ddot x = -k x - A \bigl(T(\lambda, \dot\lambda) + \eta \lambda^2 \dot\lambda\bigr) + F(t), \qquad
              \lambda = 1 + x / L

    One unknown, one site of volume `A L`: the power :math:`A T \dot x` is :math:`A L\,T \dot\lambda`.

    Departures: the thesis writes :math:`+p_{act}`; with that sign the energy is not conserved, and the system
    diverges as soon as the cross-bridges are stiffer than the spring.

    Parameters
    ----------
    mass, stiffness, length, area : float
        `m` [kg], `k` [N/m], rest length `L` [m], cross-section `A` [m^2].
    viscosity : float, optional
        :math:`\eta` [Pa s] of Kelvin and Voigt, effect ``viscosity``.
    load : Signal, optional
        External force `F` [N], positive when it lengthens.
    displacement, velocity : float
        `x` [m] and its rate [m/s] at the start.
    """

    summary: ClassVar[str] = "one mass on a linear spring, cross-bridges in parallel (thesis, Model 4.10)"

    mass: float = number(1.0, unit="kg", within="(0, inf)", doc="mass")
    stiffness: float = number(1.0, unit="N/m", within="[0, inf)", doc="stiffness of the passive spring")
    length: float = number(0.1, unit="m", within="(0, inf)", doc="rest length, at stretch 1")
    area: float = number(1e-4, unit="m^2", within="(0, inf)", doc="cross-section on which the tension acts")
    viscosity: float | None = number(
        None, unit="Pa s", within="[0, inf)", doc="viscosity of Kelvin and Voigt", effect="viscosity", on=10.0
    )
    load: Signal | None = part("signal", None, doc="external force [N], positive lengthens")
    displacement: float = number(0.0, unit="m", doc="displacement at the start")
    velocity: float = number(0.0, unit="m/s", doc="velocity at the start")

    def __attrs_post_init__(self) -> None:
        if self.load is not None and np.size(self.load.value(0.0)) != 1:
            raise ParameterError(
                "load", f"has {np.size(self.load.value(0.0))} values; expected 1, the force on one mass"
            )

    @property
    def n_unknowns(self) -> int:
        return 1

    @property
    def n_sites(self) -> int:
        return 1

    @cached_property
    def site_volumes(self) -> Array:
        return np.array([self.area * self.length])

    @cached_property
    def mass_matrix(self) -> Array:
        return np.array([self.mass])

    def added_mass(self, inertance: Array) -> Array:
        # A T = A I lambda'' = (A I / L) x''
        return self.area / self.length * inertance

    def rest_motion(self) -> Motion:
        return Motion(np.array([self.displacement]), np.array([self.velocity]))

    def stretch(self, displacement: Array, time: float) -> Array:
        return 1.0 + displacement / self.length

    def stretch_rate(self, displacement: Array, velocity: Array, time: float) -> Array:
        return velocity / self.length

    def balance(
        self, motion: Motion, law: ActiveLaw | None, time: float, *, rate: bool = True, tangent: bool = False
    ) -> Balance:
        passive = self.stiffness * motion.displacement
        external = self.external_force(motion.displacement, time)
        force = passive - external
        stiffness, damping = self.stiffness, None
        if law is not None:
            speed = motion.velocity if rate else _NO_FORCE
            answer = law.evaluate(1.0 + motion.displacement / self.length, speed / self.length)
            active = self.area * answer.tension
            force = force + active
            stiffness = stiffness + self.area / self.length * answer.stiffness[0]
            if tangent and answer.rate_sensitivity is not None:
                damping = (self.area / self.length * answer.rate_sensitivity).reshape(1, 1)
        if rate and self.viscosity is not None:
            stretch, over = 1.0 + motion.displacement / self.length, self.area / self.length * self.viscosity
            force = force + over * stretch**2 * motion.velocity
            stiffness = stiffness + float((2.0 * over / self.length * stretch * motion.velocity)[0])
            added = (over * stretch**2).reshape(1, 1)
            damping = added if damping is None else damping + added
        # The stretch 1 + x / L is rounded as L is: that round-off, times the stiffness, is what the force cannot beat.
        magnitude = abs(stiffness) * self.length + abs(external[0])
        return Balance(force, np.array([[stiffness]]) if tangent else None, damping, magnitude=float(magnitude))

    def viscous_force(self, motion: Motion, time: float) -> Array | None:
        if self.viscosity is None:
            return None
        return (
            self.area / self.length * self.viscosity * (1.0 + motion.displacement / self.length) ** 2 * motion.velocity
        )

    def external_force(self, displacement: Array, time: float) -> Array:
        if self.load is None:
            return _NO_FORCE
        return np.array(self.load.value(time), dtype=float).reshape(1)

    def admissible(self, displacement: Array, time: float = 0.0) -> bool:
        return bool(displacement[0] > -self.length)

    def elastic_energy(self, displacement: Array, time: float = 0.0) -> float:
        return 0.5 * self.stiffness * float(displacement[0]) ** 2

    def momentum(self, motion: Motion) -> Array:
        return self.mass * motion.velocity

    def reactions(self, motion: Motion, tension: Array, time: float) -> Mapping[str, Array]:
        return {"wall": -(self.stiffness * motion.displacement + self.area * tension)}

    def jumps(self) -> tuple[float, ...]:
        return () if self.load is None else self.load.jumps()


@hookimpl
def myobridge_macro_solids() -> dict[str, type[MacroSolid]]:
    return {"spring": Spring}
