r"""Loading: gravity and every load on the boundary, added up over the whole body.

.. math:: f_{ai} = \int N_a\,\rho\,g_i\,dV + \sum_{\text{loads}} \int N_a\,t_i\,dA

Loads that store energy (elastic bedding) act like the tissue itself: their force is internal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, Load
from myobridge_plugins.macro_solid.finite_element.surfaces import BoundaryPart

__all__ = ["Loading", "acceleration", "stores"]


@attrs.frozen(eq=False)
class Loading:
    """Loads of a body.

    Attributes
    ----------
    loads, parts : sequence
        Each load with the part of the boundary on which it acts.
    weight : ndarray, (n_full,)
        Weight of the body on every number [N]; zero without gravity.
    dimension : int
    """

    loads: Sequence[Load]
    parts: Sequence[BoundaryPart]
    weight: Array
    dimension: int

    @property
    def follows(self) -> bool:
        """Whether a load makes the stiffness unsymmetric: it depends on the displacement and stores no energy."""
        return any(not load.dead and not stores(load) for load in self.loads)

    def external(self, displacement: Array, time: float) -> Array:
        """External force on every number [N]."""
        return self._force(displacement, time, False, self.weight.copy())

    def bedding(self, displacement: Array, time: float) -> Array:
        """Internal force of what stores energy [N]: minus the loads' own."""
        return -self._force(displacement, time, True, np.zeros_like(self.weight))

    def energy(self, displacement: Array) -> float:
        """Energy stored in loads [J]."""
        return sum(
            load.energy(part.surface, self._nodal(part, displacement)) for load, part in self._pairs() if stores(load)
        )

    def stiffness(self, displacement: Array, time: float, *, stored: bool) -> Any:
        """Minus d force / d displacement of the loads that store energy, or of the others; None where it is zero."""
        import scipy.sparse as sparse

        total: Any = None
        for load, part in self._pairs():
            if stores(load) != stored:
                continue
            local = load.nodal_stiffness(part.surface, self._nodal(part, displacement), time)
            if local is None:
                continue
            numbers = self._numbers(part)
            n_facets, width = numbers.shape
            rows = np.repeat(numbers, width, axis=1).ravel()
            columns = np.tile(numbers, (1, width)).ravel()
            size = self.weight.size
            added = sparse.csr_array((local.reshape(n_facets, -1).ravel(), (rows, columns)), shape=(size, size))
            total = added if total is None else total + added
        return total

    def mass(self) -> Any:
        """Mass that hangs on the boundary, over nodes [kg]; None without."""
        import scipy.sparse as sparse

        total: Any = None
        n_nodes = self.weight.size // self.dimension
        for load, part in self._pairs():
            local = load.nodal_mass(part.surface)
            if local is None:
                continue
            n_facets, width = part.nodes.shape
            rows = np.repeat(part.nodes, width, axis=1).ravel()
            columns = np.tile(part.nodes, (1, width)).ravel()
            added = sparse.csr_array((local.reshape(n_facets, -1).ravel(), (rows, columns)), shape=(n_nodes, n_nodes))
            total = added if total is None else total + added
        return total

    def jumps(self) -> tuple[float, ...]:
        """Times at which a load jumps or bends [s]."""
        return tuple(time for load in self.loads for time in load.jumps())

    def check(self) -> None:
        """Ask every load for its force once, so that what does not fit the body is said at once.

        Raises
        ------
        ParameterError
            Naming the load.
        """
        for index, (load, part) in enumerate(self._pairs()):
            try:
                load.nodal_force(part.surface, np.zeros_like(part.surface.positions), 0.0)
            except ParameterError as error:
                raise ParameterError(f"load[{index}].{error.key}", error.problem) from None

    def _pairs(self) -> list[tuple[Load, BoundaryPart]]:
        return list(zip(self.loads, self.parts, strict=True))

    def _force(self, displacement: Array, time: float, stored: bool, total: Array) -> Array:
        for load, part in self._pairs():
            if stores(load) == stored:
                force = load.nodal_force(part.surface, self._nodal(part, displacement), time)
                np.add.at(total, self._numbers(part).ravel(), force.ravel())
        return total

    def _nodal(self, part: BoundaryPart, displacement: Array) -> Array:
        return displacement.reshape(-1, self.dimension)[part.nodes]

    def _numbers(self, part: BoundaryPart) -> np.ndarray:
        d = self.dimension
        return (d * part.nodes[:, :, None] + np.arange(d)).reshape(part.nodes.shape[0], -1)


def stores(load: Load) -> bool:
    """Whether a load stores energy, so that its force is internal."""
    return type(load).energy is not Load.energy


def acceleration(gravity: tuple[float, ...] | float, dimension: int) -> Array:
    """Gravity as a vector [m/s^2]; one number points downwards along the last axis.

    Raises
    ------
    ParameterError
        If it has another number of components than the body.
    """
    if isinstance(gravity, tuple):
        if len(gravity) != dimension:
            raise ParameterError("gravity", f"has {len(gravity)} components; the body has {dimension} dimensions")
        return np.array(gravity)
    return np.append(np.zeros(dimension - 1), -gravity)
