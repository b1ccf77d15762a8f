"""Arrays whose rows begin with a cache line, so that whole lines are read and written."""

from __future__ import annotations

import math

import numpy as np

from myobridge.interfaces import Array

__all__ = ["LINE", "begins_a_line", "rows_on_lines"]

LINE = 8
"""Numbers in a cache line."""


def rows_on_lines(shape: tuple[int, ...]) -> Array:
    """Array, not filled, whose first entry begins a cache line; so does every row if it is a multiple of `LINE`."""
    size = math.prod(shape)
    memory = np.empty(size + LINE - 1)
    first = -(memory.ctypes.data // memory.itemsize) % LINE
    return memory[first : first + size].reshape(shape)


def begins_a_line(array: Array) -> bool:
    """Whether the first entry of `array` begins a cache line."""
    return array.ctypes.data % (LINE * array.itemsize) == 0
