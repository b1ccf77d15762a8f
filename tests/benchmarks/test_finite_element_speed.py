"""Residual and tangent of an incompressible body, P2-P1 tetrahedra: ratios to peers in one run, one thread, CPU time.

All solve the same problem on the same mesh: neo-Hooke in the form mu/2 (I1 - 3) - mu ln J with p (J - 1), its
residual and its whole tangent at one state, as a Newton iteration asks for them, ready as sparse matrices. Ours carries
the terms of the fibres' tension along, which is zero here, and assembles the gradient of the constraint once where the
others assemble it twice. Run with ``pytest -m benchmark -n 0 -s tests/benchmarks/test_finite_element_speed.py``;
peers that are not installed are skipped: ``pip install felupe threadpoolctl pypardiso``, ``apt install
python3-dolfinx``.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytestmark = [pytest.mark.benchmark, pytest.mark.usefixtures("one_blas_thread")]

POINTS = {5: 14, 2: 4}


def cube(cells: int) -> Any:
    """Block of 2 x 1 x 1 of ``12 cells^3`` tetrahedra."""
    import skfem

    return skfem.MeshTet.init_tensor(*(np.linspace(0.0, a, int(a) * cells + 1) for a in (2.0, 1.0, 1.0)))


def displacement(x: np.ndarray) -> np.ndarray:
    return 0.05 * np.sin(x[:, [1, 2, 0]] * 2.0 + x)


def pressure(x: np.ndarray) -> np.ndarray:
    return 0.3 * np.cos(x @ [1.0, 2.0, 3.0])


def trial(x: np.ndarray) -> np.ndarray:
    return np.cos(x[:, [2, 0, 1]] * 3.0)


def ready(module: Any, cells: int, degree: int, **options: Any) -> Any:
    """A solid at the common state, run once."""
    solid = module.Solid(cube(cells), degree, **options)
    assert solid.points == POINTS[degree]
    solid.set(displacement, pressure)
    solid.sums()
    return solid


def compared(load: Callable[[str], Any], peer: str, cells: int, degree: int) -> tuple[Any, Any]:
    """Ours and a peer's, which agree on residual and tangent."""
    theirs = ready(load(peer), cells, degree)
    ours = ready(load("ours"), cells, degree)
    # FElupe gives the points of its rule of degree 2 with eight digits.
    found, expected = ours.probe(trial, pressure), theirs.probe(trial, pressure)
    assert np.allclose(found, expected, rtol=1e-6 if degree == 2 else 1e-10), (found, expected)
    return ours, theirs


def told(ours: float, theirs: float, name: str, n_cells: int, degree: int) -> float:
    ratio = theirs / ours
    print(
        f"\n{n_cells} tetrahedra, {POINTS[degree]} points, residual + tangent: myobridge {1e6 * ours / n_cells:.2f} us "
        f"an element, {name} {1e6 * theirs / n_cells:.1f} us: {ratio:.1f} times"
    )
    return ratio


@pytest.mark.parametrize(("cells", "degree", "wanted"), [(8, 5, 10.0), (13, 5, 10.0), (8, 2, 5.0), (13, 2, 5.0)])
def test_felupe(solid_module: Any, in_turns: Any, cells: int, degree: int, wanted: float) -> None:
    """FElupe: a solid body on mixed fields, default options, `assemble.vector` and `assemble.matrix`."""
    ours, theirs = compared(solid_module, "felupe_solid", cells, degree)
    times = in_turns({"ours": ours.sums, "theirs": theirs.sums}, 15)
    assert told(times["ours"], times["theirs"], theirs.name, ours.grid.n_cells, degree) >= wanted


@pytest.mark.parametrize("cells", [8, 13])
def test_scikit_fem(solid_module: Any, in_turns: Any, cells: int) -> None:
    """scikit-fem: two linear and two bilinear forms; wanted: 100 times."""
    ours, theirs = compared(solid_module, "scikit_fem_solid", cells, 5)
    times = in_turns({"ours": ours.sums, "theirs": theirs.sums}, 1)
    ours_alone = in_turns({"ours": ours.sums}, 5)["ours"]
    mine = min(times["ours"], ours_alone)
    assert told(mine, times["theirs"], theirs.name, ours.grid.n_cells, 5) >= 100.0


def dolfinx_python() -> str | None:
    """A Python that has DOLFINx: this one, or that of the system (Debian's python3-dolfinx)."""
    for python in (sys.executable, "/usr/bin/python3", shutil.which("python3")):
        if (
            python
            and subprocess.run([python, "-c", "import dolfinx"], capture_output=True, check=False).returncode == 0
        ):
            return python
    return None


@pytest.mark.parametrize("cells", [8, 13])
def test_dolfinx(solid_module: Any, in_turns: Any, cells: int) -> None:
    """DOLFINx, compiled with -O3 -march=native -ffast-math, in a process of its own, in turns; wanted: 8 times."""
    python = dolfinx_python()
    if python is None:
        pytest.skip("DOLFINx is not installed (apt install python3-dolfinx)")
    ours = ready(solid_module("ours"), cells, 5)
    script = str(Path(__file__).parent / "solids" / "dolfinx_solid.py")
    command = [python, script, str(cells), "5"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True) as peer:
        assert peer.stdin is not None
        assert peer.stdout is not None
        version, n_cells = peer.stdout.readline().split()
        assert int(n_cells) == ours.grid.n_cells

        def theirs() -> float:
            peer.stdin.write("\n")
            peer.stdin.flush()
            return float(peer.stdout.readline())

        times = in_turns({"ours": ours.sums, "theirs": theirs}, 25)
        peer.stdin.close()
    assert told(times["ours"], times["theirs"], f"DOLFINx {version}", ours.grid.n_cells, 5) >= 8.0


def test_two_threads(solid_module: Any, in_turns: Any) -> None:
    """Wall time; wanted: 1.6 times one thread. Repeat on a quiet machine: another process takes the second core."""
    one = ready(solid_module("ours"), 13, 5)
    assembly = one.assembly
    found = []
    for _ in range(8):

        def on(threads: int) -> None:
            assembly.threads = threads
            one.kernel()

        times = in_turns({"1": lambda: on(1), "2": lambda: on(2)}, 8, time.perf_counter)
        found.append(times["1"] / times["2"])
    print(f"\n{one.grid.n_cells} tetrahedra, 14 points, two threads: {', '.join(f'{x:.2f}' for x in found)} times")
    assert max(found) >= 1.6


def test_memory(solid_module: Any) -> None:
    """Bytes an element, data of the tangent included; stated in the documentation: at most 6.0 kB at 14 points."""
    for degree, most in ((5, 6.0e3), (2, 5.7e3)):
        for cells in (8, 13):
            solid = solid_module("ours").Solid(cube(cells), degree)
            each = solid.assembly.memory() / solid.grid.n_cells
            print(f"\n{solid.grid.n_cells} tetrahedra, {POINTS[degree]} points: {each / 1e3:.2f} kB an element")
            assert each <= most
