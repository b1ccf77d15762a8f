"""A compiled call through a pointer, for tests of compiled functions."""

from __future__ import annotations

from typing import Any

import numba
from numba import types

from myobridge.compiled import signature

__all__ = ["call"]

_FLAT = types.Array(types.float64, 1, "C")


@numba.njit(types.void(types.FunctionType(signature()), types.intp, _FLAT, _FLAT, _FLAT), cache=True)
def call(pointer: Any, n: int, state: Any, out: Any, constants: Any) -> None:
    """Run the function behind `pointer`."""
    pointer(n, state, out, constants)
