"""What benchmarks share: peers that may be absent, and times taken in turns."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from time import process_time
from types import ModuleType
from typing import Any

import numpy as np
import pytest

SOLIDS = Path(__file__).with_name("solids")


@pytest.fixture
def solid_module() -> Callable[[str], ModuleType]:
    """A module of the folder `solids`; the test is skipped where its package is not installed."""

    def load(name: str) -> ModuleType:
        if name in sys.modules:
            return sys.modules[name]
        specification = importlib.util.spec_from_file_location(name, SOLIDS / f"{name}.py")
        assert specification is not None
        assert specification.loader is not None
        module = importlib.util.module_from_spec(specification)
        try:
            specification.loader.exec_module(module)
        except ModuleNotFoundError as missing:
            pytest.skip(f"the peer's package {missing.name} is not installed")
        sys.modules[name] = module
        return module

    return load


@pytest.fixture
def in_turns() -> Callable[..., dict[str, float]]:
    """Shortest times of several actions, taken in turns so that whatever else runs slows all of them.

    The clock is the CPU time of this process; an action that returns a number of seconds is taken at its word.
    """

    def measure(
        actions: Mapping[str, Callable[[], Any]], rounds: int, clock: Callable[[], float] = process_time
    ) -> dict[str, float]:
        found = dict.fromkeys(actions, np.inf)
        for _ in range(rounds):
            for name, action in actions.items():
                started = clock()
                told = action()
                spent = told if isinstance(told, float) else clock() - started
                found[name] = min(found[name], spent)
        return found

    return measure


@pytest.fixture
def one_blas_thread() -> Any:
    """BLAS on one thread, as our kernels are."""
    control = pytest.importorskip("threadpoolctl", reason="threadpoolctl pins the threads of BLAS")
    with control.threadpool_limits(1):
        yield
