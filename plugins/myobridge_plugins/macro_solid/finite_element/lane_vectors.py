"""Vectors of all lanes of a row, each one value of compiled code.

A loop over lanes becomes vector instructions only where the compiler can tell that no array overlaps another, asks so
each time, and loads again after a store what it had. A vector stays in its register. Where registers are narrower than
a row, the compiler takes several.

Lanes without a cell are worked on like the others: nobody reads them. What is called with many fixed numbers of rows is
made of instructions here, because a function would be compiled anew for each number.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from myobridge.compiled import INLINED, LANES

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

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_WIDTH = 8 * LANES


class _Lanes(types.Type):
    def __init__(self) -> None:
        super().__init__(name="Lanes")


_LANES = _Lanes()


@register_model(_Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Any) -> None:
        super().__init__(manager, lanes, _VECTOR)


def _spread(builder: Any, number: Any) -> Any:
    if number.type == _VECTOR:
        return number
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(nothing, number, ir.IntType(32)(0))
    return builder.shuffle_vector(one, nothing, ir.VectorType(ir.IntType(32), LANES)([0] * LANES))


def _teach(operation: Any, instruction: str) -> None:
    """Let an operator take two vectors, or a vector and a number."""
    pairs = [(_LANES, _LANES), (_LANES, types.float64), (types.float64, _LANES)]
    known: Any = infer_global
    known(operation)(
        type(f"_{instruction}", (ConcreteTemplate,), {"cases": [signature(_LANES, *pair) for pair in pairs]})
    )

    def lowered(_context: Any, builder: Any, _types: Any, both: Any) -> Any:
        return getattr(builder, instruction)(*(_spread(builder, one) for one in both))

    for pair in pairs:
        lower_builtin(operation, *pair)(lowered)


_teach(operator.add, "fadd")
_teach(operator.sub, "fsub")
_teach(operator.mul, "fmul")
_teach(operator.truediv, "fdiv")


def _call(name: str, builder: Any, *given: Any) -> Any:
    function = ir.FunctionType(_VECTOR, [_VECTOR] * len(given))
    mangled = f"llvm.{name}.v{LANES}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, function, mangled), given)


def _read(builder: Any, place: Any) -> Any:
    found = builder.load(place)
    found.align = 8
    return found


def _place(context: Any, builder: Any, array_type: Any, array: Any, row: Any) -> Any:
    data = context.make_array(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [builder.mul(row, row.type(LANES))]), _VECTOR.as_pointer())


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
    return signature(_LANES, types.float64), lambda _context, builder, _types, given: _spread(builder, given[0])


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
