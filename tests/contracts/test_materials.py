"""Every registered material, in every variant, against the contract that plugin authors test with."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from myobridge.material_points import MaterialPoints
from myobridge.registry import registry
from myobridge.testing import material_checks, variants
from myobridge.testing.material_derivatives import (
    check_major_symmetry,
    check_stress_is_derivative,
    check_tangent_is_derivative,
)
from myobridge.testing.material_laws import (
    check_cauchy_symmetry,
    check_fibre_sign,
    check_finite,
    check_objectivity,
    check_rest,
)
from myobridge.testing.strategies import deformations

MATERIALS = {key: model for name in registry().names("material") for key, model in variants("material", name).items()}
# The thesis' form is kept to show what happens to a material that is not free of stress at rest.
STRESSED = {key for key, model in MATERIALS.items() if getattr(model, "form", "") == "printed"}
CHECKS = [
    pytest.param(check, id=f"{key}-{check.__name__.removeprefix('check_')}")
    for key, model in MATERIALS.items()
    for check in material_checks(model, stress_free=key not in STRESSED)
]


@pytest.mark.parametrize("check", CHECKS)
def test_contract(check):
    check()


@pytest.mark.parametrize("key", sorted(STRESSED))
def test_what_is_excused_from_rest_is_stressed_there(key):
    gradient = np.eye(3)[None]
    with pytest.raises(AssertionError, match="the body would move"):
        check_rest(MATERIALS[key], gradient, np.array([[1.0, 0.0, 0.0]]))


@pytest.mark.parametrize("key", MATERIALS)
@settings(max_examples=15)
@given(points=deformations())
def test_laws_hold_at_any_deformation(key, points):
    for check in (check_objectivity, check_cauchy_symmetry, check_fibre_sign, check_finite):
        check(MATERIALS[key], *points)


@pytest.mark.parametrize("key", MATERIALS)
@settings(max_examples=15)
@given(points=deformations(gap=0.1))
def test_derivatives_hold_at_any_deformation(key, points):
    for check in (check_stress_is_derivative, check_tangent_is_derivative, check_major_symmetry):
        check(MATERIALS[key], *points)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


@pytest.mark.parametrize("key", MATERIALS)
@settings(max_examples=15)
@given(points=deformations(low=0.8, high=1.2))
def test_work_along_a_path_is_the_difference_of_energy(key, points):
    """Over a straight path from rest, cut where the fibres change from slack to taut."""
    material = MaterialPoints(MATERIALS[key])
    gradient, direction = points
    # The symmetric stretch: the straight path from I to it keeps J > 0.
    change = _stretch(gradient) - np.eye(3)
    turn = np.einsum("nij,nj->ni", change, direction)
    # |N + s turn| = 1 at s = 0 and at the cut.
    length = np.maximum(np.sum(turn * turn, axis=1), 1e-300)
    cut = np.clip(-2.0 * np.sum(direction * turn, axis=1) / length, 0.0, 1.0)
    work = np.zeros(len(gradient))
    for start, end in ((np.zeros_like(cut), cut), (cut, np.ones_like(cut))):
        share = start + 0.5 * (NODES[:, None] + 1.0) * (end - start)
        along = np.eye(3) + share[:, :, None, None] * change
        stress = material.stress(along.reshape(-1, 3, 3), np.tile(direction, (20, 1))).reshape(along.shape)
        work += 0.5 * (end - start) * np.einsum("q,qnij,nij->n", WEIGHTS, stress, change)
    rest = np.broadcast_to(np.eye(3), gradient.shape)
    gain = material.energy(np.eye(3) + change, direction) - material.energy(rest, direction)
    size = np.abs(material.tangent(np.eye(3) + change, direction)).max(axis=(1, 2, 3, 4))
    assert np.all(np.abs(work - gain) <= 1e-12 * size)


def _stretch(gradient):
    values, vectors = np.linalg.eigh(gradient.transpose(0, 2, 1) @ gradient)
    return np.einsum("nij,nj,nkj->nik", vectors, np.sqrt(values), vectors)


def test_something_is_registered():
    assert {"mooney_rivlin", "neo_hooke", "transversely_isotropic", "guccione", "holzapfel_ogden"} <= set(
        registry().names("material")
    )
    assert len(STRESSED) == 1
