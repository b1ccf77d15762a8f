"""Body: everything about a finite-element solid that does not change while it moves, worked out once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import attrs
import numpy as np

from myobridge.errors import ParameterError, within
from myobridge.interfaces import Array, Fibres, Load, Material
from myobridge.mesh_names import boundary_facets, subdomain_cells
from myobridge_plugins.macro_solid.finite_element.assembly import Assembly, at_rest
from myobridge_plugins.macro_solid.finite_element.discretisation import Discretisation, discretise
from myobridge_plugins.macro_solid.finite_element.element_pairs import pair_of, reference_cell
from myobridge_plugins.macro_solid.finite_element.loading import Loading
from myobridge_plugins.macro_solid.finite_element.pattern import pattern
from myobridge_plugins.macro_solid.finite_element.regions import Region
from myobridge_plugins.macro_solid.finite_element.supports import Held, Support, held
from myobridge_plugins.macro_solid.finite_element.surfaces import boundary_part

__all__ = ["Body", "Tissue"]


class Tissue(NamedTuple):
    """A region: numbers of its cells, material, fibres, whether it has cross-bridges, and the key of its fibres."""

    cells: np.ndarray
    material: Material
    fibres: Fibres | None
    muscle: bool
    key: str


@attrs.frozen(eq=False)
class Body:
    """Discretised body with supports and loads.

    Attributes
    ----------
    grid : Discretisation
    tissues : sequence of Tissue
        Muscle first: the sites are the first points.
    fibre : ndarray, (3, n_points)
    held : Held
    loading : Loading
    strict : bool
        Whether the volume is kept exactly.
    n_sites : int
    thickness : float
        Depth of a plane body [m]; 1 in 3D.
    threads : int
    """

    grid: Discretisation
    tissues: Sequence[Tissue]
    fibre: Array
    held: Held
    loading: Loading
    strict: bool
    n_sites: int
    thickness: float
    threads: int

    @classmethod
    def of(
        cls,
        mesh: Any,
        material: Material,
        fibres: Fibres | None,
        *,
        regions: Sequence[Region],
        supports: Sequence[Support],
        loads: Sequence[Load],
        elements: str | None,
        bulk_modulus: float | None,
        weight: Array | None,
        thickness: float,
        degree: int,
        threads: int,
    ) -> Body:
        """Number everything; `weight` is density times the acceleration of gravity [N/m^3].

        Raises
        ------
        ParameterError
            Naming the key: a boundary or region that does not exist, cells in two regions, a pair that does not fit.
        """
        pair = pair_of(mesh, elements, bulk_modulus is not None)
        cell = reference_cell(mesh, pair, degree)
        dimension = mesh.p.shape[0]
        depth = thickness if dimension == 2 else 1.0
        cell = cell._replace(weights=depth * cell.weights)
        tissues = _tissues(mesh, material, fibres, regions)
        grid = discretise(mesh, cell, [tissue.cells for tissue in tissues])
        fibre = np.zeros((3, grid.n_points))
        n_sites = 0
        for tissue, (first, last) in zip(tissues, grid.region_batches, strict=True):
            points = slice(grid.starts[first], grid.starts[last] if last < grid.starts.size else grid.n_points)
            if tissue.fibres is None:
                fibre[0, points] = 1.0
            else:
                with within(tissue.key):
                    directions = tissue.fibres.directions(mesh, cell.points)
                cells = grid.order[grid.cell_of_point[points]]
                fibre[:dimension, points] = directions[cells, grid.quadrature_of_point[points]].T
            n_sites = points.stop if tissue.muscle else n_sites
        parts = {
            name: boundary_part(grid, boundary_facets(mesh, name, key), name, depth, degree)
            for key, name in _boundaries(supports, loads)
        }
        nodes = {name: np.unique(part.nodes) for name, part in parts.items()}
        full_weight = np.zeros(dimension * grid.n_nodes)
        if weight is not None:
            full_weight = (_nodal_volumes(grid)[:, None] * weight).ravel()
        loading = Loading(tuple(loads), [parts[load.boundary] for load in loads], full_weight, dimension)
        loading.check()
        strict = bulk_modulus is not None and np.isinf(bulk_modulus)
        body = cls(grid, tissues, fibre, held(supports, nodes, dimension), loading, strict, n_sites, depth, threads)
        if body.free.size == 0:
            raise ParameterError("support", "holds every node: nothing is left to move")
        return body

    @property
    def n_full(self) -> int:
        """Displacements of all nodes, held ones included."""
        return self.grid.dimension * self.grid.n_nodes

    def displacement(self, free: Array, time: float) -> Array:
        """Displacement of all nodes [m] from that of the free ones."""
        full = self.held.displacement(np.empty(self.n_full), time)
        full[self.free] = free
        return full

    def velocity(self, free: Array, time: float) -> Array:
        """Velocity of all nodes [m/s] from that of the free ones."""
        full = self.held.velocity(np.empty(self.n_full), time)
        full[self.free] = free
        return full

    def pressure(self, free: Array) -> Array:
        """All multipliers [Pa] from the free ones."""
        full = np.zeros(self.grid.n_multipliers)
        full[self.free_multipliers] = free
        return full

    @cached_property
    def free(self) -> np.ndarray:
        """Numbers of the unknown displacements."""
        return np.setdiff1d(np.arange(self.n_full), self.held.all_numbers)

    @cached_property
    def free_multipliers(self) -> np.ndarray:
        """Numbers of the unknown multipliers: one is set to zero where the whole boundary is held.

        Then the volume of the body is given, one constraint says what the others say, and the pressure is only
        determined up to a constant.
        """
        found = np.arange(self.grid.n_multipliers)
        if not self.strict or not found.size:
            return found
        facets = self.grid.mesh.boundary_facets()
        every = boundary_part(self.grid, facets, "boundary", 1.0, 2)
        d = self.grid.dimension
        numbers = (d * np.unique(every.nodes)[:, None] + np.arange(d)).ravel()
        enclosed = np.isin(numbers, self.held.all_numbers).all()
        # Not one that is zero for a constant pressure: of a linear one in a cell, the first number is the level.
        return np.delete(found, self.grid.multipliers[-1, 0]) if enclosed else found

    @property
    def enclosed(self) -> bool:
        """Whether the whole boundary is held, so that the pressure has no level of its own."""
        return self.free_multipliers.size < self.grid.n_multipliers

    @cached_property
    def assembly(self) -> Assembly:
        """The kernels' view of the body."""
        found = pattern(self.grid, self.free, self.free_multipliers)
        return Assembly(self.grid, found, [tissue.material for tissue in self.tissues], self.fibre, self.threads)

    @cached_property
    def modulus(self) -> float:
        """Largest shear modulus at rest of the materials [Pa]."""
        found = [at_rest(tissue.material, self.fibre[:, 0])[1] for tissue in self.tissues]
        return max(float(np.mean([tangent[r, r] for r in (1, 2, 3, 5, 6, 7)])) for tangent in found)

    @cached_property
    def cell_size(self) -> float:
        """Edge of a cube, or of a square, of the mean volume of a cell [m]."""
        mean = self.grid.volumes.sum() / (self.grid.n_cells * self.thickness)
        return float(mean ** (1.0 / self.grid.dimension))

    @cached_property
    def section(self) -> float:
        """Norm over the free numbers of the area through which stress acts on a node [m^2]."""
        cells = np.bincount(self.grid.cell_of_point, weights=self.grid.volumes, minlength=self.grid.n_cells)
        areas = cells / self.cell_size
        nodal = np.bincount(self.grid.nodes.ravel(), weights=np.repeat(areas, self.grid.nodes.shape[1]))
        return float(np.linalg.norm(np.repeat(nodal, self.grid.dimension)[self.free]))

    @cached_property
    def multiplier_mass(self) -> Any:
        """Mass matrix of the free multipliers [m^3], the constraint's compliance times the bulk modulus."""
        return _mass(self.grid, self.grid.multipliers, self.grid.cell.shapes, self.grid.n_multipliers)[
            self.free_multipliers
        ][:, self.free_multipliers]

    @cached_property
    def constraint_magnitude(self) -> float:
        """Norm of the volumes that J and 1 stand for in the constraint [m^3]."""
        return float(np.linalg.norm(self.multiplier_mass.sum(axis=1)))

    @cached_property
    def projection(self) -> Callable[[Array], Array]:
        """Inverse of `multiplier_mass`."""
        import scipy.sparse.linalg as sparse_linalg

        return sparse_linalg.splu(self.multiplier_mass.tocsc()).solve

    def node_mass(self, density: float) -> Any:
        """Consistent mass over nodes [kg], what hangs on the boundary included."""
        mass = density * _mass(self.grid, self.grid.nodes, self.grid.cell.values, self.grid.n_nodes)
        hanging = self.loading.mass()
        return mass if hanging is None else mass + hanging


