"""Rows of the atlas: cases with their variants, and the cells in them; chosen by patterns."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping, Sequence
from fnmatch import fnmatchcase

from myobridge.atlas.catalogue import QUANTITIES
from myobridge.atlas.cell import Cell
from myobridge.atlas.methods import methods_of
from myobridge.errors import MyobridgeError, PluginError, nearest
from myobridge.interfaces import StabilityCase
from myobridge.registry import PluginWarning, registry
from myobridge.scene import Scene

__all__ = ["cells_of", "chosen"]


def cells_of(
    name: str,
    case: StabilityCase,
    *,
    full: bool = False,
    variants: Collection[str] | None = None,
    everything: bool = False,
) -> list[Cell]:
    """Cells of a case: every variant with every method, as far as the quick or the full atlas has them.

    Parameters
    ----------
    full : bool
        Whether the atlas is the full one.
    variants : collection of str, optional
        Variants asked for; all without.
    everything : bool
        Also methods that the quick atlas leaves out.

    Raises
    ------
    PluginError
        If the case's data are wrong.
    """
    _check(name, case)
    found: list[Cell] = []
    for variant, settings in case.variants.items():
        if variants is not None and variant not in variants:
            continue
        if not full and any(fnmatchcase(variant, pattern) for pattern in case.only_full):
            continue
        try:
            base = Scene.from_toml(case.scene, settings={**settings, **(case.longer if full else {})})
        except MyobridgeError as error:
            raise PluginError(f"stability case '{name}': {error}") from None
        cells = [Cell(name, case, variant, method, base, full) for method in methods_of(case, base, registry())]
        if not (full or everything) and any(fnmatchcase(variant, pattern) for pattern in case.default_only):
            cells = [cell for cell in cells if cell.expectation.outcome != "any"]
        found += cells
    return found


def _check(name: str, case: StabilityCase) -> None:
    for key in ("scene", "limits"):
        if not hasattr(case, key):
            raise PluginError(f"stability case '{name}': {type(case).__name__} has no '{key}'; every case needs one")
    known = set(QUANTITIES) if type(case).measured is StabilityCase.measured else None
    for limit in case.limits:
        if known is not None and limit.quantity not in known:
            raise PluginError(
                f"stability case '{name}': there is no quantity '{limit.quantity}'. {nearest(limit.quantity, known)}"
            )


def chosen(
    cases: Mapping[str, StabilityCase], case_patterns: Sequence[str], method_patterns: Sequence[str], *, full: bool
) -> list[Cell]:
    """Cells whose row and method match one of the patterns each; all without patterns.

    Raises
    ------
    MyobridgeError
        If a pattern matches nothing, and then the message suggests the nearest name; if a chosen case has wrong data.

    Warns
    -----
    PluginWarning
        Once for each case whose data are wrong, where all are tried; it is left out.
    """
    cells: list[Cell] = []
    for name, case in cases.items():
        if case_patterns and not _maybe(name, case, case_patterns):
            continue
        try:
            cells += cells_of(name, case, full=full, everything=bool(method_patterns))
        except PluginError as error:
            if case_patterns:
                raise
            warnings.warn(f"{error}. It is left out", PluginWarning, stacklevel=3)
    rows = sorted({row for name, case in cases.items() for row in _rows(name, case)})
    for pattern in case_patterns:
        _must_match("--case", pattern, any(_row_matches(cell, pattern) for cell in cells), {*rows, *cases})
    if case_patterns:
        cells = [cell for cell in cells if any(_row_matches(cell, pattern) for pattern in case_patterns)]
    names = {name for cell in cells for name in _names(cell)}
    for pattern in method_patterns:
        _must_match("--method", pattern, any(fnmatchcase(name, pattern) for name in names), names)
    if method_patterns:
        cells = [cell for cell in cells if any(fnmatchcase(n, p) for n in _names(cell) for p in method_patterns)]
    if not cells:
        raise MyobridgeError("no cell of the atlas matches the patterns of --case and --method together")
    return cells


def _rows(name: str, case: StabilityCase) -> Iterable[str]:
    return (f"{name}:{variant}" if variant else name for variant in case.variants)


def _maybe(name: str, case: StabilityCase, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(text, pattern) for text in (name, *_rows(name, case)) for pattern in patterns)


def _row_matches(cell: Cell, pattern: str) -> bool:
    return fnmatchcase(cell.name, pattern) or fnmatchcase(cell.row, pattern)


def _names(cell: Cell) -> tuple[str, ...]:
    return (cell.method.name, *cell.method.also)


def _must_match(option: str, pattern: str, matches: bool, names: Collection[str]) -> None:
    if not matches:
        raise MyobridgeError(f"{option} {pattern}: matches nothing. {nearest(pattern, names)}")
