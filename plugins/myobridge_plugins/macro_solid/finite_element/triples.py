"""Three neighbours of a flat array as one value: what a block adds to a row of a sparse matrix."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import signature
from numba.extending import intrinsic

__all__ = ["add_three"]

_intrinsic: Any = intrinsic
_FOUR = ir.VectorType(ir.DoubleType(), 4)
_MASK = ir.VectorType(ir.IntType(1), 4)
_THREE = ir.Constant(_MASK, [1, 1, 1, 0])
_INT = ir.IntType(32)


@_intrinsic
def add_three(_typing: Any, array: Any, at: Any, x: Any, y: Any, z: Any) -> Any:
    """Add to entries `at`, ``at + 1`` and ``at + 2``; the fourth is neither read nor written."""

    def lowered(context: Any, builder: Any, asked: Any, given: Any) -> Any:
        data = context.make_array(asked.args[0])(context, builder, given[0]).data
        place = builder.bitcast(builder.gep(data, [given[1]]), _FOUR.as_pointer())
        zero = ir.Constant(_FOUR, [0.0] * 4)
        added = zero
        for lane, number in enumerate(given[2:]):
            added = builder.insert_element(added, number, _INT(lane))
        aligned = _INT(8)
        read = ir.FunctionType(_FOUR, [place.type, _INT, _MASK, _FOUR])
        write = ir.FunctionType(ir.VoidType(), [_FOUR, place.type, _INT, _MASK])
        found = builder.call(_known(builder, read, "llvm.masked.load.v4f64.p0"), [place, aligned, _THREE, zero])
        summed = builder.fadd(found, added)
        builder.call(_known(builder, write, "llvm.masked.store.v4f64.p0"), [summed, place, aligned, _THREE])
        return context.get_dummy_value()

    del at, x, y, z
    return signature(types.void, array, types.uint64, *(types.float64,) * 3), lowered


def _known(builder: Any, function: Any, name: str) -> Any:
    return cgutils.get_or_insert_function(builder.module, function, name)
