"""Compiled functions that travel into kernels as pointers.

A kernel that takes another compiled function as an argument is compiled anew in every process, because numba's cache on
disk does not recognise it. A pointer to a function of a fixed signature is recognised: kernel and function are compiled
and cached apart, and a stranger's material runs in the very same kernel as ours.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

__all__ = ["FASTMATH", "INLINED", "LANES", "CompiledFunction", "material_function", "signature"]

LANES = 8
"""Points that a kernel works on side by side: one vector of 64 bytes."""

FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Sums may be reordered and contracted, so that lanes become vectors; infinities and NaN keep their meaning."""

INLINED: Any = {
    "error_model": "numpy",
    "fastmath": FASTMATH,
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Numba's options for what is compiled into the kernel that calls it; Python calls none of it."""


def signature() -> Any:
    """Numba type of a material function: (points, state, out, constants) -> nothing."""
    from numba import types

    flat = types.Array(types.float64, 1, "C")
    return types.void(types.intp, flat, flat, flat)


class CompiledFunction:
    """A function that is compiled when its address is first asked for, and cached on disk.

    Calling it runs the compiled function, for tests.
    """

    def __init__(self, function: Callable[..., None]) -> None:
        self.function = function
        self.__doc__ = function.__doc__
        self._callback: Any = None
        self._pointer: Any = None

    def _compile(self) -> Any:
        import numba

        if self._callback is None:
            self._callback = numba.cfunc(signature(), cache=True, error_model="numpy", fastmath=FASTMATH)(self.function)
        return self._callback

    @property
    def pointer(self) -> Any:
        """What a kernel takes: numba's first-class function of the fixed signature."""
        if self._pointer is None:
            self._pointer = _pointer(self._compile().address)
        return self._pointer

    def __call__(self, n: int, state: Any, out: Any, constants: Any) -> None:
        _caller()(self.pointer, n, state, out, constants)


def material_function(function: Callable[..., None]) -> CompiledFunction:
    """Decorator: a function ``(n, state, out, constants)`` of a material (see `myobridge.interfaces.material`)."""
    return CompiledFunction(function)


def _pointer(address: int) -> Any:
    from numba import types

    class Pointer(types.WrapperAddressProtocol):
        def __wrapper_address__(self) -> int:
            return address

        def signature(self) -> Any:
            return signature()

    return Pointer()


def _caller() -> Any:
    from myobridge.calling import call

    return call
