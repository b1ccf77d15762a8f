r"""What chain and rope share: an elastic line in one or three dimensions.

.. math:: W = \sum_i w_i A \Bigl( \tfrac{E}{2} (\lambda_i - 1)^2 + \psi_i(\lambda_i) \Bigr), \qquad
          g_i = \sum_a B_{ia} x_a, \quad \lambda_i = |g_i|

`x` are the positions of the nodes, `B` the derivative along the reference line at the sites, `w` their share of the
length: differences of neighbours for a chain, shape function derivatives at quadrature points for a rope.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import attrs
import numpy as np
import scipy.sparse as sparse

from myobridge.errors import ParameterError
from myobridge.interfaces import ActiveLaw, Array, Balance, MacroSolid, Matrix, Motion, Signal, Works
from myobridge.parameters import choice, number, numbers, part
from myobridge.solvers import times
from myobridge_plugins.macro_solid.line_forces import balance, step_balance, step_works, viscous_force

__all__ = ["Line", "LineMesh"]

# Below this many unknowns dense matrices are faster than the bookkeeping of sparse ones.
_DENSE = 120


class LineMesh(NamedTuple):
    """Discrete line: nodes and sites [m], derivative at the sites [1/m], site lengths [m], mass over total mass."""

    nodes: Array
    sites: Array
    derivative: Any
    lengths: Array
    mass: Matrix


@attrs.frozen(eq=False)
class Line(MacroSolid):
    """Abstract elastic line along the first axis; its subclasses say how it is cut into sites.

    Parameters
    ----------
    length, area, modulus, mass : float
        Rest length [m], cross-section [m^2], Young's modulus [Pa], total mass [kg].
    dimension : "1" or "3"
        Of the space in which it moves.
    left, right : "fixed" or "free"
        The two ends.
    load : Signal, optional
        Force along the first axis on the right end [N].
    gravity : float or three floats, optional
        Acceleration [m/s^2], effect ``gravity``.
    viscosity : float, optional
        eta [Pa s] of Kelvin and Voigt, effect ``viscosity``.
    stretch_at_start : float
        Uniform stretch at t = 0; an end that is fixed stays where it puts it.
    displacement, velocity : sequence of float, optional
        Of the free nodes at t = 0, node by node; instead of the uniform stretch, of rest.
    """

    length: float = number(1.0, unit="m", within="(0, inf)", doc="rest length")
    area: float = number(1e-4, unit="m^2", within="(0, inf)", doc="cross-section")
    modulus: float = number(1e5, unit="Pa", within="(0, inf)", doc="Young's modulus")
    mass: float = number(0.1, unit="kg", within="(0, inf)", doc="total mass")
    dimension: str = choice("1", ("1", "3"), doc="dimension of the space in which it moves")
    left: str = choice("fixed", ("fixed", "free"), doc="support of the left end")
    right: str = choice("free", ("fixed", "free"), doc="support of the right end")
    load: Signal | None = part("signal", None, doc="force on the right end [N], positive pulls")
    gravity: float | tuple[float, ...] | None = numbers(
        None, unit="m/s^2", doc="acceleration along each axis", effect="gravity", on=-9.81
    )
    viscosity: float | None = number(
        None, unit="Pa s", within="[0, inf)", doc="viscosity of Kelvin and Voigt", effect="viscosity", on=10.0
    )
    stretch_at_start: float = number(1.0, within="(0, inf)", doc="uniform stretch at the start; fixed ends stay there")
    displacement: tuple[float, ...] | None = numbers(None, unit="m", doc="free displacements at the start")
    velocity: tuple[float, ...] | None = numbers(None, unit="m/s", doc="free velocities at the start")

    def __attrs_post_init__(self) -> None:
        for name in ("displacement", "velocity"):
            given = getattr(self, name)
            if given is not None and np.size(given) != self.n_unknowns:
                raise ParameterError(name, f"has {np.size(given)} values; expected one for each of {self.n_unknowns}")
        if self.load is not None and np.size(self.load.value(0.0)) != 1:
            raise ParameterError(
                "load", f"has {np.size(self.load.value(0.0))} values; expected 1, the force on one end"
            )
        if self.load is not None and self.right == "fixed":
            raise ParameterError("load", "acts on the right end, which is fixed; set right = 'free'")
        if self.gravity is not None and np.size(self.gravity) not in (1, self.n_axes):
            raise ParameterError("gravity", f"has {np.size(self.gravity)} values; expected 1 or {self.n_axes}")

    @abstractmethod
    def cut(self) -> LineMesh:
        """The discrete line."""

    @cached_property
    def mesh(self) -> LineMesh:
        """The discrete line, cut once."""
        return self.cut()

    @property
    def n_axes(self) -> int:
        """Dimension of the space."""
        return int(self.dimension)

    @cached_property
    def free(self) -> np.ndarray:
        """Indices of the free components among all node components."""
        last = self.mesh.nodes.size - 1
        ends = ([0] if self.left == "fixed" else []) + ([last] if self.right == "fixed" else [])
        nodes = np.setdiff1d(np.arange(last + 1), ends)
        return (nodes[:, None] * self.n_axes + np.arange(self.n_axes)).ravel()

    @property
    def n_unknowns(self) -> int:
        return self.free.size

    @property
    def n_sites(self) -> int:
        return self.mesh.lengths.size

    @cached_property
    def site_volumes(self) -> Array:
        return self.area * self.mesh.lengths

    @cached_property
    def _reference(self) -> Array:
        positions = np.zeros((self.mesh.nodes.size, self.n_axes))
        positions[:, 0] = self.mesh.nodes
        return positions

    @cached_property
    def _held(self) -> Array:
        """Positions without the free displacements: a fixed end is held where the uniform stretch puts it."""
        held = self.stretch_at_start * self._reference
        held.ravel()[self.free] = self._reference.ravel()[self.free]
        return held

    @cached_property
    def derivative(self) -> Any:
        """Derivative of the free components at the sites, (n_sites * n_axes, n_unknowns)."""
        full = sparse.kron(self.mesh.derivative, np.eye(self.n_axes), format="csc")[:, self.free]
        return full.toarray() if self.n_unknowns <= _DENSE else sparse.csr_array(full)

    @cached_property
    def transposed(self) -> Any:
        derivative = self.derivative
        return np.ascontiguousarray(derivative.T) if self.n_unknowns <= _DENSE else sparse.csr_array(derivative.T)

    @cached_property
    def node_derivative(self) -> Any:
        return self.mesh.derivative.toarray() if self.n_unknowns <= _DENSE else self.mesh.derivative

    @cached_property
    def mass_matrix(self) -> Matrix:
        mass = self.mesh.mass
        if isinstance(mass, np.ndarray):
            return self.mass * np.repeat(mass, self.n_axes)[self.free]
        full = sparse.csc_array(sparse.kron(mass, np.eye(self.n_axes)))
        free = self.mass * full[:, self.free][self.free]
        return free.toarray() if self.n_unknowns <= _DENSE else sparse.csc_array(free)

    def rest_motion(self) -> Motion:
        moved = (self.stretch_at_start - 1.0) * self._reference.ravel()[self.free]
        displacement = moved if self.displacement is None else np.array(self.displacement, dtype=float).ravel()
        velocity = np.zeros(self.n_unknowns) if self.velocity is None else np.array(self.velocity, dtype=float).ravel()
        return Motion(displacement, velocity)

    def positions(self, displacement: Array) -> Array:
        """Current node positions [m], shape (n_nodes, n_axes)."""
        positions = self._held.copy()
        positions.ravel()[self.free] += displacement
        return positions

    def gradient(self, displacement: Array) -> tuple[Array, Array]:
        """Direction times stretch at the sites (n_sites, n_axes), and the stretch."""
        gradient = self.node_derivative @ self.positions(displacement)
        return gradient, np.sqrt(np.einsum("ia,ia->i", gradient, gradient))

    def stretch(self, displacement: Array, time: float) -> Array:
        return self.gradient(displacement)[1]

    def stretch_rate(self, displacement: Array, velocity: Array, time: float) -> Array:
        gradient, stretch = self.gradient(displacement)
        rate = (self.derivative @ velocity).reshape(gradient.shape)
        return np.einsum("ia,ia->i", gradient, rate) / stretch

    def balance(
        self, motion: Motion, law: ActiveLaw | None, time: float, *, rate: bool = True, tangent: bool = False
    ) -> Balance:
        return balance(self, motion, law, time, rate=rate, tangent=tangent)

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
        return step_balance(self, start, end, law, times, tangent=tangent)

    def step_works(
        self, start: Motion, end: Motion, law: ActiveLaw | None, times: tuple[float, float], *, multiplier: Any = None
    ) -> Works:
        return step_works(self, start, end, law, times)

    def viscous_force(self, motion: Motion, time: float) -> Array | None:
        return viscous_force(self, motion)

    def between(self, blocks: Array) -> Any:
        """B^T diag(blocks) B for blocks (n_sites, n_axes, n_axes), free part."""
        n = self.n_sites
        if self.n_unknowns <= _DENSE:
            derivative = self.derivative.reshape(n, self.n_axes, self.n_unknowns)
            return self.transposed @ (blocks @ derivative).reshape(self.derivative.shape)
        middle = sparse.bsr_array((blocks, np.arange(n), np.arange(n + 1)))
        return sparse.csc_array(self.transposed @ (middle @ self.derivative))

    @cached_property
    def _weight(self) -> Array:
        """Force of gravity on all nodes [N], shape (n_nodes, n_axes); one number acts along the last axis: down."""
        acceleration = np.zeros(self.n_axes)
        given = np.zeros(1) if self.gravity is None else np.ravel(self.gravity)
        acceleration[-given.size :] = given
        return self.mass * times(self.mesh.mass, np.ones(self.mesh.nodes.size))[:, None] * acceleration

    def external_force(self, displacement: Array, time: float) -> Array:
        force = self._weight.ravel()[self.free]
        if self.load is not None:
            force[-self.n_axes] += float(np.ravel(self.load.value(time))[0])
        return force

    def admissible(self, displacement: Array, time: float = 0.0) -> bool:
        if not np.all(np.isfinite(displacement)):
            return False
        gradient, stretch = self.gradient(displacement)
        # In one dimension a segment that turned round has passed through zero length.
        return bool(np.all(stretch > 0.0) and (self.n_axes > 1 or np.all(gradient > 0.0)))

    def elastic_energy(self, displacement: Array, time: float = 0.0) -> float:
        _, stretch = self.gradient(displacement)
        return 0.5 * self.modulus * float(np.dot(self.site_volumes, (stretch - 1.0) ** 2))

    def momentum(self, motion: Motion) -> Array:
        return times(self.mass_matrix, motion.velocity).reshape(-1, self.n_axes).sum(axis=0)

    def angular_momentum(self, motion: Motion) -> Array:
        if self.n_axes == 1:
            return np.zeros(3)
        momenta = np.zeros((self.mesh.nodes.size, 3))
        momenta.ravel()[self.free] = times(self.mass_matrix, motion.velocity)
        return np.cross(self.positions(motion.displacement), momenta).sum(axis=0)

    def statics_obstacle(self, motion: Motion, law: ActiveLaw | None) -> str:
        if self.n_axes == 1:
            return ""
        stretch = self.stretch(motion.displacement, 0.0)
        stress = self.modulus * (stretch - 1.0)
        if law is not None:
            stress = stress + law.evaluate(stretch, np.zeros_like(stretch)).tension
        slack = np.flatnonzero(stress <= 1e-9 * self.modulus)  # round-off of the positions holds nothing
        if slack.size == 0:
            return ""
        return (
            f"{slack.size} of {stress.size} segments are slack (the first: {slack[0]}), so nothing holds them sideways "
            "and there is no unique equilibrium. Stretch it at the start (stretch_at_start > 1), call for the effect "
            "'inertia', or set dimension = '1'"
        )

    def reactions(self, motion: Motion, tension: Array, time: float) -> Mapping[str, Array]:
        gradient, stretch = self.gradient(motion.displacement)
        stress = self.modulus * (stretch - 1.0) + tension
        forces = self.mesh.derivative.T @ ((self.site_volumes * stress / stretch)[:, None] * gradient)
        forces -= self._weight  # what rests on a support directly; its share of a consistent mass's inertia is left out
        return self._at_supports(forces)

    def supported_load(self, time: float) -> Mapping[str, Array]:
        return self._at_supports(self._weight)

    def _at_supports(self, forces: Array) -> Mapping[str, Array]:
        return {name: forces[node] for name, node in (("left", 0), ("right", -1)) if getattr(self, name) == "fixed"}

    def site_positions(self) -> Array:
        return self.mesh.sites[:, None]

    def jumps(self) -> tuple[float, ...]:
        return () if self.load is None else self.load.jumps()
