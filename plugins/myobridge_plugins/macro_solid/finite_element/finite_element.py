"""Finite-element solid: nearly incompressible tissue with fibres, in plane strain and in 3D."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import (
    ActiveLaw,
    Array,
    Balance,
    Fibres,
    Load,
    MacroSolid,
    Material,
    Matrix,
    MeshSource,
    Motion,
    VisibleMesh,
    Works,
)
from myobridge.parameters import choice, integer, number, numbers, part, parts, records
from myobridge_plugins.macro_solid.finite_element import forces, masses, momenta
from myobridge_plugins.macro_solid.finite_element.body import Body
from myobridge_plugins.macro_solid.finite_element.building import build
from myobridge_plugins.macro_solid.finite_element.element_pairs import PAIRS
from myobridge_plugins.macro_solid.finite_element.regions import Region
from myobridge_plugins.macro_solid.finite_element.start import start_motion
from myobridge_plugins.macro_solid.finite_element.step import Step
from myobridge_plugins.macro_solid.finite_element.supports import Support

__all__ = ["FiniteElement"]

# [Pa] Bulk modulus beyond which the mean of the pressure over a step rings.
_STIFF = 1e6


@final
@attrs.frozen(eq=False)
class FiniteElement(MacroSolid):
    r"""Hyperelastic body with fibres, strictly or nearly incompressible (macro scale of the thesis [1]_, Model 2.25).

    .. math:: \int \bigl(P(F) + p\,\mathrm{cof} F + \tfrac{T}{\lambda}\,F N \otimes N\bigr) : \nabla w
              = \int \rho g \cdot w + \int t \cdot w, \qquad
              \int \psi\,\bigl(\det F - 1 - p / \kappa\bigr) = 0

    for all displacements `w` and pressures `psi`, in the reference body. `P` is the first Piola-Kirchhoff stress of a
    material, `T` the nominal active tension along the reference fibre `N` at stretch :math:`\lambda = |F N|`, `p` the
    multiplier, positive in tension; the hydrostatic pressure is minus a third of the trace of Cauchy's stress. Sites
    are the quadrature points of muscle; tendon has none. One formulation serves every bulk modulus up to infinity.

    Plane bodies are in plane strain, :math:`F_{33} = 1`, of the given thickness.

    Departures
    ----------
    The thesis' incompressible law has no rest state where its Mooney-Rivlin stress is not zero; materials here are
    stress free at rest. Its pair P1-P0 locks, and is not the pair of Taylor and Hood; the default is P2-P1.

    Parameters
    ----------
    mesh : MeshSource
    material : Material
    fibres : Fibres, optional
        Along the first axis without.
    load, support, region : sequences
        Loads on named boundaries, what is held, and parts of another tissue.
    elements : str, optional
        Element pair; ``P2-P1`` or ``Q2-P1disc`` without.
    bulk_modulus : float
        kappa [Pa], infinite for strict incompressibility (effect `incompressibility`).
    viscosity : float
        eta [Pa s] of Kelvin and Voigt, S = eta dE/dt with Green's strain E (effect `viscosity`).
    gravity : float or sequence of float
        Acceleration [m/s^2], downwards along the last axis where it is one number (effect `gravity`).
    density : float
        Mass per reference volume [kg/m^3].
    mass : "consistent" or "lumped", which is diagonal
    stretch_at_start, velocity_at_start, spin_at_start : sequences of float, optional
        Of the whole body at t = 0: stretch along each axis, translation [m/s], rotation about the centre of mass
        [rad/s], one number in the plane. What is held stays where it is.
    thickness : float
        Depth of a plane body [m].
    quadrature : int
        Degree of polynomials that are integrated exactly.
    threads : int
        Threads of an assembly; 0: all. The answer does not depend on it.

    References
    ----------
    .. [1] Thesis, sections 2.2 and 4.1.
    """

    summary: ClassVar[str] = (
        "finite elements in 2D and 3D, nearly or strictly incompressible, sites at quadrature points"
    )

    mesh: MeshSource = part("mesh", doc="where the shape comes from")
    material: Material = part("material", doc="passive law of the tissue")
    fibres: Fibres | None = part("fibres", None, doc="fibre directions; along the first axis when left out")
    load: tuple[Load, ...] = parts("load", doc="loads on named boundaries")
    support: tuple[Support, ...] = records(Support, doc="boundaries whose displacement is prescribed")
    region: tuple[Region, ...] = records(Region, doc="parts of the mesh made of another tissue")
    elements: str | None = choice(None, PAIRS, doc="element pair; P2-P1 or Q2-P1disc when left out")
    bulk_modulus: float | None = number(
        None, unit="Pa", within="(0, inf]", effect="incompressibility", on=math.inf, doc="bulk modulus; inf: strict"
    )
    viscosity: float | None = number(
        None, unit="Pa s", within="[0, inf)", effect="viscosity", on=10.0, doc="viscosity of the tissue"
    )
    gravity: tuple[float, ...] | float | None = numbers(
        None, unit="m/s^2", effect="gravity", on=9.81, doc="acceleration; one number: downwards along the last axis"
    )
    density: float = number(1.1e3, unit="kg/m^3", within="(0, inf)", doc="mass per reference volume")
    mass: str = choice("consistent", masses.CHOICES, doc="mass matrix; lumped: diagonal, for explicit methods")
    stretch_at_start: tuple[float, ...] | None = numbers(None, within="(0, inf)", doc="stretch at the start, by axis")
    velocity_at_start: tuple[float, ...] | float | None = numbers(None, unit="m/s", doc="velocity at the start")
    spin_at_start: tuple[float, ...] | float | None = numbers(None, unit="rad/s", doc="rotation at the start")
    thickness: float = number(1.0, unit="m", within="(0, inf)", doc="depth of a plane body")
    quadrature: int = integer(5, within="[1, 12]", doc="degree of polynomials integrated exactly")
    threads: int = integer(0, doc="threads of an assembly; 0: all")
    shared: Body | None = attrs.field(default=None, repr=False, kw_only=True)

    @cached_property
    def _body(self) -> Body:
        return self.shared or build(self)

    # ------------------------------------------------------------------ sizes

    @property
    def n_unknowns(self) -> int:
        return self._body.free.size

    @property
    def n_sites(self) -> int:
        return self._body.n_sites

    @cached_property
    def site_volumes(self) -> Array:
        return self._body.grid.volumes[: self.n_sites]

    def site_positions(self) -> Array:
        return self._body.grid.point_positions[: self.n_sites]

    @property
    def multiplier_scale(self) -> float:
        return self._body.modulus / self._body.cell_size

    @property
    def displacement_scale(self) -> float:
        return self._body.cell_size

    def rest_motion(self) -> Motion:
        at_start = (self.stretch_at_start, self.velocity_at_start, self.spin_at_start)
        return start_motion(self._body, lambda: self._node_mass, *at_start)

    def memory(self) -> int:
        """Bytes that the body's tables and the data of its tangent take."""
        return self._body.assembly.memory()

    def softened(self, bulk_modulus: float) -> FiniteElement | None:
        if self.bulk_modulus is None:
            return None
        return attrs.evolve(self, bulk_modulus=min(bulk_modulus, self.bulk_modulus), shared=self._body)

    # ------------------------------------------------------------------ kinematics

    def stretch(self, displacement: Array, time: float) -> Array:
        body = self._body
        return body.assembly.kinematics(body.displacement(displacement, time)).stretch[: body.n_sites]

    def stretch_rate(self, displacement: Array, velocity: Array, time: float) -> Array:
        body = self._body
        full, moving = body.displacement(displacement, time), body.velocity(velocity, time)
        return body.assembly.kinematics(full, moving).rate[: body.n_sites]

    def admissible(self, displacement: Array, time: float = 0.0) -> bool:
        if not np.all(np.isfinite(displacement)):
            return False
        body = self._body
        return bool(body.assembly.kinematics(body.displacement(displacement, time)).jacobian.min() > 0.0)

    # ------------------------------------------------------------------ balance

    def balance(
        self, motion: Motion, law: ActiveLaw | None, time: float, *, rate: bool = True, tangent: bool = False
    ) -> Balance:
        moduli = (self.bulk_modulus, self.viscosity)
        return forces.balance(self._body, motion, law, time, *moduli, rate=rate, tangent=tangent)

    def step_balance(
        self,
        start: Motion,
        end: Motion,
        law: ActiveLaw | None,
        times: tuple[float, float],
        *,
        multiplier: Array | None = None,
        tangent: bool = False,
    ) -> Balance:
        step = Step(self._body, start, end, law, times, multiplier, self.bulk_modulus, self.viscosity)
        return step.balance(tangent=tangent)

    def step_works(
        self,
        start: Motion,
        end: Motion,
        law: ActiveLaw | None,
        times: tuple[float, float],
        *,
        multiplier: Array | None = None,
    ) -> Works:
        return Step(self._body, start, end, law, times, multiplier, self.bulk_modulus, self.viscosity).works()

    def viscous_force(self, motion: Motion, time: float) -> Array | None:
        if not self.viscosity:
            return None
        return forces.viscous_force(self._body, motion, time, self.viscosity)[self._body.free]

    @property
    def stiff_constraint(self) -> bool:
        return self.bulk_modulus is None or self.bulk_modulus > _STIFF

    def external_force(self, displacement: Array, time: float) -> Array:
        body = self._body
        return body.loading.external(body.displacement(displacement, time), time)[body.free]

    def external_stiffness(self, displacement: Array, time: float) -> Matrix | None:
        return forces.external_stiffness(self._body, displacement, time)

    def reactions(self, motion: Motion, tension: Array, time: float) -> Mapping[str, Array]:
        force = forces.total_force(self._body, motion, tension, time, self.viscosity)
        return forces.per_support(self._body, force)

    def supported_load(self, time: float) -> Mapping[str, Array]:
        rest = self._body.displacement(np.zeros(self.n_unknowns), time)
        return forces.per_support(self._body, self._body.loading.external(rest, time))

    def support_work(
        self, stage: Motion, law: ActiveLaw | None, stage_time: float, start_time: float, end_time: float
    ) -> float:
        return forces.support_work(self._body, stage, law, stage_time, (start_time, end_time))

    # ------------------------------------------------------------------ energy, momentum

    def elastic_energy(self, displacement: Array, time: float = 0.0) -> float:
        return forces.elastic_energy(self._body, self._body.displacement(displacement, time), self.bulk_modulus)

    @cached_property
    def _node_mass(self) -> Any:
        return masses.node_mass(self._body, self.density, self.mass)

    @cached_property
    def mass_matrix(self) -> Matrix:
        return masses.mass_matrix(self._body, self._node_mass)

    def momentum(self, motion: Motion) -> Array:
        return masses.node_momentum(self._body, self._node_mass, motion.velocity).sum(axis=0)

    def angular_momentum(self, motion: Motion) -> Array:
        return momenta.angular_momentum(self._body, self._node_mass, motion)

    def rigid_motions(self) -> Array:
        return momenta.rigid_motions(self._body)

    def statics_obstacle(self, motion: Motion, law: ActiveLaw | None) -> str:
        return momenta.rigid_freedom(self._body)

    # ------------------------------------------------------------------ pictures, times

    def visible_mesh(self) -> VisibleMesh:
        from myobridge_plugins.macro_solid.finite_element.visible import visible_mesh

        return visible_mesh(self._body)

    def visible_fields(self, motion: Motion, time: float) -> Mapping[str, Array]:
        from myobridge_plugins.macro_solid.finite_element.visible import fields

        body = self._body
        full = body.displacement(motion.displacement, time)
        return fields(body, full, body.pressure(motion.multiplier), body.assembly.kinematics(full))

    def on_cells(self, values: Array) -> Array:
        from myobridge_plugins.macro_solid.finite_element.visible import cell_means

        return cell_means(self._body, values)

    def jumps(self) -> tuple[float, ...]:
        return (*self._body.held.jumps(), *self._body.loading.jumps())


@hookimpl
def myobridge_macro_solids() -> dict[str, type[MacroSolid]]:
    return {"finite_element": FiniteElement}
