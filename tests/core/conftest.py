"""Small scenes, bodies that move as they are told, and the command line called in this process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, final

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.cli import main
from myobridge.interfaces import MacroSolid, Motion, VisibleMesh

CLAMP = """
[scene]
name = "clamp"
effects = ["cross_bridges"]
duration = 0.02
step = 1e-3
[solid]
plugin = "clamp"
sites = 2
path = { plugin = "ramp", initial = 1.0, final = 0.98, start = 0.005, end = 0.015 }
[cross_bridges]
plugin = "distributed_moment"
"""

SPRING = """
[scene]
name = "spring"
effects = ["cross_bridges", "inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 0.1
stiffness = 500.0
velocity = 0.05
[cross_bridges]
plugin = "liouville"
"""

CHAIN = """
[scene]
name = "chain"
effects = ["cross_bridges", "activation"]
duration = 0.02
step = 1e-3
[solid]
plugin = "chain"
springs = 4
length = 0.1
[cross_bridges]
plugin = "distributed_moment"
[activation]
plugin = "ramp"
initial = 0.2
final = 1.0
end = 0.01
"""

ROPE = """
[scene]
name = "rope"
effects = ["cross_bridges", "inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "rope"
elements = 2
modulus = 1e6
length = 0.1
mass = 0.01
stretch_at_start = 1.02
[cross_bridges]
plugin = "hill"
"""

PASSIVE = """
[scene]
name = "passive"
effects = ["inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 0.1
stiffness = 500.0
velocity = 0.05
"""


class Outcome(NamedTuple):
    """What a call of the command line gave."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session")
def scenes() -> Mapping[str, str]:
    """TOML of small scenes by name."""
    return {"clamp": CLAMP, "spring": SPRING, "chain": CHAIN, "rope": ROPE, "passive": PASSIVE}


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    """Write the text of a scene into a file of its own."""

    def to_file(text: str, name: str = "scene.toml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return to_file


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Outcome]:
    """Call ``myobridge ARGUMENTS`` in this process, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")  # tables are not folded

    def call(*arguments: object) -> Outcome:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        said = capsys.readouterr()
        return Outcome(code, said.out, said.err)

    return call


# Nodes of a cell as means of its corners, in VTK's order.
NODES: Mapping[str, list[str]] = {
    "triangle": ["0", "1", "2"],
    "triangle6": ["0", "1", "2", "01", "12", "20"],
    "quad": ["0", "1", "2", "3"],
    "quad9": ["0", "1", "2", "3", "01", "12", "23", "30", "0123"],
    "tetra": ["0", "1", "2", "3"],
    "tetra10": ["0", "1", "2", "3", "01", "12", "20", "03", "13", "23"],
    "hexahedron": list("01234567"),
    "hexahedron27": [
        *"01234567",
        *("01", "12", "23", "30", "45", "56", "67", "74", "04", "15", "26", "37"),
        *("0473", "1265", "0154", "3267", "0321", "4567", "01234567"),
    ],
}
SQUARE = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
CUBE = [*SQUARE, *((x, y, 2) for x, y, _ in SQUARE)]
CORNERS = {
    "triangle": [[SQUARE[0], SQUARE[1], SQUARE[2]], [SQUARE[0], SQUARE[2], SQUARE[3]]],
    "quad": [SQUARE],
    # Along the diagonal 0-6: six tetrahedra of positive volume.
    "tetra": [[CUBE[i] for i in (0, *pair, 6)] for pair in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))],
    "hexahedron": [CUBE],
}


def block(kind: str, counts: tuple[int, int, int], size: tuple[float, float, float]) -> VisibleMesh:
    """Block of `counts` times `size`, cut into cells of a `kind`; flat where the third count is 0."""
    ids: dict[tuple[float, ...], int] = {}
    cells = []
    for origin in np.ndindex(counts[0], counts[1], max(counts[2], 1)):
        for corners in CORNERS[kind.rstrip("0123456789")]:
            lattice = np.add(corners, 2 * np.array(origin))
            nodes = [tuple(lattice[[int(c) for c in name]].mean(axis=0).tolist()) for name in NODES[kind]]
            cells.append([ids.setdefault(node, len(ids)) for node in nodes])
    scale = np.array([length / (2.0 * max(count, 1)) for length, count in zip(size, counts, strict=True)])
    return VisibleMesh(np.array(list(ids)) * scale, np.array(cells), kind)


@final
@attrs.frozen(eq=False, kw_only=True)
class Bending(MacroSolid):
    """Body without unknowns that bends in time, as a quadratic map of volume ratio 1; two sites a cell."""

    mesh: VisibleMesh
    bend: float = 2.0
    empty_cells: int = 0

    inertia: ClassVar[bool] = False

    @property
    def n_unknowns(self) -> int:
        return 0

    @property
    def n_sites(self) -> int:
        return 2 * (len(self.mesh.cells) - self.empty_cells)

    @property
    def site_volumes(self) -> np.ndarray:
        return np.full(self.n_sites, 1e-6)

    def rest_motion(self) -> Motion:
        return Motion(np.empty(0), np.empty(0))

    def centres(self) -> np.ndarray:
        """Middle of each cell [m]."""
        return self.mesh.points[self.mesh.cells].mean(axis=1)

    def stretch(self, displacement: np.ndarray, time: float) -> np.ndarray:
        along = self.centres()[: self.n_sites // 2, 0]
        return 1.0 + 0.1 * time + time * np.stack([along - 0.001, along + 0.001], axis=1).ravel()

    def stretch_rate(self, displacement: np.ndarray, velocity: np.ndarray, time: float) -> np.ndarray:
        return self.stretch(displacement, 1.0) - 1.0

    def visible_mesh(self) -> VisibleMesh:
        return self.mesh

    def moved(self, points: np.ndarray, time: float) -> np.ndarray:
        """Where reference `points` are at `time`."""
        squares = points[:, 0] ** 2
        deep = np.ptp(self.mesh.points[:, 2]) > 0.0
        return points + self.bend * time * np.stack([0.0 * squares, squares, 0.5 * deep * squares], axis=1)

    def visible_fields(self, motion: Motion, time: float) -> Mapping[str, np.ndarray]:
        points = self.mesh.points
        fibre = np.tile([1.0, 0.0, 0.0], (len(self.mesh.cells), 1))
        return {
            "displacement": self.moved(points, time) - points,
            "pressure": 1e3 * (1.0 + time) * points[:, 1],
            "fibre": fibre,
            "J": np.ones(len(self.mesh.cells)),
        }

    def on_cells(self, values: np.ndarray) -> np.ndarray:
        return np.concatenate([values.reshape(-1, 2).mean(axis=1), np.full(self.empty_cells, np.nan)])


@pytest.fixture(scope="session")
def nodes_of() -> Mapping[str, list[list[int]]]:
    """Of each kind of cell, in VTK's order, the corners whose middle is each node."""
    return {kind: [[int(corner) for corner in name] for name in names] for kind, names in NODES.items()}


@pytest.fixture(scope="session")
def bending() -> Callable[..., Bending]:
    """Body of a kind of cells: ``bending("tetra10", counts=(4, 2, 2), size=(0.1, 0.02, 0.02), bend=2.0)``."""

    def make(kind: str, counts=None, size=None, mesh: VisibleMesh | None = None, **options: Any) -> Bending:
        deep = kind.startswith(("tetra", "hexahedron"))
        found = mesh or block(kind, counts or (4, 2, 2 if deep else 0), size or (0.1, 0.02, 0.02 if deep else 0.0))
        return Bending(mesh=found, **options)

    return make


@pytest.fixture(scope="session")
def moving(bending) -> Callable[..., mb.Run]:
    """Run of a bending body with cross-bridges, and of what acts on them, in Python; 20 steps of 50 ms to 1 s."""

    def make(
        kind: str,
        record: Mapping[str, Any] | None = None,
        output: Path | None = None,
        model: str | None = "hill",
        ramp: bool = True,
        **options: Any,
    ) -> mb.Run:
        find = mb.registry().find
        activation = find("signal", "ramp").cls(initial=0.2, final=1.0, end=0.5) if ramp and model else None
        simulation = mb.Simulation(
            solid=bending(kind, **options),
            integrator=find("time_integrator", "quasi_static").cls(),
            cross_bridges=None if model is None else find("cross_bridge", model).cls(),
            activation=activation,
            dt=0.05,
        )
        return mb.Run(simulation, mb.Record(**(record or {})), output=output)

    return make
