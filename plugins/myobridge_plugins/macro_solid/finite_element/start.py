r"""Motion of a body at the start: stretched, moving and turning as a whole.

.. math:: x_i = c_i + \lambda_i (X_i - c_i), \qquad v = v_0 + \omega \times (x - x_c)

`c` is the middle of what supports hold, the middle of the body where they hold nothing, and :math:`x_c` the centre of
mass. What is held stays where the support has it, so that the stretch is not homogeneous beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, Motion
from myobridge_plugins.macro_solid.finite_element.body import Body

__all__ = ["start_motion"]

Numbers = tuple[float, ...] | float | None


def _each(key: str, given: Numbers, count: int, what: str) -> Array:
    found = np.atleast_1d(np.asarray(given, dtype=np.float64))
    if found.size != count:
        raise ParameterError(key, f"has {found.size} values; expected {count}, {what}")
    return found


def start_motion(body: Body, mass: Callable[[], Any], stretch: Numbers, velocity: Numbers, spin: Numbers) -> Motion:
    """Motion at t = 0, without pressure; what is None adds nothing.

    Parameters
    ----------
    mass : callable
        Gives the mass over nodes [kg], which only a spinning body needs.

    Raises
    ------
    ParameterError
        If there are not as many components as the body has.
    """
    displacement = _displacement(body, stretch)
    at_rest = velocity is None and spin is None
    moving = np.zeros_like(displacement) if at_rest else _velocity(body, mass, displacement, velocity, spin)
    return Motion(displacement, moving, np.zeros(body.free_multipliers.size))


def _displacement(body: Body, stretch: Numbers) -> Array:
    if stretch is None:
        return np.zeros(body.free.size)
    place = body.grid.positions
    factors = _each("stretch_at_start", stretch, place.shape[1], "one for each axis")
    held = np.unique(body.held.all_numbers // place.shape[1])
    middle = place[held].mean(axis=0) if held.size else place.mean(axis=0)
    return ((factors - 1.0) * (place - middle)).ravel()[body.free]


def _velocity(body: Body, mass: Callable[[], Any], displacement: Array, velocity: Numbers, spin: Numbers) -> Array:
    d = body.grid.dimension
    found = np.zeros((body.grid.n_nodes, d))
    if velocity is not None:
        found += _each("velocity_at_start", velocity, d, "one for each axis")
    if spin is not None:
        count, what = (1, "about the normal of the plane") if d == 2 else (3, "one for each axis")
        turning = _each("spin_at_start", spin, count, what)
        place = np.zeros((body.grid.n_nodes, 3))
        place[:, :d] = body.grid.positions + body.displacement(displacement, 0.0).reshape(-1, d)
        nodal = mass()
        weights = nodal if isinstance(nodal, np.ndarray) else nodal.sum(axis=1)
        centre = weights @ place / weights.sum()
        axis = np.array([0.0, 0.0, turning[0]]) if d == 2 else turning
        found = found + np.cross(axis, place - centre)[:, :d].astype(np.float64)
    return found.ravel()[body.free]
