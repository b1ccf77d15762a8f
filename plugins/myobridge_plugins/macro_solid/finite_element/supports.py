"""Supports: displacements that are prescribed on named parts of the boundary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, Signal
from myobridge.parameters import numbers, part, text

__all__ = ["Held", "Support", "held"]

_AXES = "xyz"


@final
@attrs.frozen(kw_only=True)
class Support:
    r"""Prescribed displacement of a boundary, component by component.

    .. math:: u_i(X, t) = s(t)\,d_i, \qquad i \in \text{components}

    Parameters
    ----------
    boundary : str
        Name of the boundary.
    components : str
        Which components are held, such as "x" or "xy"; empty: all.
    displacement : float or sequence of float
        `d` [m], one for each held component, or one for all.
    scale : Signal, optional
        `s` as a function of time; 1 without.
    """

    boundary: str = text(doc="name of the boundary that is held")
    components: str = text("", doc="components that are held, such as 'x' or 'xy'; all when empty")
    displacement: tuple[float, ...] | float = numbers(0.0, unit="m", doc="displacement of the held components")
    scale: Signal | None = part("signal", None, doc="factor of the displacement over time [-]")

    def __attrs_post_init__(self) -> None:
        wrong = [letter for letter in self.components if letter not in _AXES]
        if wrong or len(set(self.components)) != len(self.components):
            raise ParameterError(
                "components", f"is '{self.components}'; expected letters out of x, y, z, each once, such as 'xy'"
            )

    def axes(self, dimension: int) -> list[int]:
        """Numbers of the held components.

        Raises
        ------
        ParameterError
            If the body has no such component, or there are not as many displacements as components.
        """
        axes = [_AXES.index(letter) for letter in self.components] or list(range(dimension))
        if max(axes) >= dimension:
            raise ParameterError("components", f"holds '{_AXES[max(axes)]}', and the body is plane: expected x, y")
        if isinstance(self.displacement, tuple) and len(self.displacement) != len(axes):
            raise ParameterError(
                "displacement",
                f"has {len(self.displacement)} values for {len(axes)} held components; give one for each",
            )
        return axes

    def factor(self, time: float) -> float:
        """s(t) [-]."""
        return 1.0 if self.scale is None else float(np.asarray(self.scale.value(time)).reshape(-1)[0])

    def factor_rate(self, time: float) -> float:
        """ds/dt [1/s]."""
        return 0.0 if self.scale is None else float(np.asarray(self.scale.rate(time)).reshape(-1)[0])


@attrs.frozen(eq=False)
class Held:
    """All supports of a body: the numbers that each holds, and the displacement at full scale."""

    supports: Sequence[Support]
    numbers: Sequence[np.ndarray]
    values: Sequence[Array]

    @property
    def all_numbers(self) -> np.ndarray:
        """Every number that some support holds, sorted."""
        return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *self.numbers]))

    @property
    def moving(self) -> bool:
        """Whether anything is held elsewhere than at rest."""
        return any(bool(np.any(values != 0.0)) for values in self.values)

    def displacement(self, full: Array, time: float) -> Array:
        """Write the held displacements at `time` into the nodal vector `full`."""
        for support, numbers_, values in zip(self.supports, self.numbers, self.values, strict=True):
            full[numbers_] = support.factor(time) * values
        return full

    def velocity(self, full: Array, time: float) -> Array:
        """Write the held velocities at `time` into the nodal vector `full`."""
        for support, numbers_, values in zip(self.supports, self.numbers, self.values, strict=True):
            full[numbers_] = support.factor_rate(time) * values
        return full

    def jumps(self) -> tuple[float, ...]:
        """Times at which a support jumps or bends [s]."""
        return tuple(time for support in self.supports if support.scale is not None for time in support.scale.jumps())


def held(supports: Sequence[Support], nodes: Mapping[str, Any], dimension: int) -> Held:
    """Supports on the nodes of their boundaries.

    Raises
    ------
    ParameterError
        If two supports hold the same component of a node at different places.
    """
    numbers_: list[np.ndarray] = []
    values: list[Array] = []
    for index, support in enumerate(supports):
        try:
            axes = support.axes(dimension)
        except ParameterError as error:
            raise ParameterError(f"support[{index}].{error.key}", error.problem) from None
        on = np.asarray(nodes[support.boundary])
        numbers_.append((dimension * on[:, None] + np.array(axes)).ravel())
        values.append(np.tile(np.broadcast_to(support.displacement, len(axes)), on.size).astype(np.float64))
    found = Held(tuple(supports), numbers_, values)
    _check_agreement(found, dimension)
    return found


def _check_agreement(found: Held, dimension: int) -> None:
    for later, support in enumerate(found.supports):
        for earlier in range(later):
            common, first, second = np.intersect1d(found.numbers[earlier], found.numbers[later], return_indices=True)
            if not common.size:
                continue
            one, other = found.values[earlier][first], found.values[later][second]
            both_zero = (one == 0.0) & (other == 0.0)
            same_scale = found.supports[earlier].scale == support.scale
            clash = ~both_zero & ~((one == other) & same_scale)
            if np.any(clash):
                axis = _AXES[int(common[np.argmax(clash)]) % dimension]
                raise ParameterError(
                    f"support[{later}].displacement",
                    f"moves component {axis} of nodes that support[{earlier}] ('{found.supports[earlier].boundary}') "
                    "holds elsewhere: the boundaries share nodes; hold the component once",
                )
