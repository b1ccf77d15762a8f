"""Vectors of all lanes of a row, see `vectors`.

Where loops over lanes did become vector instructions, the compiler asked each time whether arrays overlap, and loaded
again after a store what it had.

Lanes without a cell are worked on like the others: nobody reads them. What is called with many fixed numbers of rows is
made of instructions here, because a function would be compiled anew for each number.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.typing.templates import signature
from numba.extending import intrinsic

from myobridge.compiled import INLINED, LANES
from myobridge_plugins.vectors import code_of, pointer_to, spread_over, vector_of

__all__ = [
    "absolute",
    "add_to",
    "aligned",
    "inlined",
    "larger",
    "load",
    "product_with",
    "spread",
    "square_root",
    "store",
]

inlined: Any = njit(**INLINED)
"""Decorator of what is compiled into whoever calls it."""
_intrinsic: Any = intrinsic

_VECTOR, _LANES = code_of(LANES), vector_of(LANES)
_WIDTH = 8 * LANES


def _call(name: str, builder: Any, *given: Any) -> Any:
    function = ir.FunctionType(_VECTOR, [_VECTOR] * len(given))
    mangled = f"llvm.{name}.v{LANES}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, function, mangled), given)


def _read(builder: Any, place: Any) -> Any:
    found = builder.load(place)
    found.align = 8
    return found


def _place(context: Any, builder: Any, array_type: Any, array: Any, row: Any) -> Any:
    return pointer_to(context, builder, array_type, array, builder.mul(row, row.type(LANES)), LANES)


@_intrinsic
def load(_typing: Any, array: Any, row: Any) -> Any:
    """A row of a flat array."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        return _read(builder, _place(context, builder, asked.args[0], *given))

    del row
    return signature(_LANES, array, types.intp), lowered


@_intrinsic
def store(_typing: Any, array: Any, row: Any, vector: Any) -> Any:
    """Write a row of a flat array."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        builder.store(given[2], _place(context, builder, asked.args[0], *given[:2])).align = 8
        return context.get_dummy_value()

    del row, vector
    return signature(types.void, array, types.intp, _LANES), lowered


@_intrinsic
def add_to(_typing: Any, array: Any, row: Any, vector: Any) -> Any:
    """Add to a row of a flat array."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        place = _place(context, builder, asked.args[0], *given[:2])
        builder.store(builder.fadd(_read(builder, place), given[2]), place).align = 8
        return context.get_dummy_value()

    del row, vector
    return signature(types.void, array, types.intp, _LANES), lowered


@_intrinsic
def product_with(_typing: Any, vectors: Any, array: Any, i: Any, j: Any, k: Any) -> Any:
    """Scalar product of three vectors with the rows i, j and k of a flat array."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        found = None
        for number, row in enumerate(given[2:]):
            entry = _read(builder, _place(context, builder, asked.args[1], given[1], row))
            term = builder.fmul(builder.extract_value(given[0], number), entry)
            found = term if found is None else builder.fadd(found, term)
        return found

    del i, j, k
    return signature(_LANES, vectors, array, *(types.intp,) * 3), lowered


@_intrinsic
def spread(_typing: Any, number: Any) -> Any:
    """A number in all lanes."""
    del number

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        return spread_over(builder, given[0], LANES)

    return signature(_LANES, types.float64), lowered


@_intrinsic
def square_root(_typing: Any, vector: Any) -> Any:
    """Square root of every lane."""
    del vector
    return signature(_LANES, _LANES), lambda _context, builder, _types, given: _call("sqrt", builder, *given)


@_intrinsic
def absolute(_typing: Any, vector: Any) -> Any:
    """Absolute value of every lane."""
    del vector
    return signature(_LANES, _LANES), lambda _context, builder, _types, given: _call("fabs", builder, *given)


@_intrinsic
def larger(_typing: Any, first: Any, second: Any) -> Any:
    """The larger number of every lane; the second where one is not a number."""
    del first, second

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *given), *given)

    return signature(_LANES, _LANES, _LANES), lowered


@_intrinsic
def _address(_typing: Any, array: Any) -> Any:
    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        data = context.make_array(asked.args[0])(context, builder, given[0]).data
        return builder.ptrtoint(data, ir.IntType(64))

    return signature(types.intp, array), lowered


@inlined
def aligned(rows):
    """Scratch of some rows, each within one line of the cache."""
    space = np.empty((rows + 1) * LANES)
    start = (-_address(space) % _WIDTH) // 8
    return space[start : start + rows * LANES]
