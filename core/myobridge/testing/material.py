"""Contract checks of a material."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from myobridge.interfaces import Array, Material
from myobridge.testing.material_derivatives import (
    check_major_symmetry,
    check_stress_is_derivative,
    check_tangent_is_derivative,
)
from myobridge.testing.material_form import (
    check_batch_is_single,
    check_declaration,
    check_lanes,
    check_pickles,
    check_stress_in_tangent,
)
from myobridge.testing.material_laws import (
    check_cauchy_symmetry,
    check_fibre_sign,
    check_finite,
    check_objectivity,
    check_rest,
)
from myobridge.testing.material_samples import random_deformations

__all__ = ["material_checks"]

Check = Callable[[Material, Array, Array], None]


def material_checks(material: Material, *, stress_free: bool = True, seed: int = 0) -> list[Callable[[], None]]:
    """Checks that hold `material` to its contract at random deformations; call each, or parametrise a test by them.

    Parameters
    ----------
    material : Material
        The material.
    stress_free : bool
        Whether it must be free of stress at F = I. False is for laws that are kept to show what happens then.
    seed : int
        Seed of the deformations: stretches from 0.75 to 1.35 in random directions. Fibres are kept 10 % away from
        I4 = 1, where a law may switch.

    A check raises AssertionError with what was found and what is expected. Every check carries its name in
    ``__name__`` and what it holds the material to in ``__doc__``.
    """
    wanted: list[tuple[Check, bool]] = [
        (check_declaration, True),
        (check_pickles, True),
        (check_lanes, True),
        (check_batch_is_single, True),
        (check_stress_in_tangent, True),
        (check_stress_is_derivative, True),
        (check_tangent_is_derivative, True),
        (check_major_symmetry, True),
        (check_objectivity, True),
        (check_cauchy_symmetry, True),
        (check_fibre_sign, True),
        (check_finite, True),
        (check_rest, stress_free),
    ]
    # 13 points: a full batch and a part of one.
    gradient, direction = random_deformations(np.random.default_rng(seed), 13, gap=0.1)
    return [_bound(check, material, gradient, direction) for check, applies in wanted if applies]


def _bound(check: Check, material: Material, gradient: Array, direction: Array) -> Callable[[], None]:
    bound = functools.partial(check, material, gradient, direction)
    return functools.update_wrapper(bound, check)
