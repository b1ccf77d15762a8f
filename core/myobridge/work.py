"""Work: what a computation does, counted the same on every machine.

Solvers, assembly and the bus say what they do with one line each, ``count("factorisations")``. Nobody listens unless
`counted` is open, and then only in the context that opened it: two runs in two threads do not mix.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["WORK", "count", "counted"]

WORK = {
    "newton_iterations": "iterations of Newton's method",
    "factorisations": "matrices factored, dense ones of springs included",
    "inner_iterations": "iterations of linear solvers",
    "assembled_elements": "elements whose forces were summed up, once each time",
    "bin_steps": "values of the micro state that were stepped, once each time",
}
"""What is counted, in words."""

_COUNTS: ContextVar[dict[str, int] | None] = ContextVar("work", default=None)


def count(what: str, amount: int = 1) -> None:
    """Add to a count of `WORK`; nothing happens where nobody counts."""
    counts = _COUNTS.get()
    if counts is not None:
        counts[what] += int(amount)


@contextmanager
def counted() -> Iterator[dict[str, int]]:
    """Counts of what is done inside, by the names of `WORK`; they grow while it is open.

    A counter inside another one takes the work for itself, and hands it on when it is closed.
    """
    counts = dict.fromkeys(WORK, 0)
    outer = _COUNTS.get()
    token = _COUNTS.set(counts)
    try:
        yield counts
    finally:
        _COUNTS.reset(token)
        if outer is not None:
            for what, amount in counts.items():
                outer[what] += amount
