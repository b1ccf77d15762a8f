"""Figures: a canvas without display, the scene's name above it, and its file."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from myobridge.errors import MyobridgeError
from myobridge.results import Result

__all__ = ["new_figure", "save_figure", "title"]


def new_figure(width: float, height: float) -> Any:
    """Empty figure of matplotlib, in inches; no display is asked for, no global state is left behind."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Any, path: str | os.PathLike[str]) -> Path:
    """Write a figure; the suffix says the format.

    Raises
    ------
    MyobridgeError
        If it cannot be written.
    """
    target = Path(path)
    try:
        figure.savefig(target, dpi=120)
    except (OSError, ValueError) as error:
        raise MyobridgeError(f"{target}: the picture cannot be written ({error})") from None
    return target


def title(result: Result) -> str:
    """Name of the result's scene, as text that matplotlib takes literally."""
    name = tomllib.loads(result.scene).get("scene", {}).get("name", "") if result.scene else ""
    # A dollar sign would begin mathematics.
    return str(name).replace("$", r"\$")
