"""Pool: workers that try cells side by side, each in a process of its own, and are replaced when they hang or crash."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from time import perf_counter
from typing import IO, Any, final

from myobridge.atlas.cell import Cell, Finding
from myobridge.interrupts import Interrupts

__all__ = ["in_this_process", "in_workers"]

# Until a worker has imported what it needs [s].
_STARTS = 300.0
# In the full atlas a cell is tried at about this many steps.
_TRIALS = 16


def in_this_process(cells: Sequence[Cell], interrupts: Interrupts) -> Iterator[Finding]:
    """Try cells one after the other here, unguarded: one that hangs, hangs."""
    from myobridge.atlas.judgement import found

    for cell in cells:
        interrupts.check()
        try:
            yield found(cell)
        except Exception as error:  # as in a worker
            yield Finding.of(cell, "fails", why=f"{type(error).__name__}: {error}")


def in_workers(cells: Sequence[Cell], count: int, interrupts: Interrupts, patience: float) -> Iterator[Finding]:
    """Try cells in `count` processes; findings come as they are finished.

    A worker whose cell takes `patience` seconds longer than the cell may compute is ended.

    Raises
    ------
    KeyboardInterrupt
        When interrupted; the workers are stopped, and what they were at is lost.
    """
    waiting: queue.SimpleQueue[Cell] = queue.SimpleQueue()
    for cell in cells:
        waiting.put(cell)
    done: queue.SimpleQueue[Finding] = queue.SimpleQueue()
    slots = [_Slot(waiting, done, patience) for _ in range(min(count, len(cells)))]
    try:
        for slot in slots:
            slot.thread.start()
        for _ in cells:
            while True:
                interrupts.check()
                try:
                    finding = done.get(timeout=0.2)
                    break
                except queue.Empty:
                    if not any(slot.thread.is_alive() for slot in slots) and done.empty():
                        raise RuntimeError("all workers of the atlas have ended early") from None
            yield finding
    finally:
        for slot in slots:
            slot.stop()
        for slot in slots:
            slot.close()


@final
class _Slot:
    """A thread with a worker of its own."""

    def __init__(self, waiting: queue.SimpleQueue[Cell], done: queue.SimpleQueue[Finding], patience: float) -> None:
        self.waiting, self.done, self.patience = waiting, done, patience
        self.thread = threading.Thread(target=self._loop, daemon=True)
        self.process: subprocess.Popen[str] | None = None
        self.stopped = False
        self.said = 0  # bytes of the complaints about earlier cells
        self.complaints: IO[bytes] = tempfile.TemporaryFile("a+b")  # noqa: SIM115, as long as the slot

    def stop(self) -> None:
        """End the worker, whatever it is at."""
        self.stopped = True
        self._kill()

    def close(self) -> None:
        """Wait for the worker's end, and close what it was told and said."""
        if self.thread.ident is not None:
            self.thread.join()
        self._bury()
        self.complaints.close()

    def _bury(self) -> int:
        """Exit code of the worker, once it has ended; nothing of it is left open."""
        process, self.process = self.process, None
        if process is None:
            return 0
        code = process.wait()
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                if pipe is not None:
                    pipe.close()
        return code

    def _kill(self) -> None:
        process = self.process
        if process is not None:
            with contextlib.suppress(OSError):
                process.kill()

    def _loop(self) -> None:
        while not self.stopped:
            try:
                cell = self.waiting.get_nowait()
            except queue.Empty:
                break
            finding = self._tried(cell)
            if not self.stopped:
                self.done.put(finding)
        self._kill()

    def _tried(self, cell: Cell) -> Finding:
        started = perf_counter()
        allowed = cell.case.seconds * (_TRIALS if cell.full and cell.case.bisect else 1) + self.patience
        if self.process is not None and self.process.poll() is not None:
            self._bury()
        process = self.process = self.process or self._started()
        if self.stopped:  # while it was being started
            process.kill()
        self.said = os.fstat(self.complaints.fileno()).st_size
        # The first line says that the cell has begun, the second what was found.
        line = self._within(_STARTS, lambda: _asked(process, cell)) and self._within(allowed, lambda: _read(process))
        if line:
            return Finding(**json.loads(line))
        code = self._bury()
        late = perf_counter() - started >= allowed and code == -signal.SIGKILL
        why = f"did not end within {allowed:g} s" if late else f"the process died: {self._last_words(code)}"
        return Finding.of(cell, "fails", why=why, seconds=perf_counter() - started)

    def _within(self, seconds: float, read: Callable[[], str]) -> str:
        """What is read, or nothing where the worker had to be ended because it took too long."""
        timer = threading.Timer(seconds, self._kill)
        timer.start()
        try:
            return read()
        finally:
            timer.cancel()

    def _started(self) -> subprocess.Popen[str]:
        # One thread each: cells side by side make the better use of the machine. A group of its own, because Ctrl-C
        # in a terminal goes to every process there.
        alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        return subprocess.Popen(
            [sys.executable, "-m", "myobridge.atlas.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.complaints,
            text=True,
            encoding="utf-8",
            env={**os.environ, **alone, "NUMBA_NUM_THREADS": "1"},
            start_new_session=True,
        )

    def _last_words(self, code: int) -> str:
        self.complaints.seek(self.said)
        lines = self.complaints.read().decode(errors="replace").strip().splitlines()
        how = f"exit code {code}"
        if code < 0:
            with contextlib.suppress(ValueError):
                how = signal.Signals(-code).name
        return f"{how}{': ' + lines[-1] if lines else ''}"


def _asked(process: subprocess.Popen[str], cell: Cell) -> str:
    """First line of the answer of a worker; empty where it died."""
    request: dict[str, Any] = {
        "case": cell.name,
        "variant": cell.variant,
        "address": cell.address,
        "full": cell.full,
    }
    assert process.stdin is not None
    try:
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
    except (OSError, ValueError):  # a pipe that is closed
        return ""
    return _read(process)


def _read(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    try:
        return process.stdout.readline()
    except (OSError, ValueError):
        return ""
