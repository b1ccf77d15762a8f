"""Ctrl-C and a request to terminate, put off until the step under way is whole."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["Interrupts", "Terminated", "postponed"]


class Terminated(KeyboardInterrupt):
    """The process was asked to terminate (SIGTERM)."""


class Interrupts:
    """What has arrived so far."""

    def __init__(self) -> None:
        self._arrived: type[KeyboardInterrupt] | None = None

    def note(self, number: int, frame: FrameType | None) -> None:
        """Signal handler: the first is put off; a second one does not wait."""
        kind = Terminated if number == signal.SIGTERM else KeyboardInterrupt
        if self._arrived is not None:
            raise kind
        self._arrived = kind

    def check(self) -> None:
        """Raise what has arrived; called between steps, where the state is whole."""
        if self._arrived is not None:
            raise self._arrived


@contextmanager
def postponed() -> Iterator[Interrupts]:
    """Put off Ctrl-C and SIGTERM to the next `check`; handlers that somebody else installed are left alone."""
    noted = Interrupts()
    standard = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    if threading.current_thread() is not threading.main_thread():  # only there does Python let handlers be set
        standard = {}
    replaced = {number: usual for number, usual in standard.items() if signal.getsignal(number) is usual}
    for number in replaced:
        signal.signal(number, noted.note)
    try:
        yield noted
    finally:
        for number, usual in replaced.items():
            signal.signal(number, usual)
