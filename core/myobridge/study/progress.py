"""Progress of a study: what is done, and how long the rest will take."""

from __future__ import annotations

from collections.abc import Callable

import attrs

__all__ = ["Progress", "Watch", "weight"]


@attrs.frozen
class Progress:
    """How far a study has come.

    Attributes
    ----------
    done, total : float
        Expected computing time of what is finished and of all that is known to come, in one unit that is no second.
    runs, planned : int
        Runs finished, and known to come.
    label : str
        What was finished last.
    """

    done: float
    total: float
    runs: int
    planned: int
    label: str


Watch = Callable[[Progress], object]


def weight(scene_steps: float, unknowns: int, values: int) -> float:
    """Rough cost of a run from its sizes: only ratios count, and only for what remains to be waited for."""
    return scene_steps * (1e-4 + 3e-5 * unknowns + 2e-9 * values)
