"""A finished row goes to memory past the caches: lines that are written whole need not be read first."""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
import numba as nb
from numba import types
from numba.extending import intrinsic

from myobridge.cache_lines import LINE
from myobridge_plugins.cross_bridge.window_layout import BARE, PART

__all__ = ["arrive", "stream"]


@intrinsic
def _stream_line(typing_context: Any, source: Any, target: Any, place: Any) -> Any:
    """Copy the cache line at `place` of `source` to the same place of `target`; both begin a line there."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        line = ir.VectorType(ir.DoubleType(), LINE)
        source, target = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in zip(signature.args[:2], arguments[:2], strict=True)
        )
        taken, given = (
            builder.bitcast(builder.gep(data, [arguments[2]]), line.as_pointer()) for data in (source, target)
        )
        stored = builder.store(builder.load(taken, align=8 * LINE), given, align=8 * LINE)
        stored.set_metadata("nontemporal", builder.module.add_metadata([ir.IntType(32)(1)]))
        return context.get_dummy_value()

    return types.void(source, target, types.intp), generate


@intrinsic
def _fence(typing_context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), generate


@nb.njit(**PART)
def stream(source, target):
    """Copy a row of whole lines."""
    for i in range(0, target.size, LINE):
        _stream_line(source, target, i)  # pyright: ignore[reportCallIssue]  # numba supplies the first argument


@nb.njit(**BARE)
def arrive():
    """Wait until all that was streamed is there for other threads."""
    _fence()  # pyright: ignore[reportCallIssue]
