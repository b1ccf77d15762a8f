"""Checks of a material: what it declares, and how its compiled functions treat lanes."""

from __future__ import annotations

import pickle

import numpy as np

from myobridge.compiled import LANES, CompiledFunction
from myobridge.interfaces import Array, Material
from myobridge.material_points import MaterialPoints

__all__ = ["check_batch_is_single", "check_declaration", "check_lanes", "check_pickles", "check_stress_in_tangent"]

_ROUND_OFF = 1e-12


def check_declaration(material: Material, gradient: Array, direction: Array) -> None:
    """There is a summary; constants are a flat array of numbers; the three functions are compiled ones."""
    assert material.summary.strip(), f"{type(material).__name__} has no summary"
    assert isinstance(material.inherent_effects, frozenset), "inherent_effects is not a frozenset"
    constants = material.constants
    assert constants.ndim == 1, f"constants have shape {constants.shape}; expected (any,)"
    assert constants.dtype == np.float64, f"constants are {constants.dtype}; expected float64"
    assert np.all(np.isfinite(constants)), f"constants are not finite: {constants}"
    for name, function in material.functions()._asdict().items():
        assert isinstance(function, CompiledFunction), f"{name} is not made with material_function"


def check_pickles(material: Material, gradient: Array, direction: Array) -> None:
    """A copy through pickle is equal, with the same constants."""
    copy = pickle.loads(pickle.dumps(material))
    assert copy == material
    assert np.array_equal(copy.constants, material.constants)


def check_lanes(material: Material, gradient: Array, direction: Array) -> None:
    """Every row of the first n lanes is written, nothing beyond them and nothing of the input."""
    state = np.zeros((12, LANES))
    state[:9] = np.eye(3).reshape(9, 1)
    state[9] = 1.0
    n_given = min(LANES, len(gradient))
    state[:9, :n_given] = gradient[:n_given].reshape(n_given, 9).T
    state[9:, :n_given] = direction[:n_given].T
    for name, rows in (("energy", 1), ("stress", 9), ("tangent", 54)):
        for n in range(LANES + 1):
            given, constants = state.ravel().copy(), material.constants
            # Lanes beyond n may hold anything.
            given.reshape(12, LANES)[:, n:] = np.nan
            before, said = given.copy(), constants.copy()
            out = np.full(rows * LANES, np.nan)
            out.reshape(rows, LANES)[:, n:] = -7.25
            getattr(material.functions(), name)(n, given, out, constants)
            lanes = out.reshape(rows, LANES)
            assert np.all(lanes[:, n:] == -7.25), f"{name} of {n} points writes to lanes beyond"
            assert np.all(np.isfinite(lanes[:, :n])), f"{name} of {n} points leaves rows unwritten, or not finite"
            assert np.array_equal(given, before, equal_nan=True), f"{name} changes its state"
            assert np.array_equal(constants, said), f"{name} changes its constants"


def check_batch_is_single(material: Material, gradient: Array, direction: Array) -> None:
    """Many points at once give what each gives alone."""
    points = MaterialPoints(material)
    for function in (points.energy, points.stress, points.tangent):
        together = function(gradient, direction)
        alone = np.concatenate([function(gradient[i : i + 1], direction[i : i + 1]) for i in range(len(gradient))])
        scale = np.abs(points.tangent(gradient, direction)).reshape(len(gradient), -1).max(axis=1)
        difference = np.abs(together - alone).reshape(len(gradient), -1).max(axis=1)
        assert np.all(difference <= _ROUND_OFF * scale), f"{function.__name__} depends on the other points of a batch"


def check_stress_in_tangent(material: Material, gradient: Array, direction: Array) -> None:
    """Rows 0-8 of the tangent are the stress."""
    functions, constants = material.functions(), material.constants
    n = min(LANES, len(gradient))
    state = np.zeros((12, LANES))
    state[:9, :n] = gradient[:n].reshape(n, 9).T
    state[9:, :n] = direction[:n].T
    stress, tangent = np.zeros(9 * LANES), np.zeros(54 * LANES)
    functions.stress(n, state.ravel(), stress, constants)
    functions.tangent(n, state.ravel(), tangent, constants)
    scale = np.abs(tangent).reshape(54, LANES).max(axis=0)
    difference = np.abs(stress - tangent[: 9 * LANES]).reshape(9, LANES)
    assert np.all(difference <= _ROUND_OFF * scale), "stress and tangent disagree about P"
