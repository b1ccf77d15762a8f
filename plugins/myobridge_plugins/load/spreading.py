"""Uniform loads: a vector spread over a surface, checked against its dimension, times a function of time."""

from __future__ import annotations

import numpy as np

from myobridge.errors import ParameterError
from myobridge.interfaces import Array, Signal, Surface

__all__ = ["factor", "shares", "spread", "vector"]


def shares(surface: Surface) -> Array:
    r"""Area [m^2] that each node stands for, shape (n_facets, n_nodes); sums to the area of the boundary.

    .. math:: A_a = \int N_a\,dA
    """
    return surface.areas @ surface.shapes


def spread(surface: Surface, traction: Array) -> Array:
    """Nodal forces [N] of a uniform `traction` (dim,) [Pa], shape (n_facets, n_nodes, dim)."""
    return shares(surface)[:, :, None] * traction


def vector(key: str, value: float | tuple[float, ...], surface: Surface, unit: str) -> Array:
    """Parameter `key` as a vector of the surface's dimension, shape (dim,).

    Raises
    ------
    ParameterError
        If it has another number of components.
    """
    dimension = surface.dimension
    if np.shape(value) != (dimension,):
        raise ParameterError(
            key,
            f"is {value!r}; boundary '{surface.name}' is that of a {dimension}D body: "
            f"expected a list of {dimension} numbers [{unit}]",
        )
    return np.array(value)


def factor(scale: Signal | None, time: float) -> float:
    """Value [-] of the signal `scale` at `time` [s]; 1 without one.

    Raises
    ------
    ParameterError
        If the signal has one value for each site: a load has one for the boundary.
    """
    if scale is None:
        return 1.0
    value = np.asarray(scale.value(time))
    if value.size != 1:
        raise ParameterError("scale", f"has {value.size} values; expected one for the whole boundary")
    return float(value.reshape(()))
