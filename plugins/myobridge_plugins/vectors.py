"""Vectors of numbers, each one value of compiled code: it stays in its registers.

A loop becomes vector instructions only where the compiler can tell that no array overlaps another, and finds it worth
while. Where registers are narrower than a vector, the compiler takes several.
"""

from __future__ import annotations

import functools
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

__all__ = ["VectorType", "code_of", "pointer_to", "spread_over", "vector_of"]


class VectorType(types.Type):
    """Type of the vectors of so many numbers; made by `vector_of`."""

    def __init__(self, size: int) -> None:
        self.size = size
        super().__init__(name=f"Vector{size}")


def code_of(size: int) -> ir.VectorType:
    """What such a vector is to the compiler."""
    return ir.VectorType(ir.DoubleType(), size)


@register_model(VectorType)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, vector: Any) -> None:
        super().__init__(manager, vector, code_of(vector.size))


def spread_over(builder: Any, number: Any, size: int) -> Any:
    """Code of a number in all entries; of a vector: the vector."""
    if isinstance(number.type, ir.VectorType):
        return number
    nothing = ir.Constant(ir.VectorType(number.type, size), ir.Undefined)
    one = builder.insert_element(nothing, number, ir.IntType(32)(0))
    return builder.shuffle_vector(one, nothing, ir.VectorType(ir.IntType(32), size)([0] * size))


def pointer_to(context: Any, builder: Any, array_type: Any, array: Any, place: Any, size: int) -> Any:
    """Code of the address of `size` numbers of an array, from a place on."""
    address: Any = builder.gep(context.make_array(array_type)(context, builder, array).data, [place])
    return builder.bitcast(address, code_of(size).as_pointer())


@functools.cache
def vector_of(size: int) -> VectorType:
    """The type of vectors of `size` numbers, with ``+ - * /`` for two of them, or one and a number."""
    vector = VectorType(size)
    pairs = [(vector, vector), (vector, types.float64), (types.float64, vector)]
    for operation, instruction in (
        (operator.add, "fadd"),
        (operator.sub, "fsub"),
        (operator.mul, "fmul"),
        (operator.truediv, "fdiv"),
    ):
        known: Any = infer_global
        cases = [signature(vector, *pair) for pair in pairs]
        known(operation)(type(f"_{instruction}{size}", (ConcreteTemplate,), {"cases": cases}))

        def lowered(_context: Any, builder: Any, _types: Any, both: Any, instruction: str = instruction) -> Any:
            return getattr(builder, instruction)(*(spread_over(builder, one, size) for one in both))

        for pair in pairs:
            lower_builtin(operation, *pair)(lowered)
    return vector
