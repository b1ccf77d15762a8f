"""Ranges are shared out among threads: all of a range once, whoever is held up."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from myobridge import threads
from myobridge.threads import shared_out


def _of(loop: Callable[[list[int]], object]) -> Callable[[int, int], object]:
    return lambda a, b: loop(list(range(a, b)))


@given(n_threads=st.integers(1, 5), first=st.integers(0, 50), size=st.integers(0, 300))
def test_every_place_is_taken_once(n_threads, first, size):
    taken: list[int] = []
    shared_out(n_threads, first, first + size, _of(taken.extend))
    assert sorted(taken) == list(range(first, first + size))


def test_who_is_held_up_does_less():
    """One thread waits in its first part until all others are done: the rest does not wait for it."""
    parts: list[tuple[int, int]] = []
    rest_done, held = threading.Event(), threading.Lock()

    def loop(a: int, b: int) -> None:
        first = held.acquire(blocking=False)
        if first:
            assert rest_done.wait(20.0), "the others did not take what was left"
        parts.append((a, b))
        if sum(b - a for a, b in parts) == 1000 - 250:
            rest_done.set()

    shared_out(2, 0, 1000, loop)
    assert parts[-1] == (0, 250)
    assert len(parts) > 4


def test_after_an_error_nobody_goes_on():
    """The second part fails while the first is worked on: no third one is begun."""
    parts: list[int] = []
    held, failed = threading.Lock(), threading.Event()

    def loop(a: int, b: int) -> None:
        parts.append(a)
        if not held.acquire(blocking=False):
            failed.set()
            raise ValueError(a)
        assert failed.wait(20.0)
        time.sleep(0.2)  # the other has yet to say so

    with pytest.raises(ValueError, match="250"):
        shared_out(2, 0, 1000, loop)
    assert parts == [0, 250]


@pytest.mark.parametrize("where", [0, 999])
def test_an_error_reaches_the_caller_after_all_have_stopped(where):
    done: list[int] = []

    def loop(a: int, b: int) -> None:
        if a <= where < b:
            raise ValueError(where)
        done.append(a)

    with pytest.raises(ValueError, match=str(where)):
        shared_out(3, 0, 1000, loop)
    n_done = len(done)
    assert threads._pool().submit(lambda: len(done)).result() == n_done
