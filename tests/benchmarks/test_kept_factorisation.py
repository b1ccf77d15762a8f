"""Factors that are kept against new ones in every iteration: CPU seconds a step, one thread, one run of both.

Run with ``pytest -m benchmark -n 0 -s tests/benchmarks/test_kept_factorisation.py``; each case in a process of its own,
which solves the same steps in both ways. Both lower the residual by 1e-8.
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
SMALL, MIDDLE, LARGE = "8x5x5", "14x8x8", "23x13x13"  # 6 132, 25 491 and 105 306 unknowns


def run(case: str, cells: str, steps: int, every: int, solver: str) -> dict[str, Any]:
    """One case in a fresh process, on one thread."""
    quiet = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    linear = [f"plugin='{solver}'", f"plugin='{solver}'\nprecision='single'"]
    command = [sys.executable, str(SCRIPT), case, cells, str(steps), str(every), *linear]
    return json.loads(subprocess.check_output(command, env={**os.environ, **quiet}).splitlines()[-1])


@pytest.mark.parametrize(
    ("cells", "every", "solver", "aim"),
    [(MIDDLE, 5, "pardiso", 7.0), (LARGE, 10, "pardiso", 15.0), (MIDDLE, 10, "superlu", 10.0)],
    ids=["26k-pardiso", "105k-pardiso", "26k-superlu"],
)
def test_times_less(cells: str, every: int, solver: str, aim: float) -> None:
    """Geometric mean over the cases; 20 steps of each, all with kept factors."""
    if solver == "pardiso":
        pytest.importorskip("pypardiso", reason="the extra [pardiso] is not installed")
    ratios = []
    for case in CASES:
        found = run(case, cells, 20, every, solver)
        kept, ordinary = found["kept"], found["ordinary"]
        ratios.append(ordinary["seconds"] / kept["seconds"])
        print(
            f"\n{case}, {found['unknowns']} unknowns, {solver}: {ordinary['seconds']:.2f} s a step with "
            f"{np.mean(ordinary['iterations']):.1f} factorisations, kept {kept['seconds']:.2f} s with "
            f"{np.mean(kept['iterations']):.1f} solves and {kept['factorisations']} factorisations in 20 steps: "
            f"{ratios[-1]:.1f} times; changes of a step differ by {found['off']:.1e}",
            flush=True,
        )
        assert found["moved"] > 1e-3
        assert found["off"] <= 1e-6, "both residuals have fallen by 1e-8"
    mean = float(np.exp(np.mean(np.log(ratios))))
    print(f"geometric mean {mean:.1f}")
    assert mean >= aim


@pytest.mark.parametrize("case", CASES)
def test_growth(case: str) -> None:
    """Seconds a step with kept factors; wanted: N^1.5 or better, from 6k to 105k unknowns."""
    pytest.importorskip("pypardiso", reason="the extra [pardiso] is not installed")
    found = [run(case, cells, 20, 1000, "pardiso") for cells in (SMALL, MIDDLE, LARGE)]
    n, seconds = [one["unknowns"] for one in found], [one["kept"]["seconds"] for one in found]
    rate = float(np.polyfit(np.log(n), np.log(seconds), 1)[0])
    print(f"\n{case}: {n} unknowns, {np.round(seconds, 2)} s a step, N^{rate:.2f}", flush=True)
    assert rate <= 1.5
