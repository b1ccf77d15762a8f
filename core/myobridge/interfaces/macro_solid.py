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
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from myobridge.interfaces.active_law import ActiveLaw, Array

__all__ = ["Balance", "MacroSolid", "Matrix", "Motion", "VisibleMesh"]

Matrix = Any
"""A dense ndarray or a scipy sparse array."""


@attrs.frozen(eq=False)
class Motion:
    """State of a solid.

    Attributes
    ----------
    displacement : ndarray, shape (n_unknowns,)
        Free displacements [m].
    velocity : ndarray, shape (n_unknowns,)
        Their rates [m/s]; without inertia the differences over the last step.
    multiplier : ndarray, shape (n_constraints,)
        Lagrange multipliers, such as the pressure [Pa]; empty without constraint.
    """

    displacement: Array
    velocity: Array
    multiplier: Array = attrs.field(factory=lambda: np.empty(0))


class Balance(NamedTuple):
    """Balance of momentum (and constraint) at a point, with its tangent where asked for.

    Attributes
    ----------
    force : ndarray, shape (n_unknowns,)
        Internal (with active) minus external force [N].
    stiffness : matrix or None
        d force / d displacement [N/m].
    damping : matrix or None
        d force / d velocity [N s/m]; None when nothing depends on the rate.
    constraint : ndarray, shape (n_constraints,), or None
        Residual of the constraint; `force` holds the gradient's transpose times the multiplier.
    constraint_gradient : matrix, shape (n_constraints, n_unknowns), or None
        d constraint / d displacement.
    constraint_compliance : matrix, shape (n_constraints, n_constraints), or None
        Minus d constraint / d multiplier, positive semi-definite; None where it is zero.
    magnitude : float
        Norm of the terms that cancel in `force` [N]: a force below their round-off is zero to the solver.
    symmetric : bool
        Whether stiffness (and damping) is symmetric; follower loads are not.
    constraint_magnitude : float
        Norm of the terms that cancel in `constraint`, in its unit: of the volumes that J and 1 stand for, say.
    """

    force: Array
    stiffness: Matrix | None = None
    damping: Matrix | None = None
    constraint: Array | None = None
    constraint_gradient: Matrix | None = None
    constraint_compliance: Matrix | None = None
    magnitude: float = 0.0
    symmetric: bool = True
    constraint_magnitude: float = 0.0


class VisibleMesh(NamedTuple):
    """What a body looks like: nodes, cells, and meshio's word for the kind of cell (``triangle6``, ``tetra10`` ...).

    `points` is (n_points, 3) [m], `cells` (n_cells, nodes of a cell) in the order of that kind.
    """

    points: Array
    cells: Any
    kind: str


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

    def rigid_motions(self) -> Array | None:
        """Translations and rotations restricted to the unknowns, (n_unknowns, k); None where no solver needs them."""
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
