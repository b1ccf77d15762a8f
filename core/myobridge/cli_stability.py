"""Command line: ``myobridge stability``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

__all__ = ["add_stability"]


def add_stability(verbs: Any) -> None:
    """Add the command to the verbs of the command line."""
    stability = verbs.add_parser("stability", help="try every method on every hard case: the stability atlas")
    stability.add_argument(
        "--case",
        action="extend",
        nargs="+",
        default=[],
        metavar="PATTERN",
        help="cases, such as release_30 or 'bulk_modulus:*' (default: all)",
    )
    stability.add_argument(
        "--method",
        action="extend",
        nargs="+",
        default=[],
        metavar="PATTERN",
        help="methods, such as default or 'generalised*' (default: all)",
    )
    stability.add_argument("--full", action="store_true", help="also long runs, and the largest step that holds")
    stability.add_argument(
        "-o", "--output", type=Path, default=Path("atlas"), metavar="DIR", help="folder for what is found"
    )
    stability.add_argument("--resume", action="store_true", help="go on with what the folder holds")
    stability.add_argument("--docs", type=Path, metavar="FILE", help="also write a page in Markdown, with its picture")
    stability.add_argument("--workers", type=int, metavar="N", help="processes (default: one a core; 0: none)")
    stability.add_argument("--list", action="store_true", help="list the cells and try none")
    stability.add_argument("-q", "--quiet", action="store_true", help="print surprises only")
    stability.set_defaults(command=_stability)


def _stability(options: argparse.Namespace) -> int:
    from rich.console import Console

    from myobridge.atlas import Atlas
    from myobridge.atlas.progress import followed
    from myobridge.atlas.table import chart_table, surprises_text

    atlas = Atlas(options.case, options.method, full=options.full)
    console = Console()
    if options.list:
        for cell in atlas.cells:
            console.print(cell.address, markup=False, highlight=False, soft_wrap=True)
        return 0
    shown = None if options.quiet else console
    chart = followed(atlas, options.output, resume=options.resume, workers=options.workers, console=shown)
    data = chart.save(options.output / "atlas.json")
    picture = chart.draw(options.output / "atlas.png")
    console.print(surprises_text(chart) if options.quiet else chart_table(chart))
    written = [data, picture]
    if options.docs is not None:
        written += chart.write_page(options.docs)
    if not options.quiet:
        console.print(f"wrote {', '.join(map(str, written))}", markup=False, highlight=False, soft_wrap=True)
    return 1 if chart.surprises else 0
