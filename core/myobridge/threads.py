"""Loops shared out among threads: compiled kernels that hold no lock, each on a part of a range.

numba's own parallel loops take three times as long to compile, and its pool must not be entered by two threads at once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

__all__ = ["available", "over_range", "shared_out"]

# Sites or nodes below which threads are not worth while.
_MANY = 4096


def available() -> int:
    """Threads that may run: numba's number, which NUMBA_NUM_THREADS and the process's affinity limit."""
    import numba

    config: Any = numba.config  # pyright: ignore[reportPrivateImportUsage]
    return int(config.NUMBA_NUM_THREADS)


def shared_out(threads: int, first: int, last: int, loop: Callable[[int, int], object]) -> None:
    """Run ``loop(a, b)`` on parts [a, b) that make up the range [first, last).

    Each thread, the caller among them, takes the next part when it is free: one that others hold up does less.
    """
    threads = min(threads, last - first)
    if threads <= 1:
        if last > first:
            loop(first, last)
        return
    parts = iter(_parts(threads, first, last))  # the iterator of a list hands no part out twice

    def take() -> None:
        try:
            for a, b in parts:
                loop(a, b)
        finally:
            for _ in parts:  # after an error or an interrupt nobody goes on
                pass

    others = [_pool().submit(take) for _ in range(threads - 1)]
    try:
        take()
    finally:
        # Also after an interrupt: what the others write into must not outlive this call unnoticed.
        for other in others:
            if not other.cancel():
                other.result()


def _parts(threads: int, first: int, last: int) -> list[tuple[int, int]]:
    """Parts of a range: each half of a thread's share of what is left, the last ones an eighth of its share of all."""
    parts, least = [], max((last - first) // (8 * threads), 1)
    while first < last:
        size = max((last - first) // (2 * threads), least)
        size = size if last - first - size >= least else last - first
        parts.append((first, first + size))
        first += size
    return parts


def over_range(n: int, part: Callable[[int, int], object]) -> None:
    """Run ``part(a, b)`` over parts [a, b) of the range [0, n) of sites or nodes, on all threads where `n` is large."""
    shared_out(available() if n >= _MANY else 1, 0, n, part)


@functools.lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=max(available() - 1, 1), thread_name_prefix="loop")
