"""Vectors of LANES numbers of a state row, see `vectors`: numbers of a zone or cells; nothing asks which are used."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import signature
from numba.extending import intrinsic

from myobridge_plugins.cross_bridge.window_layout import LANES
from myobridge_plugins.vectors import code_of, pointer_to, spread_over, vector_of

__all__ = ["above", "at_least", "floor_of", "give", "sum_of", "sum_where", "take", "where_positive"]

_VECTOR, _ROW = code_of(LANES), vector_of(LANES)
_NOTHING = ir.Constant(_VECTOR, None)
_ANY_ORDER = ("reassoc", "nsz")
_intrinsic: Any = intrinsic


def _sum(builder: Any, vector: Any) -> Any:
    kind = ir.FunctionType(ir.DoubleType(), [ir.DoubleType(), _VECTOR])
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.vector.reduce.fadd.v{LANES}f64")
    return builder.call(function, [ir.DoubleType()(0.0), vector], fastmath=_ANY_ORDER)


@_intrinsic
def take(_typing: Any, row: Any, place: Any) -> Any:
    """LANES numbers of a row, from a place on."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        return builder.load(pointer_to(context, builder, asked.args[0], given[0], given[1], LANES), align=8)

    del place
    return signature(_ROW, row, types.intp), lowered


@_intrinsic
def give(_typing: Any, row: Any, place: Any, numbers: Any) -> Any:
    """Write into a row, from a place on."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        builder.store(given[2], pointer_to(context, builder, asked.args[0], given[0], given[1], LANES), align=8)
        return context.get_dummy_value()

    del place, numbers
    return signature(types.void, row, types.intp, _ROW), lowered


@_intrinsic
def floor_of(_typing: Any, numbers: Any) -> Any:
    """The largest whole numbers that are not above."""

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.floor.v{LANES}f64"), given)

    del numbers
    return signature(_ROW, _ROW), lowered


@_intrinsic
def where_positive(_typing: Any, sign: Any, first: Any, second: Any) -> Any:
    """The first numbers where `sign` is positive, the second elsewhere."""

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", given[0], _NOTHING), given[1], given[2])

    del sign, first, second
    return signature(_ROW, *(_ROW,) * 3), lowered


@_intrinsic
def above(_typing: Any, numbers: Any, limit: Any) -> Any:
    """The numbers above a limit, zero in the place of others."""

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        over = builder.fcmp_ordered(">", given[0], spread_over(builder, given[1], LANES))
        return builder.select(over, given[0], _NOTHING)

    del numbers, limit
    return signature(_ROW, _ROW, types.float64), lowered


@_intrinsic
def at_least(_typing: Any, numbers: Any, limit: Any) -> Any:
    """The numbers, and the limit in the place of those below it."""

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        least = spread_over(builder, given[1], LANES)
        return builder.select(builder.fcmp_ordered(">", given[0], least), given[0], least)

    del numbers, limit
    return signature(_ROW, _ROW, types.float64), lowered


@_intrinsic
def sum_of(_typing: Any, numbers: Any) -> Any:
    """Sum of all places."""
    del numbers
    return signature(types.float64, _ROW), lambda _context, builder, _types, given: _sum(builder, given[0])


@_intrinsic
def sum_where(_typing: Any, numbers: Any, cells: Any, cell: Any) -> Any:
    """Sum of the places whose cell is the one asked for."""

    def lowered(_context: Any, builder: Any, _types: Any, given: Any) -> Any:
        mine = builder.fcmp_ordered("==", given[1], spread_over(builder, given[2], LANES))
        return _sum(builder, builder.select(mine, given[0], _NOTHING))

    del numbers, cells, cell
    return signature(types.float64, _ROW, _ROW, types.float64), lowered
