"""Where a key of a scene was written, for error messages."""

from __future__ import annotations

import re
from collections.abc import Sequence

import attrs

__all__ = ["Origin", "locate"]

# A table's header; a row of a nested list begins with a bracket too.
_HEADER = re.compile(r"\[{1,2}\s*([A-Za-z_\"'][^\[\],]*?)\s*\]{1,2}\s*(#.*)?$")


Word = tuple[str, int | None]
"""A name of a dotted key, and its index in a list of tables."""


@attrs.frozen
class Origin:
    """Where a scene comes from: the name of a file, its text, and the keys that were set on top."""

    source: str = ""
    written: str = ""
    settings: tuple[str, ...] = ()

    def of(self, key: str) -> str:
        """Where `key` was written, to be put before it: ``file:line: ``, ``file, --set ``, or nothing."""
        sought = _words(key)
        on_top = f"{self.source}, --set " if self.source else "--set "
        names = [_words(name) for name in self.settings]
        if any(len(name) <= len(sought) and _same(name, sought[: len(name)]) for name in names):
            return on_top
        found = locate(self.source, self.written, key)
        inside = any(len(name) > len(sought) and _same(name[: len(sought)], sought) for name in names)
        return on_top if inside and found == f"{self.source}: " else found


def locate(source: str, written: str, key: str) -> str:
    """Where `key` stands in a TOML text, as ``file:line: ``; the nearest enclosing table if it is not written.

    Parameters
    ----------
    source : str
        Name of the file; without, there is nothing to point at and the answer is empty.
    written : str
        Its text.
    key : str
        Dotted key, with indices where a list is meant (``scene.effects[1]``, ``load[0].boundary``).
    """
    if not source:
        return ""
    sought = _words(key)
    best, depth = 0, 0
    table: list[Word] = []
    counts: dict[str, int] = {}
    for line, text in enumerate(written.splitlines(), start=1):
        bare = text.strip()
        header = _HEADER.match(bare)
        if header:
            path = [name for name, _ in _words(header[1])]
            if bare.startswith("[["):  # one more entry of a list of tables
                counts[".".join(path)] = counts.get(".".join(path), 0) + 1
            ends = [".".join(path[: index + 1]) for index in range(len(path))]
            here = table = [
                (name, counts[end] - 1 if end in counts else None) for name, end in zip(path, ends, strict=True)
            ]
        elif "=" in bare and not bare.startswith("#"):
            here = [*table, *_words(bare.partition("=")[0])]
        else:
            continue
        shared = min(len(here), len(sought))
        # The first line of the longest key that leads to the one sought, or lies inside it.
        if _same(here[:shared], sought[:shared]) and shared > depth:
            best, depth = line, shared
    return f"{source}:{best}: " if best else f"{source}: "


def _words(key: str) -> list[Word]:
    """Names of a dotted key, each with its index where it has one."""
    found: list[Word] = []
    for part in key.split("."):
        name, bracket, index = part.strip().partition("[")
        number = index.partition("]")[0]
        found.append((name.strip("\"'"), int(number) if bracket and number.isdigit() else None))
    return found


def _same(left: Sequence[Word], right: Sequence[Word]) -> bool:
    """Whether two keys are the same as far as both say: a name without index stands for every entry."""
    return len(left) == len(right) and all(
        mine == yours and (at is None or there is None or at == there)
        for (mine, at), (yours, there) in zip(left, right, strict=True)
    )
