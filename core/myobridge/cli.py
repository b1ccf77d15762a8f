"""Command line: ``myobridge run | explain | show | cost | stability | plugins``."""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from myobridge.cli_cost import add_cost
from myobridge.cli_stability import add_stability
from myobridge.errors import MyobridgeError, SceneError

__all__ = ["main"]

# Exit codes: bad input, and the shell's own for Ctrl-C and SIGTERM.
_BAD_INPUT = 2
_INTERRUPTED = 130
_TERMINATED = 143


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit code: 0, 1 (the simulation failed), 2 (bad input), 130 (Ctrl-C), 143 (SIGTERM)."""
    from myobridge.errors import ContinuationFailed, StepFailed
    from myobridge.interrupts import Terminated

    options = _parser().parse_args(_with_view_joined(sys.argv[1:] if arguments is None else arguments))
    try:
        return options.command(options)
    except (StepFailed, ContinuationFailed) as error:
        print(f"myobridge: {error}", file=sys.stderr)
        return 1
    except MyobridgeError as error:
        print(f"myobridge: {error}", file=sys.stderr)
        return _BAD_INPUT
    except Terminated:
        print("myobridge: terminated; continue with --resume", file=sys.stderr)
        return _TERMINATED
    except KeyboardInterrupt:
        print("myobridge: interrupted; continue a run with --resume", file=sys.stderr)
        return _INTERRUPTED
    except MemoryError as error:
        print(f"myobridge: not enough memory: {error}; use fewer sites, bins or recorded rows", file=sys.stderr)
        return _BAD_INPUT
    except OSError as error:
        print(f"myobridge: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return _BAD_INPUT


def _with_view_joined(arguments: Sequence[str]) -> list[str]:
    """``--view -60,22`` as ``--view=-60,22``: argparse takes the minus for an option."""
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1] == "--view":
            joined[-1] = f"--view={argument}"
        else:
            joined.append(argument)
    return joined


def _parser() -> argparse.ArgumentParser:
    import myobridge

    parser = argparse.ArgumentParser(prog="myobridge", description="Multi-scale muscle simulation.")
    parser.add_argument("--version", action="version", version=f"myobridge {myobridge.__version__}")
    verbs = parser.add_subparsers(required=True, metavar="run | explain | show | cost | stability | plugins")

    run = verbs.add_parser("run", help="run a scene, or continue a result")
    run.add_argument("scene", nargs="?", type=Path, help="scene file (TOML)")
    run.add_argument("-o", "--output", type=Path, help="result file (default: the scene's name with .h5)")
    run.add_argument("--resume", type=Path, metavar="FILE", help="continue a result file")
    run.add_argument("--until", type=float, metavar="T", help="stop at time T [s], to be resumed later")
    _add_settings(run)
    run.add_argument("-v", "--verbose", action="store_true", help="print every iteration of Newton's method")
    run.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors")
    run.set_defaults(command=_run)

    explain = verbs.add_parser("explain", help="print what a scene means, without running it")
    explain.add_argument("scene", type=Path, help="scene file (TOML)")
    _add_settings(explain)
    explain.set_defaults(command=_explain)

    show = verbs.add_parser("show", help="draw a result: its body where it has one, else curves over time")
    show.add_argument("file", type=Path, help="result file (HDF5)")
    show.add_argument("-o", "--output", type=Path, help="picture (default: the result's name with .png)")
    show.add_argument("--series", action="store_true", help="curves, also of a result with a body")
    show.add_argument("--field", default="", metavar="NAME", help="field that colours the body, such as tension")
    show.add_argument(
        "--states",
        default="",
        metavar="LIST",
        help="states of the body: a number of them, or 'first', 'last' and times",
    )
    show.add_argument("--cells", action="store_true", help="one colour a cell, not smoothed")
    edges = argparse.BooleanOptionalAction
    show.add_argument("--edges", action=edges, help="edges of the cells (default: where they are few)")
    show.add_argument("--view", default="-60,22", metavar="A,E", help="azimuth and elevation of the eye [degrees]")
    show.add_argument("--engine", default="auto", metavar="NAME", help="for bodies in space: pyvista or matplotlib")
    show.set_defaults(command=_show)

    add_cost(verbs)
    add_stability(verbs)

    plugins = verbs.add_parser("plugins", help="list what is installed")
    plugins.add_argument("--json", action="store_true", help="for programs")
    plugins.set_defaults(command=_plugins)
    return parser


def _add_settings(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a key of the scene, dotted: solid.stiffness=100 (repeatable)",
    )


def _settings(given: Sequence[str]) -> dict[str, Any]:
    """``--set`` values: TOML where they are TOML, words where not."""
    settings: dict[str, Any] = {}
    for item in given:
        key, equals, value = item.partition("=")
        if not equals or not key:
            raise SceneError(f"--set {item}: expected KEY=VALUE, for example solid.stiffness=100")
        try:
            settings[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            settings[key.strip()] = value.strip()
    return settings


def _run(options: argparse.Namespace) -> int:
    from myobridge.plan import Plan
    from myobridge.progress import follow
    from myobridge.run import resume, start
    from myobridge.scene import Scene
    from myobridge.static_progress import follow_path
    from myobridge.static_run import StaticRun

    if (options.scene is None) == (options.resume is None):
        raise SceneError("run: give a scene file, or --resume with a result file")
    if options.until is not None and not options.until > 0.0:
        raise SceneError(f"--until {options.until}: expected a time in (0, inf) [s]")
    settings = _settings(options.settings)
    if options.resume is not None:
        run, scene = resume(options.resume, options.output, settings)
        plan = Plan.of(scene)
    else:
        scene = Scene.load(options.scene, settings)
        plan = Plan.of(scene)
        run = start(plan, options.output or Path(options.scene.stem + ".h5"))
    if isinstance(run, StaticRun) and options.until is not None:
        raise SceneError(f"--until {options.until:g}: the scene has no time; set continuation.to instead")
    with _iterations_printed(options.verbose):
        if isinstance(run, StaticRun):
            follow_path(run, plan, quiet=options.quiet)
        else:
            follow(run, plan, until=options.until, quiet=options.quiet)
    return 0


@contextlib.contextmanager
def _iterations_printed(wanted: bool) -> Iterator[None]:
    """Print what Newton's methods log, where wanted."""
    log = logging.getLogger("myobridge.newton")
    handler, level = logging.StreamHandler(sys.stdout), log.level
    handler.setFormatter(logging.Formatter("  newton: %(message)s"))
    if wanted:
        log.addHandler(handler)
        log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


