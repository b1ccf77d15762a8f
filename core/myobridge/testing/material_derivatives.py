"""Checks of a material: stress and tangent against finite differences of decreasing step."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from myobridge.interfaces import Array, Material
from myobridge.material_points import MaterialPoints
from myobridge.testing.fitted_order import fitted_order

__all__ = ["check_major_symmetry", "check_stress_is_derivative", "check_tangent_is_derivative"]

_STEPS = tuple(4e-3 * 0.5**k for k in range(5))
# Errors below are round-off: a law that is a polynomial of low degree has no other.
_ROUND_OFF = 1e-10


def check_stress_is_derivative(material: Material, gradient: Array, direction: Array) -> None:
    """P is dW/dF."""
    points = MaterialPoints(material)
    stress = points.stress(gradient, direction)
    scale = _stiffness(points, gradient, direction)
    errors = [_worst(_differences(points.energy, gradient, direction, step) - stress, scale) for step in _STEPS]
    _vanish(errors, "stress", "the derivative of the energy")


def check_tangent_is_derivative(material: Material, gradient: Array, direction: Array) -> None:
    """A is dP/dF."""
    points = MaterialPoints(material)
    tangent = points.tangent(gradient, direction)
    scale = _stiffness(points, gradient, direction)
    errors = [_worst(_differences(points.stress, gradient, direction, step) - tangent, scale) for step in _STEPS]
    _vanish(errors, "tangent", "the derivative of the stress")


def check_major_symmetry(material: Material, gradient: Array, direction: Array) -> None:
    """The derivative of P is symmetric: P comes from an energy."""
    points = MaterialPoints(material)
    scale = _stiffness(points, gradient, direction)
    errors = []
    for step in _STEPS:
        slope = _differences(points.stress, gradient, direction, step)
        errors.append(_worst(slope - slope.transpose(0, 3, 4, 1, 2), scale))
    _vanish(errors, "derivative of the stress", "symmetric")


def _differences(function: Callable[..., Array], gradient: Array, direction: Array, step: float) -> Array:
    """Central differences by the nine entries of F, which come last: (n, ..., 3, 3)."""
    n = len(gradient)
    shift = step * np.eye(9).reshape(9, 1, 3, 3)
    shifted = np.concatenate([gradient + shift, gradient - shift]).reshape(-1, 3, 3)
    values = function(shifted, np.tile(np.broadcast_to(direction, (n, 3)), (18, 1)))
    values = values.reshape(2, 9, n, *values.shape[1:])
    slope = np.moveaxis((values[0] - values[1]) / (2.0 * step), 0, -1)
    return slope.reshape(*slope.shape[:-1], 3, 3)


def _stiffness(points: MaterialPoints, gradient: Array, direction: Array) -> Array:
    """Largest entry of A at each point: errors are told against it, also where the stress is small."""
    return np.abs(points.tangent(gradient, direction)).max(axis=(1, 2, 3, 4))


def _worst(difference: Array, scale: Array) -> float:
    return float(np.max(np.abs(difference).reshape(len(scale), -1) / scale[:, None]))


def _vanish(errors: Sequence[float], what: str, claim: str) -> None:
    """Central differences are of order 2: anything that stays, or shrinks more slowly, is an error of the material."""
    if errors[-1] <= _ROUND_OFF:
        return
    order = fitted_order(_STEPS, errors) if np.all(np.isfinite(errors)) else np.nan
    assert order > 1.85, (
        f"{what} is not {claim}: relative errors {[f'{error:.1e}' for error in errors]} "
        f"at steps {[f'{step:.1e}' for step in _STEPS]}, observed order {order:.2f}, expected 2"
    )
