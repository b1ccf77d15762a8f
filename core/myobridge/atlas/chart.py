"""Chart: the finished atlas, as data, table, picture and page."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import attrs

from myobridge.atlas.catalogue import QUANTITIES
from myobridge.atlas.cell import Finding
from myobridge.errors import MyobridgeError
from myobridge.interfaces import Limit, StabilityCase

__all__ = ["FORMAT", "Chart"]

FORMAT = "myobridge stability atlas 1"
"""First entry of ``atlas.json``; the number grows when the layout changes."""


@attrs.frozen(eq=False)
class Chart:
    """Findings of an atlas.

    Attributes
    ----------
    findings : tuple of Finding
        In the order of the cells.
    cases : mapping
        The cases by name.
    full : bool
        Whether it is the full atlas.
    """

    findings: tuple[Finding, ...]
    cases: Mapping[str, StabilityCase]
    full: bool = False

    @property
    def surprises(self) -> tuple[Finding, ...]:
        """Findings that differ from what is expected: what must hold and fails, or the other way round."""
        return tuple(finding for finding in self.findings if finding.surprise)

    @property
    def rows(self) -> tuple[str, ...]:
        """Cases and their variants."""
        return tuple(dict.fromkeys(finding.row for finding in self.findings))

    @property
    def columns(self) -> tuple[tuple[str, str], ...]:
        """(axis, method) of all methods, the default first, then axis by axis."""
        found = dict.fromkeys((finding.axis, finding.method) for finding in self.findings)
        axes = list(dict.fromkeys(axis for axis, _ in found))
        return tuple(sorted(found, key=lambda column: axes.index(column[0])))

    def at(self, row: str, column: tuple[str, str]) -> Finding | None:
        """Finding in a cell; None where nothing was tried."""
        return self._by_place.get((row, *column))

    @property
    def _by_place(self) -> dict[tuple[str, str, str], Finding]:
        return {(finding.row, finding.axis, finding.method): finding for finding in self.findings}

    def counts(self) -> dict[str, int]:
        """Number of cells by outcome, and of surprises."""
        found = {"holds": 0, "fails": 0, "not applicable": 0}
        for finding in self.findings:
            found[finding.outcome] += 1
        return found | {"surprises": len(self.surprises)}

    # ------------------------------------------------------------------ data

    def as_data(self) -> dict[str, Any]:
        """Plain data, as in ``atlas.json``."""
        return {
            "format": FORMAT,
            "full": self.full,
            "versions": {name: metadata.version(name) for name in ("myobridge", "numpy", "scipy", "numba")},
            "quantities": {name: {"words": words, "unit": unit} for name, (words, unit) in QUANTITIES.items()},
            "cases": {
                name: {
                    "summary": case.summary,
                    "limits": [_limit(limit) for limit in case.limits],
                    "refused_with": case.refused_with,
                }
                for name, case in self.cases.items()
            },
            "cells": [finding.as_data() for finding in self.findings],
        }

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write ``atlas.json``.

        Raises
        ------
        MyobridgeError
            If it cannot be written.
        """
        target = Path(path)
        try:
            target.write_text(json.dumps(self.as_data(), indent=1) + "\n", encoding="utf-8")
        except OSError as error:
            raise MyobridgeError(f"{target}: cannot be written ({error.strerror})") from None
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Chart:
        """Read ``atlas.json``; cases that are no longer installed are left out of `cases`.

        Raises
        ------
        MyobridgeError
            If there is no such file, or it is no atlas.
        """
        from myobridge.registry import registry

        source = Path(path)
        try:
            data = json.loads(source.read_text(encoding="utf-8"))
            if data["format"] != FORMAT:
                raise ValueError(f"its format is '{data['format']}', expected '{FORMAT}'")
            findings = tuple(Finding(**cell) for cell in data["cells"])
        except OSError as error:
            raise MyobridgeError(f"{source}: cannot be read ({error.strerror})") from None
        except (ValueError, TypeError, KeyError) as error:
            raise MyobridgeError(f"{source}: is no stability atlas ({error})") from None
        installed = {item.name: item.cls for item in registry() if item.family == "stability_case"}
        cases = {name: installed[name]() for name in data["cases"] if name in installed}
        return cls(findings, cases, bool(data["full"]))

    # ------------------------------------------------------------------ looks

    def draw(self, path: str | os.PathLike[str]) -> Path:
        """Draw the heat map; the suffix says the format."""
        from myobridge.atlas.picture import draw_chart

        return draw_chart(self, path)

    def page(self, picture: str = "") -> str:
        """Page in Markdown; `picture` is the link to the heat map."""
        from myobridge.atlas.page import page

        return page(self, picture)

    def write_page(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the page, and its picture into the folder ``pictures`` beside it.

        Raises
        ------
        MyobridgeError
            If they cannot be written.
        """
        target = Path(path)
        picture = target.parent / "pictures" / f"{target.stem}.png"
        try:
            picture.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(self.page(f"pictures/{picture.name}"), encoding="utf-8")
        except OSError as error:
            raise MyobridgeError(f"{target}: cannot be written ({error.strerror})") from None
        return [target, self.draw(picture)]


def _limit(limit: Limit) -> dict[str, Any]:
    """Limit without its infinite ends, which JSON has not."""
    ends = {"at_most": limit.at_most, "at_least": limit.at_least}
    return {"quantity": limit.quantity} | {name: end for name, end in ends.items() if math.isfinite(end)}
