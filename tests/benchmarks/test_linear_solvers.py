"""Linear solvers side by side: CPU seconds, memory, iterations; run with ``pytest -m benchmark -n 0 -s``."""

from __future__ import annotations

import resource
from time import process_time
from typing import Any

import numpy as np
import pytest

import myobridge as mb
from myobridge.interfaces import LinearSystem

pytestmark = pytest.mark.benchmark

# Dimension and cells along the short sides: 963 to 61 282 unknowns in space, 1 069 to 57 869 in the plane.
SIZES = ((3, 2), (3, 4), (3, 5), (3, 6), (3, 9), (2, 6), (2, 12), (2, 24), (2, 46))
# Beyond these sizes factors of SuperLU take minutes.
LARGEST = {2: 100_000, 3: 25_000}


def seconds(name: str, system: LinearSystem) -> tuple[float, int]:
    """CPU time of a factorisation and one solve to 1e-8, and iterations."""
    right = np.random.default_rng(0).standard_normal(system.n_unknowns)
    started = process_time()
    factors = mb.registry().find("linear_solver", name).cls().factorise(system)
    found = factors.solve(right, 1e-8)
    spent = process_time() - started
    assert np.linalg.norm(right - system.times(found)) <= 1e-8 * np.linalg.norm(right)
    return spent, factors.iterations


def test_which_solver_wins_at_which_size(elastic_block: Any) -> None:
    """The table behind `myobridge.solvers.choose`."""
    names = [
        name
        for name in mb.registry().names("linear_solver")
        if not mb.registry().find("linear_solver", name).cls().obstacle()
    ]
    found: dict[tuple[int, int], dict[str, float]] = {}
    for dimension, cells in SIZES:
        system = elastic_block(dimension=dimension, cells=cells, fibre=3e5)
        line, times = f"{dimension}D {system.n_unknowns:7d} unknowns:", {}
        for name in names:
            if name == "superlu" and system.n_unknowns > LARGEST[dimension]:
                continue
            times[name], iterations = seconds(name, system)
            line += f"  {name} {times[name]:.2f} s" + (f" ({iterations} iterations)" if iterations else "")
        found[dimension, system.n_unknowns] = times
        print(line + f"; peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.1f} GB", flush=True)
    # In the plane factors win throughout, in space iterations do once there are 19 thousand unknowns.
    plane = [times for (dimension, _), times in found.items() if dimension == 2 and "superlu" in times]
    assert all(times["superlu"] < times["amg_gmres"] for times in plane)
    large = next(times for (dimension, n), times in found.items() if dimension == 3 and n > 15_000)
    assert large["amg_gmres"] < large["superlu"]