def _explain(options: argparse.Namespace) -> int:
    from rich.console import Console

    from myobridge.plan import Plan
    from myobridge.scene import Scene
    from myobridge.study.prediction import predicted
    from myobridge.tables import effects_table, settings_table, sizes_table

    plan = Plan.of(Scene.load(options.scene, _settings(options.settings)))
    # What does not go together is said here, not at the run; an equilibrium to start from would be a run of its own.
    plan.composed(begin=plan.scene.start != "equilibrium")
    console = Console()
    console.print(settings_table(plan))
    console.print(effects_table(plan))
    console.print(sizes_table(plan, predicted(plan)))
    return 0


def _show(options: argparse.Namespace) -> int:
    from myobridge.bodies import draw_body
    from myobridge.pictures import draw
    from myobridge.results import Result

    target = options.output or Path(options.file.stem + ".png")
    started = perf_counter()
    result = Result.load(options.file)
    asked = {key: value for key, value in vars(options).items() if key in ("field", "states") and value}
    if options.series and asked:
        raise MyobridgeError(
            f"show: --series draws curves, and --{next(iter(asked))} is for a body; drop one of the two"
        )
    if options.series or (result.mesh is None and not asked):
        draw(result, target)
    else:
        draw_body(
            result,
            target,
            field=options.field,
            states=options.states,
            per_cell=options.cells,
            edges=options.edges,
            view=_view(options.view),
            engine=options.engine,
        )
    print(f"wrote {target} ({perf_counter() - started:.1f} s)")
    return 0


def _view(given: str) -> tuple[float, float]:
    try:
        azimuth, elevation = (float(word) for word in given.split(","))
    except ValueError:
        raise MyobridgeError(f"--view {given}: expected azimuth and elevation [degrees], such as -60,22") from None
    return azimuth, elevation


def _plugins(options: argparse.Namespace) -> int:
    from rich.console import Console

    from myobridge.registry import registry
    from myobridge.tables import plugins_json, plugins_table

    if options.json:
        print(plugins_json(registry()))
    else:
        Console().print(plugins_table(registry()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
