"""Bodies for tests of the finite-element solid: distorted meshes, boundaries held anywhere, equilibria in one step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
import pytest

from myobridge.interfaces import Array, MeshSource, Motion
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic


@attrs.frozen
class Distorted(MeshSource):
    """Block of 30 x 20 (x 20) mm all of whose nodes are moved by a share of a cell.

    Boundaries: those of the block, and "all". Subdomain: "tendon", the cells of the last third.
    """

    shape: str = "triangle"
    cells: tuple[int, ...] = ()
    share: float = 0.15
    seed: int = 0
    shuffled: bool = False

    def mesh(self) -> Any:
        flat = self.shape in ("triangle", "quadrilateral")
        size = (0.03, 0.02) if flat else (0.03, 0.02, 0.02)
        cells = self.cells or ((3, 2) if flat else (2, 2, 2))
        mesh = Block(size=size, cells=cells, shape=self.shape).mesh()
        generator = np.random.default_rng(self.seed)
        edge = np.array(size) / np.array(cells)
        points = mesh.p + self.share * edge[:, None] * generator.uniform(-1.0, 1.0, mesh.p.shape)
        names = {name: mesh.facets[:, np.asarray(facets)] for name, facets in mesh.boundaries.items()}
        order = generator.permutation(mesh.nelements) if self.shuffled else np.arange(mesh.nelements)
        centres = mesh.p[0, mesh.t[:, order]].mean(axis=0)
        found = type(mesh)(points, mesh.t[:, order])
        place = {frozenset(nodes): k for k, nodes in enumerate(found.facets.T.tolist())}
        sides = {name: np.array([place[frozenset(row)] for row in rows.T.tolist()]) for name, rows in names.items()}
        sides["all"] = found.boundary_facets()
        return found.with_boundaries(sides).with_subdomains({"tendon": np.flatnonzero(centres > 0.02)})


def _held_at(solid: FiniteElement, place: Callable[[Array], Array]) -> FiniteElement:
    """The solid whose first support holds each of its nodes at ``X + place(X)``; supports of a scene move as one."""
    body = solid._body
    numbers = body.held.numbers[0]
    values = place(body.grid.positions).ravel()[numbers]
    held = attrs.evolve(body.held, numbers=[numbers], values=[values])
    return attrs.evolve(solid, shared=attrs.evolve(body, held=held))


def _equilibrium(solid: FiniteElement, law: Any = None, time: float = 0.0, start: Motion | None = None) -> Motion:
    """Equilibrium at one time, found in one step."""
    result = QuasiStatic().step(solid, law, start or solid.rest_motion(), {}, time - 1.0, 1.0)
    assert result.report.converged, result.report.reason
    return result.motion


def _corner(solid: FiniteElement, motion: Motion, place: tuple[float, ...], time: float = 0.0) -> Array:
    """Displacement [m] of the node at a reference position."""
    body = solid._body
    distance = np.linalg.norm(body.grid.positions - np.array(place), axis=1)
    node = int(distance.argmin())
    assert distance[node] < 1e-9, "there is no node"
    return body.displacement(motion.displacement, time).reshape(-1, len(place))[node]


@pytest.fixture(scope="session")
def distorted() -> type[Distorted]:
    """Mesh source with distorted cells of any shape."""
    return Distorted


@pytest.fixture(scope="session")
def held_at() -> Callable[..., FiniteElement]:
    """Holds a boundary at the places that a function of the reference position gives."""
    return _held_at


@pytest.fixture(scope="session")
def equilibrium() -> Callable[..., Motion]:
    """Equilibrium of a solid under a law at a time."""
    return _equilibrium


@pytest.fixture(scope="session")
def displacement_at() -> Callable[..., Array]:
    """Displacement of the node at a place."""
    return _corner
