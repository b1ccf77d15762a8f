"""Where a key of a scene was written, for error messages."""

from __future__ import annotations

import re

import attrs

__all__ = ["Origin", "locate"]

# A table's header; a row of a nested list begins with a bracket too.
_HEADER = re.compile(r"\[{1,2}\s*([A-Za-z_\"'][^\[\],]*?)\s*\]{1,2}\s*(#.*)?$")


@attrs.frozen
class Origin:
    """Where a scene comes from: the name of a file, its text, and the keys that were set on top."""

    source: str = ""
    written: str = ""
    settings: tuple[str, ...] = ()

    def of(self, key: str) -> str:
        """Where `key` was written, to be put before it: ``file:line: ``, ``file, --set ``, or nothing."""
        plain = re.sub(r"\[\d+\]", "", key)
        on_top = f"{self.source}, --set " if self.source else "--set "
        if any(plain == name or plain.startswith(f"{name}.") for name in self.settings):
            return on_top
        found = locate(self.source, self.written, key)
        inside = any(name.startswith(f"{plain}.") for name in self.settings)
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
        Dotted key, with indices where a list is meant (``scene.effects[1]``).
    """
    if not source:
        return ""
    sought = [part.partition("[")[0] for part in key.split(".")]
    best, depth = 0, 0
    table: list[str] = []
    for line, text in enumerate(written.splitlines(), start=1):
        bare = text.strip()
        header = _HEADER.match(bare)
        if header:
            here = table = _words(header[1])
        elif "=" in bare and not bare.startswith("#"):
            here = [*table, *_words(bare.partition("=")[0])]
        else:
            continue
        shared = min(len(here), len(sought))
        # The first line of the longest key that leads to the one sought, or lies inside it.
        if here[:shared] == sought[:shared] and shared > depth:
            best, depth = line, shared
    return f"{source}:{best}: " if best else f"{source}: "


def _words(key: str) -> list[str]:
    return [word.strip().strip("\"'") for word in key.split(".")]
