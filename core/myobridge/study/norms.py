r"""Norms in time: how far one course of a quantity is from another.

.. math:: \mathrm{max}: \frac{\max_i |y_i - r(t_i)|}{\max_t |r|}, \qquad
          \mathrm{rms}: \Bigl(\frac{\int |y - r|^2 dt}{\int |r|^2 dt}\Bigr)^{1/2}, \qquad
          \mathrm{end}: \frac{|y(T) - r(T)|}{\max_t |r|}

The times are those at which the variant's own steps end, from the start on; the reference, whose steps are much
shorter, is interpolated linearly between its own. So no variant is charged with an interpolation that it never did.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from myobridge.interfaces import Array

__all__ = ["NORMS", "relative_error"]


def _size(values: Array) -> Array:
    """Length of the vector at each time, (n_times, k) -> (n_times,)."""
    return np.sqrt(np.sum(values**2, axis=1))


def _weights(times: Array) -> Array:
    """Trapezoidal rule."""
    if times.size == 1:
        return np.ones(1)
    gaps = np.diff(times)
    return 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps))


def _mean_square(times: Array, sizes: Array) -> float:
    return float(np.sqrt(_weights(times) @ sizes**2 / max(float(np.ptp(times)), 1e-300)))


NORMS: Mapping[str, tuple[Callable[[Array, Array], float], Callable[[Array, Array], float]]] = {
    "max": (lambda times, sizes: float(sizes.max()), lambda times, sizes: float(sizes.max())),
    "rms": (_mean_square, _mean_square),
    "end": (lambda times, sizes: float(sizes[-1]), lambda times, sizes: float(sizes.max())),
}
"""Norm of the difference and norm of the reference, by name."""


def relative_error(times: Array, values: Array, at: Array, reference: Array, norm: str) -> float:
    """Distance of `values` (n, k) at `times` from the `reference` (m, k) at the times `at`, over its size.

    A reference that is zero throughout has no size: then the distance is relative to the larger of the two.
    """
    there = np.stack([np.interp(times, at, column) for column in reference.T], axis=1)
    of_difference, of_reference = NORMS[norm]
    distance = of_difference(times, _size(values - there))
    size = of_reference(at, _size(reference)) or of_reference(times, _size(values))
    return distance / size if size else 0.0
