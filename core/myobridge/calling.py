"""Compiled calls through a pointer, for tests of compiled functions and material points."""

from __future__ import annotations

from typing import Any

import numba
from numba import types

from myobridge.compiled import LANES, signature

__all__ = ["call", "call_in_batches"]

_FLAT = types.Array(types.float64, 1, "C")
_BATCHES = types.Array(types.float64, 2, "C")


@numba.njit(types.void(types.FunctionType(signature()), types.intp, _FLAT, _FLAT, _FLAT), cache=True)
def call(pointer: Any, n: int, state: Any, out: Any, constants: Any) -> None:
    """Run the function behind `pointer`."""
    pointer(n, state, out, constants)


@numba.njit(types.void(types.FunctionType(signature()), types.intp, _BATCHES, _BATCHES, _FLAT), cache=True)
def call_in_batches(pointer: Any, n_points: int, state: Any, out: Any, constants: Any) -> None:
    """Run the function behind `pointer` on all points, a row of `state` and `out` for each batch."""
    for batch in range(len(state)):
        pointer(min(LANES, n_points - batch * LANES), state[batch], out[batch], constants)
