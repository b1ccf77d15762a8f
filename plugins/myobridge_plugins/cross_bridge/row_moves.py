"""Moves within and between state rows in whole vectors.

The compiler copies entry by entry where it cannot tell that two rows, or the places of one row, do not overlap. Here
all that a vector needs is read before it is written.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import llvmlite.ir as ir
import numba as nb
from numba import types
from numba.extending import intrinsic

from myobridge.cache_lines import LINE
from myobridge_plugins.cross_bridge.window_layout import BARE, LANES, PART
from myobridge_plugins.vectors import code_of, pointer_to, spread_over

__all__ = ["arrive", "clear_lines", "close_gap", "copy_lines", "make_room", "stream_lines"]

_PLACE = ir.IntType(64)
_intrinsic: Any = intrinsic


def _line_copy(past: bool) -> Callable[..., Any]:
    """Code that copies the line at a place of one row to the same place of another."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source, target, place = arguments
        align = 8 * LINE if past else 8
        line = builder.load(pointer_to(context, builder, signature.args[0], source, place, LINE), align=align)
        stored = builder.store(line, pointer_to(context, builder, signature.args[1], target, place, LINE), align=align)
        if past:
            stored.set_metadata("nontemporal", builder.module.add_metadata([ir.IntType(32)(1)]))
        return context.get_dummy_value()

    return generate


@_intrinsic
def _copy_line(typing_context: Any, source: Any, target: Any, place: Any) -> Any:
    return types.void(source, target, types.intp), _line_copy(past=False)


@_intrinsic
def _stream_line(typing_context: Any, source: Any, target: Any, place: Any) -> Any:
    return types.void(source, target, types.intp), _line_copy(past=True)


@_intrinsic
def _clear_line(typing_context: Any, row: Any, place: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row, place = arguments
        line = pointer_to(context, builder, signature.args[0], row, place, LINE)
        builder.store(ir.Constant(code_of(LINE), None), line, align=8)
        return context.get_dummy_value()

    return types.void(row, types.intp), generate


def _shift(relation: str, step: int) -> Callable[..., Any]:
    """Code that replaces those of LANES places `j` for which ``j relation k`` by those `step` further on."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        row, first, k = arguments
        kind, size = signature.args[0], ir.VectorType(_PLACE, LANES)
        here = pointer_to(context, builder, kind, row, first, LANES)
        there = pointer_to(context, builder, kind, row, builder.add(first, _PLACE(step)), LANES)
        moved = builder.icmp_signed(relation, ir.Constant(size, list(range(LANES))), spread_over(builder, k, LANES))
        stays, comes = builder.load(here, align=8), builder.load(there, align=8)
        builder.store(builder.select(moved, comes, stays), here, align=8)
        return context.get_dummy_value()

    return generate


@_intrinsic
def make_room(typing_context: Any, row: Any, first: Any, k: Any) -> Any:
    """Move the places after `k`, of the LANES that begin at `first`, one place up: place k + 1 holds k's number too."""
    return types.void(row, types.intp, types.intp), _shift(">", -1)


@_intrinsic
def close_gap(typing_context: Any, row: Any, first: Any, k: Any) -> Any:
    """Move the places after `k`, of the LANES that begin at `first`, one place down; the last one is left to say."""
    return types.void(row, types.intp, types.intp), _shift(">=", 1)


@nb.njit(**PART)
def copy_lines(source, target, first, last):
    """Copy the places from `first` to `last`, whole lines."""
    for i in range(first, last, LINE):
        _copy_line(source, target, i)


@nb.njit(**PART)
def stream_lines(source, target, first, last):
    """Copy whole lines, which begin cache lines, to memory past the caches: they need not be read before."""
    for i in range(first, last, LINE):
        _stream_line(source, target, i)


@nb.njit(**PART)
def clear_lines(row, first, last):
    """Set the places from `first` to `last` to zero, whole lines."""
    for i in range(first, last, LINE):
        _clear_line(row, i)


@_intrinsic
def _fence(typing_context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.void(), generate


@nb.njit(**BARE)
def arrive():
    """Wait until all that was streamed is there for other threads."""
    _fence()
