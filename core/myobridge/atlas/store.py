"""Store: finished cells on disk, one line of JSON each, so that an atlas that was interrupted goes on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import final

from myobridge.atlas.cell import Finding
from myobridge.errors import MyobridgeError

__all__ = ["Store"]


@final
class Store:
    """Lines of a file; without a folder nothing is written.

    Parameters
    ----------
    folder : Path, optional
        Made if it is not there.
    resume : bool
        Whether what the file holds is kept; else it is begun anew.

    Raises
    ------
    MyobridgeError
        If the folder cannot be written to.
    """

    NAME = "cells.jsonl"

    def __init__(self, folder: Path | None, *, resume: bool) -> None:
        self.path = None if folder is None else folder / self.NAME
        self.known: dict[str, Finding] = {}
        if self.path is None:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if resume and self.path.exists():
                self._read()
            self.path.write_text("".join(map(_line, self.known.values())), encoding="utf-8")
        except OSError as error:
            raise MyobridgeError(f"{self.path}: cannot be written ({error.strerror})") from None

    def keep(self, finding: Finding) -> None:
        """Write a finding at once."""
        self.known[finding.key] = finding
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(_line(finding))

    def _read(self) -> None:
        assert self.path is not None
        for line in self.path.read_text(encoding="utf-8").splitlines():
            try:
                finding = Finding(**json.loads(line))
            except (ValueError, TypeError):  # the last line of a killed atlas, or one of another version
                continue
            self.known[finding.key] = finding


def _line(finding: Finding) -> str:
    return json.dumps(finding.as_data()) + "\n"
