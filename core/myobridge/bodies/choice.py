"""Choice: which states and which field a picture shows, and what its colours mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import attrs
import numpy as np

from myobridge.errors import MyobridgeError, nearest
from myobridge.fields import FieldSnapshot
from myobridge.interfaces import Array

__all__ = ["Colouring", "choose_field", "choose_states", "named"]

_PREFERRED = ("tension", "stretch", "displacement")
_AXES = ("x", "y", "z")
# Label, factor and unit of what is shown in other units than SI.
_UNITS: Mapping[str, tuple[str, float, str]] = {
    "displacement": ("displacement", 1e3, "mm"),
    "pressure": ("pressure", 1e-3, "kPa"),
    "tension": ("tension", 1e-3, "kPa"),
    "sarcomere_density": ("sarcomere density", 1.0, "-"),
}


@attrs.frozen(eq=False)
class Colouring:
    """What the colours of a picture mean.

    Attributes
    ----------
    name, label : str
        Field, and what the colour bar says.
    values : tuple of ndarray
        One array a state, (n_points,) or (n_cells,), in the unit of the label.
    on_cells : bool
        Where the values live.
    limits : tuple of float
        Least and largest over all states.
    """

    name: str
    label: str
    values: tuple[Array, ...]
    on_cells: bool
    limits: tuple[float, float]

    @property
    def colours(self) -> str:
        """Name of the colour map; one with a middle for what has both signs."""
        return "coolwarm" if self.limits[0] < 0.0 < self.limits[1] and self.name == "pressure" else "viridis"


def choose_states(states: Sequence[FieldSnapshot], wanted: str | int = "") -> list[FieldSnapshot]:
    """States of a result.

    Parameters
    ----------
    wanted : str or int
        A whole number: so many, evenly spread from first to last. Else a list: ``first``, ``last``, and times [s], or
        scales of statics (``0,0.4,0.8``). Empty: four.

    Raises
    ------
    MyobridgeError
        If there is no such state; the message lists those that are there.
    """
    if not states:
        raise MyobridgeError("the result has no state of a body to draw; record some (record.fields)")
    said = str(wanted).strip() or "4"
    if said.isdigit() and int(said) > 0:
        spread = np.linspace(len(states) - 1, 0, int(said)).round().astype(int)  # a single one is the last
        return [states[i] for i in np.unique(spread)]
    return [_one(states, word.strip()) for word in said.split(",")]


def _one(states: Sequence[FieldSnapshot], word: str) -> FieldSnapshot:
    if word in ("first", "last"):
        return states[0 if word == "first" else -1]
    times = np.array([state.time for state in states])
    try:
        sought = float(word)
    except ValueError:
        hint = nearest(word, ["first", "last"])
        raise MyobridgeError(
            f"--states {word}: expected a number of states, or a list of times, 'first' and 'last'. {hint}"
        ) from None
    found = int(np.argmin(np.abs(times - sought))) if np.isfinite(sought) else 0
    # What is typed has few digits; between two states there is none.
    if not abs(times[found] - sought) <= 1e-3 * max(float(np.ptp(times)), abs(sought)):
        kept = ", ".join(f"{time:.6g}" for time in times[:60]) + (", ..." if len(times) > 60 else "")
        raise MyobridgeError(
            f"--states {word}: there is no state at this {states[0].label}. Kept: {kept}. "
            f"Did you mean {times[found]:.6g}?"
        )
    return states[found]


def choose_field(states: Sequence[FieldSnapshot], name: str = "") -> Colouring:
    """Field that colours the states: by its name, a component of a vector as ``displacement_x``; without, the tension.

    A vector without component is shown by its length.

    Raises
    ------
    MyobridgeError
        If there is no such field; with the nearest match.
    """
    names = states[0].names
    if not name:
        name = next((item for item in _PREFERRED if item in names and _tells(states, item)), "displacement")
    vectors = [item for item in names if states[0][item].ndim == 2]
    allowed = [*names, *(f"{item}_{axis}" for item in vectors for axis in _AXES)]
    if name not in allowed:
        raise MyobridgeError(f"--field {name}: the result has no such field. {nearest(name, allowed)}")
    base, component = (name, None) if name in names else (name[:-2], _AXES.index(name[-1]))
    label, factor, unit = _UNITS.get(base, (base.replace("_", " "), 1.0, "-"))
    if component is not None:
        label = f"{label} {name[-1]}"
    values = tuple(factor * _scalar(state[base], component) for state in states)
    there = np.concatenate([array[np.isfinite(array)] for array in values])
    limits = (float(there.min()), float(there.max())) if there.size else (0.0, 1.0)
    if base == "pressure" and limits[0] < 0.0 < limits[1]:  # its sign matters: white is zero
        limits = (-max(-limits[0], limits[1]), max(-limits[0], limits[1]))
    return Colouring(name, f"{label} [{unit}]", values, base in states[0].on_cells, _wide(*limits))


def _tells(states: Sequence[FieldSnapshot], name: str) -> bool:
    return any(np.isfinite(state[name]).any() for state in states)


def _scalar(array: Array, component: int | None) -> Array:
    if array.ndim == 1:
        return array
    return np.linalg.norm(array, axis=1) if component is None else array[:, component]


def _wide(low: float, high: float) -> tuple[float, float]:
    """Limits that do not magnify round-off."""
    if high - low > 1e-9 * max(abs(low), abs(high), 1e-300):
        return low, high
    margin = 0.05 * max(abs(low), abs(high)) or 0.5
    return low - margin, high + margin


def named(state: FieldSnapshot, states: Sequence[FieldSnapshot]) -> str:
    """What stands above the picture of a state, in the unit that suits all `states`."""
    if state.label != "time":
        return f"{state.label} {state.time:.4g}"
    return f"{state.time:.4g} s" if max(item.time for item in states) >= 1.0 else f"{1e3 * state.time:.4g} ms"
