"""Kept file: the result file of a run under way, complete at every moment, with or without time."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import final

from myobridge.results import Result, check_writable, provenance

__all__ = ["KeptFile"]


@final
class KeptFile:
    """File of a run; without a path nothing is written.

    Parameters
    ----------
    path : path, optional
        File to keep.
    scene : str
        TOML of the scene.
    plugins : mapping, optional
        Names of the plugins, for the provenance.
    folder : Path, optional
        Folder of the scene's files, for a later resume.

    Raises
    ------
    MyobridgeError
        If the file cannot be written: now, not after hours of computing.
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None,
        scene: str,
        plugins: Mapping[str, str] | None,
        folder: Path | None,
    ) -> None:
        self.path = None if path is None else check_writable(path)
        self.scene = scene
        self.provenance = provenance(plugins or {}) | {"folder": str((folder or Path()).resolve())}
        self._written = self._saving = 0.0

    def begin(self) -> None:
        """The run begins now: the first file is due after a while."""
        self._written = time.perf_counter()

    def save_if_due(self, result: Callable[[], Result], every: float) -> None:
        """Write the result if the last file is older than `every` seconds, and than twenty times what it cost."""
        now = time.perf_counter()
        # A file costs at most a twentieth of the run, however large it has grown.
        if self.path is None or now - self._written <= max(every, 20.0 * self._saving):
            return
        result().save(self.path)
        self._written = time.perf_counter()
        self._saving = self._written - now

    def save(self, result: Result) -> Result:
        """Write the result, and hand it on."""
        if self.path is not None:
            result.save(self.path)
        return result
