r"""Macro solid: the tissue that the fibres pull on, from one spring to a million unknowns.

.. math:: M \dot v + f(u, v, t; T) = 0, \qquad \lambda = \lambda(u, t)

with `f` internal minus external force and the active law `T` acting along the fibre at every site. The power of the
active tension is :math:`\sum_i V_i\,T_i\,\dot\lambda_i`, with `V` the reference volume of a site: a solid must
apply the tension through the transpose of its own stretch gradient, or energy is not conserved.

Unknowns are the *free* displacements ``(n_unknowns,)``; what a support prescribes is no unknown. A solid whose
stretch is given (a clamp) has none. Matrices are
``(n_unknowns, n_unknowns)``, dense below about 100, else scipy sparse.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from myobridge.interfaces.active_law import ActiveLaw, Array
from myobridge.interfaces.motion import Balance, Matrix, Motion, VisibleMesh, Works

__all__ = ["MacroSolid"]


class MacroSolid(ABC):
    """Abstract solid; geometry and material are the attributes of a frozen class, motion is an argument.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    inherent_effects : frozenset of str
        Effects that are always there; optional ones are tied to a parameter.
    inertia : bool
        Whether the solid has a mass matrix, so that a scene may call for inertia.
    """

    summary: ClassVar[str] = ""
    inherent_effects: ClassVar[frozenset[str]] = frozenset()
    inertia: ClassVar[bool] = True

    @property
    @abstractmethod
    def n_unknowns(self) -> int:
        """Number of free displacements; 0 for a clamp."""

    @property
    @abstractmethod
    def n_sites(self) -> int:
        """Number of sites."""

    @property
    @abstractmethod
    def site_volumes(self) -> Array:
        """Reference volume that each site stands for [m^3], shape (n_sites,)."""

    @abstractmethod
    def rest_motion(self) -> Motion:
        """Motion at t = 0: initial displacement and velocity."""

    @abstractmethod
    def stretch(self, displacement: Array, time: float) -> Array:
        """Fibre stretch at the sites [-], shape (n_sites,)."""

    @abstractmethod
    def stretch_rate(self, displacement: Array, velocity: Array, time: float) -> Array:
        """Rate of the fibre stretch [1/s], shape (n_sites,)."""

    @property
    def mass_matrix(self) -> Matrix:
        """Mass matrix [kg]; a vector where it is lumped. Asked for by scenes with inertia only."""
        raise NotImplementedError(f"{type(self).__name__} has no mass")

    def added_mass(self, inertance: Array) -> Matrix:
        r"""Mass that heads of given `inertance` [Pa s^2] add to a solid whose stretch is linear [kg].

        Raises
        ------
        PluginError
            If the solid cannot carry heads with mass.
        """
        from myobridge.errors import PluginError

        raise PluginError(f"{type(self).__name__} cannot carry heads with mass (effect 'cross_bridge_mass').")

    def balance(
        self, motion: Motion, law: ActiveLaw | None, time: float, *, rate: bool = True, tangent: bool = False
    ) -> Balance:
        """Force balance at `motion`; with `law` None the solid is passive.

        Parameters
        ----------
        rate : bool
            Whether the law sees the stretch rate of `motion` (else rate 0, as in statics).
        tangent : bool
            Whether stiffness and damping are wanted too.
        """
        raise NotImplementedError(f"{type(self).__name__} has no unknowns to balance")

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
        r"""Balance over a whole step, as a discrete gradient: its work is the change of the stored energy.

        .. math:: f \cdot (u_1 - u_0) = W(u_1) - W(u_0) + \Psi(u_1) - \Psi(u_0)
                  + p \cdot \bigl(c(u_1) - c(u_0)\bigr) - W_{external} + W_{viscous}

        with :math:`\Psi` the energy of a law with a potential. A law without one is asked at the middle of the
        stretches and at their mean rate. The constraint is that of `end`.

        Parameters
        ----------
        start, end : Motion
            At the two `times` [s]; the mean velocity follows from the displacements.
        multiplier : ndarray, optional
            Acts in the force; that of `end` unless given.

        Returns
        -------
        Balance
            `stiffness` is the derivative by the displacement at the end, rates included; `acting_gradient` acts in the
            force, `constraint_gradient` is that of the constraint at the end. Without a pair of its own a solid answers
            by its balance half-way, which is one for energies that are quadratic.
        """
        from myobridge.midpoint_pair import step_balance

        return step_balance(self, start, end, law, times, multiplier, tangent=tangent)

    def step_works(
        self,
        start: Motion,
        end: Motion,
        law: ActiveLaw | None,
        times: tuple[float, float],
        *,
        multiplier: Array | None = None,
    ) -> Works:
        """Works of the step that `step_balance` states, from the same arguments."""
        from myobridge.midpoint_pair import step_works

        return step_works(self, start, end, law, times, multiplier)

    def viscous_force(self, motion: Motion, time: float) -> Array | None:
        """Share of viscosity in the force of `balance` [N]; None without."""
        return None

    @property
    def stiff_constraint(self) -> bool:
        """Whether the multiplier is so stiff that its mean over a step would ring: its value at the end acts then."""
        return True

    def external_force(self, displacement: Array, time: float) -> Array:
        """External force [N], shape (n_unknowns,)."""
        return np.zeros(self.n_unknowns)

    def external_stiffness(self, displacement: Array, time: float) -> Matrix | None:
        """Minus d external force / d displacement [N/m], its share of `Balance.stiffness`; None for dead loads."""
        return None

    def supported_load(self, time: float) -> Mapping[str, Array]:
        """External force on what a support holds [N], by its name: it is in `reactions`, and in no balance."""
        return {}

    def softened(self, bulk_modulus: float) -> MacroSolid | None:
        """The same solid, with the same unknowns, whose bulk modulus [Pa] is at most this; None where it has none."""
        return None

    def admissible(self, displacement: Array, time: float = 0.0) -> bool:
        """Whether the displacement is physically possible (J > 0, stretch > 0); Newton backtracks until it is.

        `time` [s] says where supports that move are.
        """
        return bool(np.all(np.isfinite(displacement)))

    def elastic_energy(self, displacement: Array, time: float = 0.0) -> float:
        """Stored passive energy [J], without loads and cross-bridges; `time` [s] says where moving supports are."""
        return 0.0

    def support_work(
        self, stage: Motion, law: ActiveLaw | None, stage_time: float, start_time: float, end_time: float
    ) -> float:
        """Work [J] that moving supports do on the solid between two times, at the reactions of `stage`."""
        return 0.0

    def momentum(self, motion: Motion) -> Array:
        """Linear momentum [kg m/s], shape (dimension,)."""
        return np.zeros(1)

    def angular_momentum(self, motion: Motion) -> Array:
        """Angular momentum about the origin [kg m^2/s], shape (3,)."""
        return np.zeros(3)

    def reactions(self, motion: Motion, tension: Array, time: float) -> Mapping[str, Array]:
        """Force that each support exerts on the solid [N], by the support's name, under `tension` at the sites [Pa]."""
        return {}

    def statics_obstacle(self, motion: Motion, law: ActiveLaw | None) -> str:
        """Why this solid has no unique equilibrium to start statics from, in a sentence; empty where it has one."""
        return ""

    def site_positions(self) -> Array:
        """Reference position of the sites [m], shape (n_sites, dimension)."""
        return np.zeros((self.n_sites, 1))

    @property
    def multiplier_scale(self) -> float:
        """Unit of a multiplier per unit of displacement, such as modulus by length [Pa/m], that balances the tangent.

        A solver takes ``multiplier / scale`` as unknown and ``scale * constraint`` as equation.
        """
        return 1.0

    @property
    def displacement_scale(self) -> float:
        """Displacement [m] that changes the shape of the smallest part by the order of one, such as a cell's size.

        Second derivatives of the constraint are differences over it: exact for constraints of degree three and less.
        """
        return 1.0

    def rigid_motions(self) -> Array | None:
        """Translations, then rotations, of the unknowns alone, (n_unknowns, k); None where no solver needs them."""
        return None

    def memory(self) -> int:
        """Bytes of the tables that a large solid keeps, its tangent included; 0 where they do not matter."""
        return 0

    def visible_mesh(self) -> VisibleMesh | None:
        """Mesh for pictures and files; None for a solid without a shape."""
        return None

    def visible_fields(self, motion: Motion, time: float) -> Mapping[str, Array]:
        """Fields on the visible mesh: (n_points, 3) or (n_points,) at nodes, or (n_cells, ...) on cells.

        ``displacement`` [m] is there, and what else the solid knows: ``pressure`` [Pa], ``stretch``, ``fibre``, ``J``.
        """
        return {}

    def on_cells(self, values: Array) -> Array:
        """Mean over each visible cell of `values` at the sites, (n_sites,) -> (n_cells,); NaN without sites."""
        return values

    def jumps(self) -> tuple[float, ...]:
        """Times [s] at which a load or a prescribed stretch has a jump or a kink; steps end there."""
        return ()
