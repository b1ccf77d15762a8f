"""Atlas: every hard case against every method that goes with it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import final

import attrs

from myobridge.atlas.cell import Cell, Finding
from myobridge.atlas.chart import Chart
from myobridge.atlas.pool import in_this_process, in_workers
from myobridge.atlas.rows import chosen
from myobridge.atlas.store import Store
from myobridge.errors import MyobridgeError
from myobridge.interfaces import StabilityCase
from myobridge.interrupts import postponed
from myobridge.registry import registry

__all__ = ["Atlas"]


@final
class Atlas:
    """Stability atlas of the installed cases and methods.

    Parameters
    ----------
    cases, methods : sequence of str
        Patterns of rows (``release_30``, ``bulk_modulus:*``) and of methods (``default``, ``bathe``); all without.
    full : bool
        Also the long variants, and the largest step that holds.
    extra : mapping, optional
        Cases that are not installed, by name; they run in this process only.

    Attributes
    ----------
    cells : tuple of Cell
        What is to be tried.

    Raises
    ------
    MyobridgeError
        If a pattern matches nothing, or a case's data are wrong.

    Examples
    --------
    >>> import myobridge as mb
    >>> atlas = mb.Atlas(cases=["staggering"], methods=["default"])
    >>> chart = atlas.run(workers=0)  # doctest: +SKIP
    >>> chart.surprises  # doctest: +SKIP
    ()
    """

    def __init__(
        self,
        cases: Sequence[str] = (),
        methods: Sequence[str] = (),
        *,
        full: bool = False,
        extra: Mapping[str, StabilityCase] | None = None,
    ) -> None:
        self.full = full
        self._extra = dict(extra or {})
        found: dict[str, StabilityCase] = {
            item.name: item.cls() for item in registry() if item.family == "stability_case"
        }
        for name in self._extra:
            if name in found:
                raise MyobridgeError(f"extra: a stability case '{name}' is installed already; choose another name")
        self.cases = found | self._extra
        self.cells: tuple[Cell, ...] = tuple(chosen(self.cases, cases, methods, full=full))

    def run(
        self,
        folder: str | os.PathLike[str] | None = None,
        *,
        resume: bool = False,
        workers: int | None = None,
        patience: float = 900.0,
        watch: Callable[[Finding, int], object] | None = None,
    ) -> Chart:
        """Try all cells.

        Parameters
        ----------
        folder : path, optional
            Where finished cells are kept, line by line.
        resume : bool
            Take over the cells that are kept there and depend on nothing that has changed.
        workers : int, optional
            Processes; as many as there are cores without. 0: in this process, unguarded.
        patience : float
            How much longer than the computing time that a case allows a cell may take in a worker [s]: for compilation,
            the reference run, and a machine that others use too.
        watch : callable, optional
            Told every new finding and how many cells are left.

        Raises
        ------
        KeyboardInterrupt
            When interrupted; finished cells are kept.
        """
        count = (os.cpu_count() or 1) if workers is None else workers
        unknown = sorted({cell.name for cell in self.cells} & set(self._extra))
        if count and unknown:
            raise MyobridgeError(
                f"workers: is {count}, but a worker knows installed cases only, not '{unknown[0]}'; set workers = 0"
            )
        store = Store(None if folder is None else Path(folder), resume=resume)
        keys = {cell.address: cell.key for cell in self.cells}
        left = [cell for cell in self.cells if keys[cell.address] not in store.known]
        with postponed() as interrupts:
            trying = in_workers(left, count, interrupts, patience) if count else in_this_process(left, interrupts)
            for number, finding in enumerate(trying, start=1):
                # Sources may have changed meanwhile: it stands for those with which the atlas began.
                finding = attrs.evolve(finding, key=keys[finding.address])
                store.keep(finding)
                if watch is not None:
                    watch(finding, len(left) - number)
        findings = tuple(store.known[keys[cell.address]] for cell in self.cells)
        names = dict.fromkeys(cell.name for cell in self.cells)
        return Chart(findings, {name: self.cases[name] for name in names}, self.full)
