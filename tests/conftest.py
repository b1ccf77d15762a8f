"""Settings that all tests share, and the blocks of code in the documentation."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import HealthCheck, settings

# Deadlines are timings, and timings are benchmarks. Compiled kernels make the first example slow.
settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("default")

DOCS = Path(__file__).parents[1] / "docs"


class Block(NamedTuple):
    """A fenced block of a page: its language, text, the comment above it, and the file that its first line names."""

    language: str
    text: str
    comment: str
    line: int

    @property
    def file(self) -> str:
        """``# scene.toml`` as the first line makes the block the content of that file; empty without."""
        first = self.text.partition("\n")[0]
        named = re.fullmatch(r"# ([\w./-]+\.(?:toml|py|csv))", first)
        return named[1] if named else ""


def _blocks(page: Path) -> list[Block]:
    found: list[Block] = []
    comment, above, fence = "", "", ""
    inside: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        if fence:
            if line == "```":
                found.append(Block(fence, "\n".join(inside) + "\n", comment, number - len(inside)))
                fence, above = "", ""
            else:
                inside.append(line)
        elif line.startswith("```"):
            fence, inside = line[3:].strip() or "plain", []
            said = re.fullmatch(r"<!-- (.*) -->", above)
            comment = said[1] if said else ""
        elif line:
            above = line
    assert not fence, f"{page}: a block is not closed"
    return found


@pytest.fixture(scope="session")
def blocks() -> Callable[[str], list[Block]]:
    """Fenced blocks of a page of the documentation, named relative to ``docs``."""
    return lambda page: _blocks(DOCS / page)
