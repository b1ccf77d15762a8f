"""Factors that are kept against new ones in every iteration: CPU seconds a step, one thread, one run of both.

Run with ``pytest -m benchmark -n 0 -s tests/benchmarks/test_kept_factorisation.py``; each case runs in a process of its
own, kept and ordinary in turns. Both solve to 1e-8, and arrive at the same place.
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

pytestmark = pytest.mark.benchmark

SCRIPT = Path(__file__).parent / "solids" / "moving_block.py"
CASES = ("D0", "DA7", "S0", "S7")
SMALL, MIDDLE, LARGE = "8x5x5", "14x8x8", "23x13x13"  # 6 thousand, 25 491 and 103 thousand unknowns
TOLERANCE = 1e-8


def run(case: str, cells: str, steps: int, method: str, linear: str, file: Path) -> dict[str, Any]:
    """One case in a fresh process, on one thread."""
    quiet = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    table = f"plugin = '{method}'\ntolerance = {TOLERANCE}\nlinear = {linear}"
    command = [sys.executable, str(SCRIPT), case, cells, str(steps), "energy_momentum", table, str(file)]
    return json.loads(subprocess.check_output(command, env={**os.environ, **quiet}).splitlines()[-1])


def ratios(cells: str, steps: int, solver: str, single: bool, folder: Path) -> list[float]:
    """How many times less CPU a step takes, for every case; what was found is the same."""
    found = []
    for case in CASES:
        files = folder / f"{case}_kept.npy", folder / f"{case}_ordinary.npy"
        precision = "single" if single else "double"
        kept = run(case, cells, steps, "simplified", f"{{plugin='{solver}', precision='{precision}'}}", files[0])
        ordinary = run(case, cells, steps, "ordinary", f"{{plugin='{solver}'}}", files[1])
        ends = [np.load(file) for file in files]
        off = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1]).max()
        found.append(ordinary["seconds"] / kept["seconds"])
        print(
            f"\n{case}, {kept['unknowns']} unknowns, {solver}: {ordinary['seconds']:.2f} s a step with "
            f"{ordinary['factorisations']} factorisations in {steps} steps, kept {kept['seconds']:.2f} s with "
            f"{kept['factorisations']} and {kept['iterations']:.1f} solves a step: {found[-1]:.1f} times; "
            f"displacements differ by {off:.1e}",
            flush=True,
        )
        # The tolerance of a step, times the steps, and what moving bodies make of it.
        assert off <= 10.0 * steps * TOLERANCE
    print(f"geometric mean {mean(found):.1f}")
    return found


def mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values))))


@pytest.mark.parametrize(
    ("cells", "steps", "solver", "aim"),
    [(MIDDLE, 20, "pardiso", 7.0), (LARGE, 6, "pardiso", 15.0), (MIDDLE, 6, "superlu", 10.0)],
    ids=["26k pardiso", "106k pardiso", "26k superlu"],
)
def test_times_less(cells: str, steps: int, solver: str, aim: float, tmp_path: Path) -> None:
    if solver == "pardiso":
        pytest.importorskip("pypardiso", reason="the extra [pardiso] is not installed")
    assert mean(ratios(cells, steps, solver, True, tmp_path)) >= aim


def test_growth(tmp_path: Path) -> None:
    """Seconds a step with kept factors; wanted: N^1.5 or better, from 6k to 103k unknowns."""
    solver = "pardiso"
    pytest.importorskip("pypardiso", reason="the extra [pardiso] is not installed")
    for case in CASES:
        linear = f"{{plugin='{solver}', precision='single'}}"
        found = [run(case, cells, 6, "simplified", linear, tmp_path / "end.npy") for cells in (SMALL, MIDDLE, LARGE)]
        n, seconds = ([one[what] for one in found] for what in ("unknowns", "seconds"))
        rate = float(np.polyfit(np.log(n), np.log(seconds), 1)[0])
        print(f"\n{case}: {n} unknowns, {np.round(seconds, 2)} s a step, N^{rate:.2f}", flush=True)
        assert rate <= 1.5
