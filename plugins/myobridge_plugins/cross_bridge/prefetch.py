"""Hint for the processor: a state row that is needed soon comes from memory while the row before it is computed."""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
import numba as nb
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from myobridge_plugins.cross_bridge.window_layout import PART

__all__ = ["fetch"]


@intrinsic
def _prefetch(typing_context: Any, row: Any, place: Any) -> Any:
    """Ask for the cache line that holds `row[place]`; `place` is within the row."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        line = builder.bitcast(builder.gep(array.data, [arguments[1]]), cgutils.voidptr_t)
        flag = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, flag, flag, flag])
        hint = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(hint, [line, flag(0), flag(3), flag(1)])  # to read, into the nearest cache, data
        return context.get_dummy_value()

    return types.void(row, types.intp), generate


@nb.njit(**PART)
def fetch(row, start, stop):
    """Ask for the cache lines of `row[start:stop]`."""
    for i in range(start, stop, 8):
        _prefetch(row, i)  # pyright: ignore[reportCallIssue]  # numba supplies the first argument