def _tissues(mesh: Any, material: Material, fibres: Fibres | None, regions: Sequence[Region]) -> list[Tissue]:
    """Regions with all cells, muscle before tendon; cells of no region are the body's own."""
    owner = np.full(mesh.t.shape[1], -1)
    found: list[Tissue] = []
    for index, region in enumerate(regions):
        cells = subdomain_cells(mesh, region.name, f"region[{index}].name")
        taken = owner[cells]
        if np.any(taken >= 0):
            other = regions[int(taken[taken >= 0][0])].name
            raise ParameterError(
                f"region[{index}].name", f"'{region.name}' shares {np.sum(taken >= 0)} cells with region '{other}'"
            )
        owner[cells] = index
        key = f"region[{index}].fibres" if region.fibres is not None else "fibres"
        found.append(Tissue(cells, region.material or material, region.fibres or fibres, region.cross_bridges, key))
    rest = np.flatnonzero(owner < 0)
    if rest.size:
        found.insert(0, Tissue(rest, material, fibres, True, "fibres"))
    return sorted(found, key=lambda tissue: not tissue.muscle)


def _boundaries(supports: Sequence[Support], loads: Sequence[Load]) -> list[tuple[str, str]]:
    """(key, boundary) of everything that names one."""
    keys = [(f"support[{index}].boundary", support.boundary) for index, support in enumerate(supports)]
    return keys + [(f"load[{index}].boundary", load.boundary) for index, load in enumerate(loads)]


def _nodal_volumes(grid: Discretisation) -> Array:
    shares = grid.volumes[:, None] * grid.cell.values[grid.quadrature_of_point]
    volumes = np.zeros(grid.n_nodes)
    np.add.at(volumes, grid.nodes[grid.cell_of_point].ravel(), shares.ravel())
    return volumes


def _mass(grid: Discretisation, table: np.ndarray, values: Array, size: int) -> Any:
    """Integral of products of shape functions as a CSR array."""
    import scipy.sparse as sparse

    width = table.shape[1]
    products = np.einsum("qa,qb->qab", values, values).reshape(len(values), -1)
    local = np.zeros((grid.n_cells, width * width))
    for q, product in enumerate(products):
        here = grid.quadrature_of_point == q
        volumes = np.zeros(grid.n_cells)
        volumes[grid.cell_of_point[here]] = grid.volumes[here]
        local += volumes[:, None] * product
    rows, columns = np.repeat(table, width, axis=1).ravel(), np.tile(table, (1, width)).ravel()
    return sparse.csr_array((local.ravel(), (rows, columns)), shape=(size, size))
