"""A material at single points: energy, stress and tangent of arrays of deformation gradients."""

from __future__ import annotations

import attrs
import numpy as np

from myobridge.compiled import CompiledFunction
from myobridge.interfaces import Array, Material
from myobridge.interfaces.material import LANES

__all__ = ["MaterialPoints"]

# Row of each of the 81 entries of A in the output of `tangent`, which holds its upper triangle.
_R, _C = np.sort(np.indices((9, 9)), axis=0)
_ENTRY = (9 + _R * (17 - _R) // 2 + _C).reshape(3, 3, 3, 3)


@attrs.frozen
class MaterialPoints:
    r"""Evaluate a material at points, in batches of `LANES`, by its compiled functions.

    .. math:: W(F, N), \qquad P = \partial W / \partial F, \qquad A = \partial P / \partial F

    For tests, plots and material tests; a solid calls the functions itself. Every method takes `gradient`, shape
    (n, 3, 3), the deformation gradients [-], and `direction`, shape (n, 3) or (3,), unit fibre directions in the
    reference; without it the fibre is the first axis.

    Parameters
    ----------
    material : Material
        The material.
    """

    material: Material

    def energy(self, gradient: Array, direction: Array | None = None) -> Array:
        """Energy per reference volume [J/m^3], shape (n,)."""
        return self._rows(self.material.functions().energy, gradient, direction, 1)[:, 0]

    def stress(self, gradient: Array, direction: Array | None = None) -> Array:
        """First Piola-Kirchhoff stress [Pa], shape (n, 3, 3): entry (i, J) acts along i on the reference normal J."""
        return self._rows(self.material.functions().stress, gradient, direction, 9).reshape(len(gradient), 3, 3)

    def tangent(self, gradient: Array, direction: Array | None = None) -> Array:
        """Derivative of the stress [Pa], shape (n, 3, 3, 3, 3): dP[i, J] / dF[k, L] at [i, J, k, L]."""
        return self._rows(self.material.functions().tangent, gradient, direction, 54)[:, _ENTRY]

    def _rows(self, function: CompiledFunction, gradient: Array, direction: Array | None, n_rows: int) -> Array:
        from myobridge.calling import call_in_batches

        gradient = np.asarray(gradient, dtype=np.float64)
        n_points = len(gradient)
        along = np.array([1.0, 0.0, 0.0]) if direction is None else np.asarray(direction, dtype=np.float64)
        batches = -(-n_points // LANES)
        points = np.zeros((batches * LANES, 12))
        points[:n_points, :9] = gradient.reshape(n_points, 9)
        points[:n_points, 9:] = along
        state = np.ascontiguousarray(points.reshape(batches, LANES, 12).transpose(0, 2, 1)).reshape(batches, 12 * LANES)
        out = np.zeros((batches, n_rows * LANES))
        call_in_batches(function.pointer, n_points, state, out, np.ascontiguousarray(self.material.constants))
        return out.reshape(batches, n_rows, LANES).transpose(0, 2, 1).reshape(batches * LANES, n_rows)[:n_points]
