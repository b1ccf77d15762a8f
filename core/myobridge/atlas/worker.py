"""Worker: a process that tries cells, one line of JSON in, one out; when it dies, a cell has failed and no more."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from myobridge.atlas.cell import Finding
from myobridge.atlas.judgement import found
from myobridge.atlas.rows import cells_of
from myobridge.registry import registry

__all__ = ["main"]


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Finding of the cell that a request names, as plain data."""
    case = registry().find("stability_case", request["case"]).cls
    cells = cells_of(request["case"], case(), full=request["full"], variants=(request["variant"],), everything=True)
    cell = next(cell for cell in cells if cell.address == request["address"])
    try:
        return found(cell).as_data()
    except Exception as error:  # a plugin's code may raise anything; here that is a finding about it
        return Finding.of(cell, "fails", why=f"{type(error).__name__}: {error}").as_data()


def main() -> None:
    """Answer requests until there are none."""
    # What plugins print must not get between the answers.
    channel = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    registry()  # loaded before the first cell, whose time is counted
    for line in sys.stdin:
        channel.write("begun\n")
        channel.flush()
        channel.write(json.dumps(answer(json.loads(line))) + "\n")
        channel.flush()


if __name__ == "__main__":
    main()
