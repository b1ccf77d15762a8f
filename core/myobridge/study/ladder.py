"""Ladder: the study that a plain scene and a tolerance make: rungs for step, bins and mesh, searched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from myobridge.scene import Scene
from myobridge.study.quantities import Quantity
from myobridge.study.refinement import of_scene, refined
from myobridge.study.study import Study

__all__ = ["ladder"]

# How much finer than the scene the rungs are, in powers of two: coarser ones first, for they may be good enough.
_STEP = range(-6, 7)
_BINS = range(-2, 2)
_MESH = range(-1, 1)
_LEAST_BINS = 8
_LEAST_STEPS = 4


def ladder(
    scene: Scene, tolerance: float, *, quantities: Sequence[Quantity | str] = (), norm: str = "max", repeats: int = 3
) -> Study:
    """Study that looks for the cheapest step, bins and mesh with which a scene is good enough.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        Relative error that is good enough.
    quantities, norm, repeats
        Those of `Study`.
    """
    axes: dict[str, list[Any]] = {}
    mesh: list[dict[str, Any]] = []
    values = of_scene(scene)
    for key, value in values.items():
        if key in ("scene.step", "scene.tolerance"):
            rungs = [refined({key: value}, level)[key] for level in _STEP]
            axes[key] = [rung for rung in rungs if key != "scene.step" or rung * _LEAST_STEPS <= scene.duration]
        elif key == "cross_bridges.bins":
            rungs = [refined({key: value}, level)[key] for level in _BINS]
            axes[key] = [rung for rung in rungs if rung >= _LEAST_BINS] or [value]
        else:
            mesh.append({key: value})
    if "scene.tolerance" in axes:  # the step follows it
        axes.pop("scene.step", None)
    for item in mesh:
        ((key, value),) = item.items()
        rungs = [refined(item, level)[key] for level in _MESH]
        # Cells along and across are refined together or not at all, else an axis more would square the work.
        if len(axes) < 3:
            axes[key] = [rung for place, rung in enumerate(rungs) if rung not in rungs[:place]]
    return Study(
        scene=scene,
        vary=[axes],
        quantities=tuple(map(Quantity.of, quantities)),
        norm=norm,
        tolerance=tolerance,
        repeats=repeats,
        search=True,
    )
