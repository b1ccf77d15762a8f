"""Command line: ``myobridge cost``."""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from pathlib import Path
from typing import Any

import attrs

from myobridge.errors import SceneError

__all__ = ["add_cost"]

_TOLERANCE = 1e-2
_WIDTH = 140


def add_cost(verbs: Any) -> None:
    """Add the command to the verbs of the command line."""
    cost = verbs.add_parser(
        "cost", help="what accuracy costs: error against time, and the cheapest that is good enough"
    )
    cost.add_argument("file", type=Path, help="study or scene (TOML); of a scene a study is made")
    cost.add_argument(
        "--tolerance", type=float, metavar="T", help=f"relative error that is good enough (scene: {_TOLERANCE:g})"
    )
    cost.add_argument("-o", "--output", type=Path, metavar="DIR", help="folder (default: the file's name with .cost)")
    cost.add_argument("--workers", type=int, metavar="N", help="local processes (default: one a core; 0: none)")
    cost.add_argument("--scheduler", metavar="ADDRESS", help="dask scheduler that is running, tcp://host:8786")
    cost.add_argument("--repeats", type=int, metavar="N", help="timed runs of each variant (default: 3)")
    cost.add_argument("--effects", action="store_true", help="price list of the scene's effects instead")
    cost.add_argument("-q", "--quiet", action="store_true", help="print the recommendation only")
    cost.set_defaults(command=_cost)


def _cost(options: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.markup import escape

    from myobridge.study.following import followed
    from myobridge.study.tables import left_out_text, recommendation_text, reference_text, study_table

    output = options.output or Path(options.file.stem + ".cost")
    # A file has no width: labels of variants are not cut there.
    console = Console(width=None if sys.stdout.isatty() or "COLUMNS" in os.environ else _WIDTH)
    how = {"workers": options.workers, "scheduler": options.scheduler}
    if options.effects:
        return _effects(options, output, console, how)
    study = _study(options)
    shown = None if options.quiet else console
    result = followed(study.title, lambda watch: study.run(output, watch=watch, **how), shown)
    files = result.save(output)
    if not options.quiet:
        console.print(study_table(result, console.width))
        console.print(
            "*: on the Pareto front, <=: recommended; ratio: CPU time over its, round by round", highlight=False
        )
        for said in (reference_text(result), escape(left_out_text(result))):
            if said:
                console.print(said, highlight=False)
    console.print(recommendation_text(result, options.file), markup=False, highlight=False, soft_wrap=True)
    if not options.quiet:
        said = ", ".join(map(str, files))
        console.print(f"wrote {said}", markup=False, highlight=False, soft_wrap=True)
    return 0 if result.study.tolerance is None or result.recommend() else 1


def _study(options: argparse.Namespace) -> Any:
    """The study of the file, or that which a plain scene makes."""
    from myobridge.scene import Scene
    from myobridge.study import Study
    from myobridge.study.ladder import ladder

    changes: dict[str, Any] = {
        key: getattr(options, key) for key in ("tolerance", "repeats") if getattr(options, key) is not None
    }
    if _is_study(options.file):
        return attrs.evolve(Study.load(options.file), **changes)
    return ladder(Scene.load(options.file), changes.pop("tolerance", _TOLERANCE), **changes)


def _is_study(path: Path) -> bool:
    try:
        return "study" in tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise SceneError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: is not valid TOML: {error}") from None


def _effects(options: argparse.Namespace, output: Path, console: Any, how: dict[str, Any]) -> int:
    from myobridge.scene import Scene
    from myobridge.study.effects import price_effects
    from myobridge.study.following import followed
    from myobridge.study.tables import effects_price_table, not_priced_text

    if _is_study(options.file):
        raise SceneError(f"{options.file}: is a study; --effects asks for a scene")
    scene, how = Scene.load(options.file), {**how, "repeats": options.repeats or 3}
    shown = None if options.quiet else console
    result = followed(scene.name, lambda watch: price_effects(scene, output, watch=watch, **how), shown)
    console.print(effects_price_table(result))
    if not options.quiet:
        console.print(not_priced_text(result), style="dim", markup=False, highlight=False)
    return 0
