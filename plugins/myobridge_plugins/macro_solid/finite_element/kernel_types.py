"""Types of the arrays that the kernels take: one signature a kernel, so that each is compiled once."""

from __future__ import annotations

from numba import types

from myobridge.compiled import signature

__all__ = ["CELLS", "INDEX", "LAW", "MATRIX", "PLACES", "TABLE", "TOUCHED", "VECTOR"]

VECTOR, MATRIX, CUBE = (types.Array(types.float64, n, "C") for n in (1, 2, 3))
INDEX, TABLE, TOUCHED = (types.Array(types.int32, n, "C") for n in (1, 2, 3))
PLACES = types.Array(types.int16, 3, "C")
LAW = types.FunctionType(signature())
CELLS = (INDEX, INDEX, TOUCHED, MATRIX, MATRIX, VECTOR, CUBE, CUBE)
"""sizes, starts, nodes, corners, fibre, weights, slopes, map_slopes."""
