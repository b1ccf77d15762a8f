"""Assembly: one discretised body with its materials, ready to be summed up by the kernels."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import attrs
import numpy as np

from myobridge.compiled import LANES
from myobridge.interfaces import Array, Material
from myobridge.threads import available, shared_out
from myobridge.work import count
from myobridge_plugins.macro_solid.finite_element.discretisation import Discretisation
from myobridge_plugins.macro_solid.finite_element.pattern import Pattern

__all__ = ["AssembledRegion", "Assembly", "Kinematics", "Sums", "at_rest"]

_NONE = np.empty(0)
# Below this number of cells a second thread costs more to wake than it saves.
_SMALL = 1000


class Kinematics(NamedTuple):
    """Stretch [-], its rate [1/s] and J [-] at every point."""

    stretch: Array
    rate: Array
    jacobian: Array


class Sums(NamedTuple):
    """What one assembly gives: force [N], constraint [m^3], data of the tangents, the largest stress [Pa].

    The data of the tangents are those of the free rows of the pattern, and the caller's to keep.
    """

    force: Array
    constraint: Array
    stiffness: Array
    gradient: Array
    largest: float


@attrs.frozen(eq=False)
class AssembledRegion:
    """Material of a region, and its batches in blocks by colour."""

    material: Material
    constants: Array
    blocks: np.ndarray
    colours: np.ndarray
    batches: np.ndarray


class Assembly:
    """Arrays of a body in the form that the kernels take.

    Parameters
    ----------
    discretisation : Discretisation
    pattern : Pattern
    materials : sequence of Material
        One a region.
    fibre : ndarray, (3, n_points)
        Reference direction at every point.
    threads : int
        Threads of a loop over blocks, 0: all; the answer does not depend on it.

    Attributes
    ----------
    cells, multipliers, zeros : ndarray
        What every kernel takes (see `assembly_kernels`), and zeros at all points.
    regions : list of AssembledRegion
    """

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: Pattern,
        materials: Sequence[Material],
        fibre: Array,
        threads: int,
    ) -> None:
        self.discretisation = discretisation
        self.pattern = pattern
        self.threads = threads
        cell = discretisation.cell
        self.cells = (
            discretisation.sizes,
            discretisation.starts,
            discretisation.batched(discretisation.nodes),
            discretisation.corners,
            np.ascontiguousarray(fibre),
            cell.weights,
            cell.slopes,
            cell.map_slopes,
        )
        self.multipliers = discretisation.batched(discretisation.multipliers)
        self.regions: list[AssembledRegion] = []
        for number, material in enumerate(materials):
            blocks, colours = discretisation.blocks(number)
            batches = np.arange(*discretisation.region_batches[number], dtype=np.int32)
            constants = np.ascontiguousarray(material.constants, dtype=np.float64)
            self.regions.append(AssembledRegion(material, constants, blocks, colours, batches))
        self.zeros = np.zeros(discretisation.n_points)

    def memory(self) -> int:
        """Bytes of all arrays that grow with the mesh, the data of the tangents included."""
        pattern = self.pattern
        held = [*self.cells, self.multipliers, pattern.lengths, self.zeros]
        for part in (pattern.stiffness, pattern.gradient):
            held += [part.rows, part.places, part.indptr, part.indices]
        return sum(array.nbytes for array in held) + 8 * (pattern.stiffness.size + pattern.gradient.size)

    def kinematics(self, displacement: Array, velocity: Array | None = None) -> Kinematics:
        """Stretch, rate and J at all points for full nodal vectors; without `velocity` the rate is zero."""
        from myobridge_plugins.macro_solid.finite_element.point_loops import kinematics

        n = self.discretisation.n_points
        found = Kinematics(np.empty(n), np.empty(n) if velocity is not None else self.zeros, np.empty(n))
        moving = displacement if velocity is None else velocity

        def loop(first: int, last: int) -> None:
            rated = velocity is not None
            kinematics(first, last, *self.shape, rated, *self.cells, displacement, moving, *found)

        self.run(loop, [0, self.discretisation.sizes.size])
        return found

    def sums(
        self,
        displacement: Array,
        pressure: Array,
        tension: Array | None,
        stiffness: Array | None,
        *,
        tangent: bool,
        passive: bool = True,
    ) -> Sums:
        """Internal force and constraint, and their derivatives where `tangent` is asked for."""
        from myobridge_plugins.macro_solid.finite_element.assembly_kernels import assemble

        grid, pattern = self.discretisation, self.pattern
        count("assembled_elements", grid.n_cells)
        force = np.zeros(grid.dimension * grid.n_nodes)
        constraint = np.zeros(grid.n_multipliers)
        stiffness_data = np.zeros(pattern.stiffness.size) if tangent else _NONE
        gradient_data = np.zeros(pattern.gradient.size) if tangent else _NONE
        top = 0.0
        for region in self.regions:
            functions = region.material.functions()
            law = functions.tangent if tangent else functions.stress
            largest = np.zeros(len(region.blocks))
            given = (
                *self.shape,
                passive,
                tangent,
                *self.cells,
                self.multipliers,
                grid.cell.shapes,
                region.blocks,
                law.pointer,
                region.constants,
                displacement,
                pressure,
                self.zeros if tension is None else tension,
                self.zeros if stiffness is None else stiffness,
                pattern.lengths,
                pattern.stiffness.rows,
                pattern.stiffness.places,
                pattern.gradient.rows,
                pattern.gradient.places,
                force,
                constraint,
                stiffness_data,
                gradient_data,
                largest,
            )
            self.run(lambda first, last, given=given: assemble(first, last, *given), region.colours)
            top = max(top, float(largest.max(initial=0.0)))
        return Sums(force, constraint, stiffness_data, gradient_data, top)

    def energy(self, displacement: Array) -> float:
        """Passive energy of the body [J], without the constraint's share."""
        from myobridge_plugins.macro_solid.finite_element.energy_kernels import energies

        found = np.zeros(self.discretisation.sizes.size)
        for region in self.regions:
            law = region.material.functions().energy.pointer
            given = (*self.shape, *self.cells, region.batches, law, region.constants, displacement, found)
            self.run(lambda first, last, given=given: energies(first, last, *given), [0, region.batches.size])
        return float(found.sum())

    @property
    def shape(self) -> tuple[int, bool]:
        """Dimension, and whether cells are affine."""
        return self.discretisation.dimension, self.discretisation.cell.affine

    def run(self, loop: Callable[[int, int], None], bounds: Sequence[int] | np.ndarray) -> None:
        """Run a loop over a range, one part after the other, each shared out among threads."""
        threads = min(self.threads or available(), available())
        if threads == 1 or self.discretisation.n_cells < _SMALL:
            bounds = [bounds[0], bounds[-1]]
            threads = 1
        for first, last in itertools.pairwise(bounds):
            shared_out(threads, int(first), int(last), loop)


def at_rest(material: Material, fibre: Array) -> tuple[Array, Array]:
    """Stress (9,) and tangent (9, 9) of a material at ``F = 1`` [Pa]."""
    state, out = np.zeros(15 * LANES), np.zeros(54 * LANES)
    state.reshape(15, LANES)[[0, 4, 8], 0] = 1.0
    state.reshape(15, LANES)[9 : 9 + fibre.size, 0] = fibre
    material.functions().tangent(1, state, out, np.ascontiguousarray(material.constants, dtype=np.float64))
    rows = out.reshape(54, LANES)[:, 0]
    tangent = np.zeros((9, 9))
    tangent[np.triu_indices(9)] = rows[9:]
    return rows[:9].copy(), tangent + np.triu(tangent, 1).T
