"""One whole Newton iteration in space: against FElupe, and its growth with the number of unknowns.

Run with ``pytest -m benchmark -n 0 -s tests/benchmarks/test_finite_element_newton.py``; CPU time, one thread. The
picture of the growth is written to the file named by the environment variable MYOBRIDGE_GROWTH_PICTURE, if any.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytestmark = [pytest.mark.benchmark, pytest.mark.usefixtures("one_blas_thread")]

SCRIPT = Path(__file__).parent / "solids" / "cantilever.py"
CELLS = (14, 8, 8)  # 25 491 unknowns
PASSES = 2
GROWTH = (5, 6, 8, 10, 12, 14, 16)  # 7656 to 218 625 unknowns


def felupe_iteration(module: Any, ours: Any, solver: Any) -> Any:
    """The same iteration by `felupe.newtonraphson`; `solver` None is its default, scipy's spsolve."""
    felupe = module.felupe
    theirs = module.Solid(ours.solid._body.grid.mesh, 5)
    start = sys.modules["cantilever"].bent(theirs.places)
    held = {"left": felupe.Boundary(theirs.field[0], fx=0.0)}
    dof0, dof1 = felupe.dof.partition(theirs.field, held)
    options = {"dof0": dof0, "dof1": dof1, "ext0": felupe.dof.apply(theirs.field, held, dof0), "verbose": 0}
    if solver is not None:
        options["solver"] = solver

    rounds: list[float] = []

    def iterate() -> np.ndarray:
        # An iteration moves the fields; pypardiso keeps its factors as long as the matrix is the same to the last bit.
        rounds.append(1.0 + 1e-9 * len(rounds))
        theirs.field[0].values[:], theirs.field[1].values[:] = rounds[-1] * start, 0.0
        # Any residual is good enough: it stops after one iteration.
        found = felupe.newtonraphson(items=[theirs.body], x0=theirs.field, tol=1e300, maxiter=1, **options)
        return found.x[0].values - rounds[-1] * start

    return theirs, iterate


def compared(load: Any, in_turns: Any, names: tuple[str, ...], solver: Any, rounds: int) -> dict[str, float]:
    """CPU seconds of ours with each of our solvers, and of FElupe; the corrections agree."""
    module, cantilever = load("felupe_solid"), load("cantilever")
    blocks = {name: cantilever.Cantilever(CELLS, name) for name in names}
    first = blocks[names[0]]
    theirs, iterate = felupe_iteration(module, first, solver)
    corrections: dict[str, float] = {}

    def action(name: str, step: Any, places: Any) -> Any:
        def run() -> None:
            # The nodes are the same in another order: a sum over them is the same number.
            corrections[name] = float(np.sum(step() * np.cos(places)))

        return run

    actions = {name: action(name, block.iterate, block.places) for name, block in blocks.items()}
    first.solid.balance(first.motion, None, 0.0, tangent=True)  # compiles
    times = in_turns({**actions, theirs.name: action(theirs.name, iterate, theirs.places)}, rounds)
    print(f"\none Newton iteration, {first.n_unknowns} unknowns:", {k: f"{v:.2f} s" for k, v in times.items()})
    assert np.allclose(list(corrections.values()), corrections[theirs.name], rtol=1e-5), corrections
    return times


def test_felupe_with_its_default_solver(solid_module: Any, in_turns: Any) -> None:
    """SuperLU there, our choice without extras here; wanted: 6 times."""
    times = compared(solid_module, in_turns, ("amg_gmres", "superlu"), None, 1)
    mine, theirs = times["amg_gmres"], next(v for k, v in times.items() if "FElupe" in k)
    print(f"{theirs / mine:.1f} times (with superlu {theirs / times['superlu']:.1f})")
    assert theirs >= 6.0 * mine


def test_felupe_with_pardiso(solid_module: Any, in_turns: Any) -> None:
    """PARDISO there, ours with PARDISO and without; wanted: 1.5 times."""
    pypardiso = pytest.importorskip("pypardiso", reason="the extra [pardiso] is not installed")
    times = compared(solid_module, in_turns, ("pardiso", "amg_gmres"), pypardiso.spsolve, 4)
    theirs = next(v for k, v in times.items() if "FElupe" in k)
    print(f"{theirs / times['pardiso']:.2f} times with pardiso, {theirs / times['amg_gmres']:.2f} with amg_gmres")
    assert theirs >= 1.5 * times["pardiso"]


def run_alone(cells: int, solver: str) -> dict[str, float]:
    """One size in a fresh process, on one thread."""
    quiet = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    command = [sys.executable, str(SCRIPT), str(cells), solver]
    return json.loads(subprocess.check_output(command, env={**os.environ, **quiet}).splitlines()[-1])


def test_growth() -> None:
    """Assembly + solve by `amg_gmres`; wanted: at most N^1.2 from 6k to 200k unknowns, which fit in 8 GB."""
    # All sizes, and all again: what else runs meanwhile doubles a time.
    passes = [[run_alone(cells, "amg_gmres") for cells in GROWTH] for _ in range(PASSES)]
    found = [{key: min(run[key] for run in runs) for key in runs[0]} for runs in zip(*passes, strict=True)]
    n = np.array([run["unknowns"] for run in found])
    total = np.array([run["assembly"] + run["solve"] for run in found])
    exponent = float(np.polyfit(np.log(n), np.log(total), 1)[0])
    assembly = float(np.polyfit(np.log(n), np.log([run["assembly"] for run in found]), 1)[0])
    for run in found:
        print(
            f"\n{run['unknowns']} unknowns: assembly {run['assembly']:.3f} s, solve {run['solve']:.2f} s, "
            f"{run['iterations']} iterations, peak {run['memory'] / 1e9:.2f} GB",
            end="",
        )
    print(f"\none Newton iteration grows as N^{exponent:.2f}, assembly as N^{assembly:.2f}")
    if picture := os.environ.get("MYOBRIDGE_GROWTH_PICTURE"):
        draw(found, exponent, Path(picture))
    assert n[-1] >= 200_000
    assert exponent <= 1.2
    assert found[-1]["memory"] <= 8e9


def draw(found: list[dict[str, float]], exponent: float, file: Path) -> None:
    """Time against unknowns, both logarithmic, with the fitted slope and the slope 1."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2, 3.8), layout="constrained")
    axes = figure.add_subplot()
    n = np.array([run["unknowns"] for run in found])
    total = np.array([run["assembly"] + run["solve"] for run in found])
    axes.loglog(n, total, "o-", label=f"one Newton iteration, amg_gmres: $N^{{{exponent:.2f}}}$")
    axes.loglog(n, [run["assembly"] for run in found], "s-", label="of this: residual and tangent")
    axes.loglog(n, total[0] * (n / n[0]), "k:", linewidth=1, label="$N$")
    axes.loglog(n, total[0] * (n / n[0]) ** 1.2, "k--", linewidth=1, label="$N^{1.2}$")
    axes.set_xlabel("unknowns (P2-P1 tetrahedra, incompressible)")
    axes.set_ylabel("CPU time [s], one thread")
    axes.grid(which="both", alpha=0.2)
    axes.set_ylim(top=8.0 * total.max())
    axes.legend(frameon=False, loc="upper left")
    FigureCanvasAgg(figure).print_png(str(file))
