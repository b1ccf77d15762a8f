"""Checks of a material: the laws that hold for every elastic material with fibres."""

from __future__ import annotations

import numpy as np

from myobridge.interfaces import Array, Material
from myobridge.material_points import MaterialPoints
from myobridge.testing.material_samples import random_rotations

__all__ = [
    "check_cauchy_symmetry",
    "check_fibre_sign",
    "check_finite",
    "check_objectivity",
    "check_rest",
]

# Sums of some 50 terms that cancel in part.
_ROUND_OFF = 1e-12


def check_objectivity(material: Material, gradient: Array, direction: Array) -> None:
    """A rotation of the body changes no energy and turns the stress: W(QF) = W(F), P(QF) = Q P(F)."""
    points = MaterialPoints(material)
    rotations = random_rotations(np.random.default_rng(5), len(gradient))
    scale = _scale(points, gradient, direction)
    energy = points.energy(rotations @ gradient, direction) - points.energy(gradient, direction)
    assert np.all(np.abs(energy) <= _ROUND_OFF * scale), "the energy changes when the body is rotated"
    stress = points.stress(rotations @ gradient, direction) - rotations @ points.stress(gradient, direction)
    assert np.all(np.abs(stress) <= _ROUND_OFF * scale[:, None, None]), "the stress does not turn with the body"


def check_cauchy_symmetry(material: Material, gradient: Array, direction: Array) -> None:
    """P F^T is symmetric: no torque without a load."""
    points = MaterialPoints(material)
    kirchhoff = points.stress(gradient, direction) @ gradient.transpose(0, 2, 1)
    skew = np.abs(kirchhoff - kirchhoff.transpose(0, 2, 1))
    scale = _scale(points, gradient, direction)
    assert np.all(skew <= _ROUND_OFF * scale[:, None, None]), f"P F^T is not symmetric: {skew.max()}"


def check_fibre_sign(material: Material, gradient: Array, direction: Array) -> None:
    """A fibre has no sense: N and -N are the same."""
    points = MaterialPoints(material)
    scale = _scale(points, gradient, direction)
    difference = points.stress(gradient, direction) - points.stress(gradient, -direction)
    assert np.all(np.abs(difference) <= _ROUND_OFF * scale[:, None, None]), "the stress depends on the sense of N"


def check_rest(material: Material, gradient: Array, direction: Array) -> None:
    """At F = I there is no stress, and every change of shape costs energy."""
    points = MaterialPoints(material)
    rest = np.broadcast_to(np.eye(3), gradient.shape)
    tangent = points.tangent(rest, direction)
    stress = np.abs(points.stress(rest, direction)).max()
    assert stress <= _ROUND_OFF * np.abs(tangent).max(), f"stress of {stress} Pa at F = I: the body would move"
    strains = _shears()
    stiffness = np.einsum("sij,nijkl,tkl->nst", strains, tangent, strains)
    least = np.linalg.eigvalsh(stiffness).min()
    assert least > 0.0, f"least stiffness against a change of shape at F = I is {least} Pa"


def check_finite(material: Material, gradient: Array, direction: Array) -> None:
    """Energy, stress and tangent are numbers, also at rest and where fibres are exactly as long as at rest."""
    points = MaterialPoints(material)
    special = np.array([np.eye(3), np.diag([1.0, 1.3, 0.8]), np.diag([0.5, 1.0, 1.0]), np.diag([1.5, 1.0, 1.0])])
    for where, along in ((gradient, direction), (special, np.array([1.0, 0.0, 0.0]))):
        for what in (points.energy(where, along), points.stress(where, along), points.tangent(where, along)):
            assert np.all(np.isfinite(what)), "energy, stress or tangent is not finite"


def _shears() -> Array:
    """The five symmetric tensors without trace, orthonormal, shape (5, 3, 3)."""
    pairs = [(0, 1), (0, 2), (1, 2)]
    shears = np.zeros((5, 3, 3))
    for k, (i, j) in enumerate(pairs):
        shears[k, i, j] = shears[k, j, i] = np.sqrt(0.5)
    shears[3] = np.diag([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    shears[4] = np.diag([1.0, 1.0, -2.0]) / np.sqrt(6.0)
    return shears


def _scale(points: MaterialPoints, gradient: Array, direction: Array) -> Array:
    """Size of the terms that cancel, at each point: stiffness times F, and the energy [Pa]."""
    tangent = np.abs(points.tangent(gradient, direction)).max(axis=(1, 2, 3, 4))
    return np.abs(gradient).max(axis=(1, 2)) * tangent + np.abs(points.energy(gradient, direction))
