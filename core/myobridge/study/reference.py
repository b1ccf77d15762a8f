r"""Reference of a study: a closed form, or a fine run whose own convergence is checked.

Three runs, each twice finer than the one before, give the distances :math:`e_0, e_1` between neighbours. With their
ratio :math:`r = e_1 / e_0` the finest is off by about

.. math:: e = e_1 \max\Bigl(\frac{r}{1 - r}, \frac{1}{3}\Bigr) ,

the sum of the differences still to come; the bound of a third is for ratios that are small by chance. Where the
distances do not fall (:math:`r \ge 0.9`) the runs have not converged, and the larger distance stands for the error.
"""

from __future__ import annotations

import importlib
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from myobridge.errors import MyobridgeError, ParameterError, nearest
from myobridge.interfaces import Array
from myobridge.study.measurement import Course
from myobridge.study.norms import relative_error
from myobridge.study.variants import flattened

__all__ = ["LEVELS", "Reference", "Standard", "closed_form", "distance", "estimated_error", "standard"]

LEVELS = 3
"""Runs of a fine reference: itself, and two that are finer."""

Function = Callable[[Array], Mapping[str, Array]]


def _settings(value: Any) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise ParameterError("settings", f"is {value!r}; expected a table of scene keys")
    return flattened(value)


def _keys(value: Any) -> tuple[str, ...] | None:
    if value is None:
        return None
    if not isinstance(value, list | tuple) or not all(isinstance(item, str) for item in value):
        raise ParameterError("refine", f"is {value!r}; expected a list of scene keys")
    return tuple(value)


@attrs.frozen(kw_only=True)
class Reference:
    """What variants are compared with.

    Attributes
    ----------
    settings : mapping
        Keys of the coarsest of the three reference runs, for every model. What is not set stands as in the scene,
        except for what the variants refine: there the finest value of any of them is halved.
    refine : sequence of str, optional
        Keys that each further run makes twice finer; all that can be without.
    model : str, optional
        Model whose solution is the truth; that of the scene as it stands without.
    closed_form : callable or str, optional
        From times (n,) [s] to a mapping from quantities to arrays (n,) or (n, k), the solution of `model`; as text
        ``package.module:function``.
    """

    settings: Mapping[str, Any] = attrs.field(factory=dict, converter=_settings)
    refine: tuple[str, ...] | None = attrs.field(default=None, converter=_keys)
    model: str | None = None
    closed_form: Function | str | None = None

    @classmethod
    def of(cls, given: Reference | Mapping[str, Any]) -> Reference:
        """The reference, or that of a table."""
        if isinstance(given, Reference):
            return given
        if not isinstance(given, Mapping):
            raise ParameterError("reference", f"is {given!r}; expected a table")
        allowed = [field.name for field in attrs.fields(cls)]
        for key in given:
            if key not in allowed:
                raise ParameterError(f"reference.{key}", f"is unknown. {nearest(key, allowed)}")
        try:
            return cls(**given)
        except ParameterError as error:
            raise ParameterError(f"reference.{error.key}", error.problem) from None


@attrs.frozen(eq=False)
class Standard:
    """Checked solution of one model.

    Attributes
    ----------
    course : Course
        Finest run, or values of the closed form.
    error : float
        Estimate of its own error, in the norm of the study; 0 for a closed form.
    distances : tuple of float
        Between neighbouring levels, from coarse to fine.
    """

    course: Course
    error: float
    distances: tuple[float, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the distances between its levels fall."""
        return len(self.distances) < 2 or self.distances[-1] < 0.9 * self.distances[-2] or self.distances[-1] == 0.0


def standard(levels: Sequence[Course], norm: str) -> Standard:
    """Standard from runs of one model, each twice finer than the one before."""
    distances = tuple(distance(coarse, fine, norm) for coarse, fine in itertools.pairwise(levels))
    return Standard(levels[-1], estimated_error(distances), distances)


def estimated_error(distances: Sequence[float]) -> float:
    """Estimate of the error of the finest level from the distances between neighbours."""
    *_, before, last = distances
    ratio = last / before if before else (0.0 if last == 0.0 else 1.0)
    return max(before, last) if ratio >= 0.9 else last * max(ratio / (1.0 - ratio), 1.0 / 3.0)


def distance(course: Course, reference: Course, norm: str) -> float:
    """Largest error of any quantity."""
    return max(
        relative_error(course.times, values, reference.times, reference.values[name], norm)
        for name, values in course.values.items()
    )


def closed_form(given: Function | str, times: Array, quantities: Sequence[str]) -> Standard:
    """Standard of a closed form, evaluated at `times`.

    Raises
    ------
    MyobridgeError
        If it cannot be imported, or says nothing of a quantity.
    """
    function = _imported(given) if isinstance(given, str) else given
    answer = function(times)
    values: dict[str, Array] = {}
    for name in quantities:
        if name not in answer:
            raise MyobridgeError(f"reference.closed_form: says nothing of '{name}'. {nearest(name, answer)}")
        values[name] = np.asarray(answer[name], dtype=float).reshape(len(times), -1)
    return Standard(Course(times, values), 0.0)


def _imported(path: str) -> Function:
    module, _, name = path.partition(":")
    try:
        return getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise MyobridgeError(
            f"reference.closed_form: '{path}' cannot be imported ({error}); expected package.module:function"
        ) from None
