"""A stranger's material passes the kit; the same material with one fault fails the check that names it."""

from __future__ import annotations

import math
from typing import Any, ClassVar, final

import attrs
import numpy as np
import pytest

from myobridge import Material
from myobridge.compiled import LANES, material_function
from myobridge.interfaces import MaterialFunctions
from myobridge.material_points import MaterialPoints
from myobridge.parameters import choice, number
from myobridge.testing import material_checks

FAULTS = (
    "none",
    "energy",
    "tangent",
    "rotates",
    "torque",
    "sense",
    "rest",
    "beyond",
    "unwritten",
    "writes",
    "neighbours",
    "stress of tangent",
    "not finite",
    "soft",
)


@material_function
def energy(n, state, out, constants):
    """W = mu / 2 (I1 - 3) - mu ln J, with faults."""
    mu, fault = constants[0], int(constants[1])
    for lane in range(n):
        f = [state[row * LANES + lane] for row in range(9)]
        J = f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) + f[2] * (f[3] * f[7] - f[4] * f[6])
        square = 0.0
        for row in range(9):
            square += f[row] * f[row]
        w = 0.5 * mu * (square - 3.0) - mu * math.log(J)
        out[lane] = w * 1.0001 if fault == 1 else w
        if fault == 3:
            out[lane] += 1e-6 * mu * f[1]


@material_function
def stress(n, state, out, constants):
    """P = mu (F - F^-T), with faults."""
    mu, fault = constants[0], int(constants[1])
    for lane in range(n + 1 if fault == 7 and n < LANES else n):
        f = [state[row * LANES + lane] for row in range(9)]
        h = [0.0] * 9
        for i in range(3):
            for j in range(3):
                a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
                h[3 * i + j] = f[3 * a + c] * f[3 * b + d] - f[3 * a + d] * f[3 * b + c]
        J = f[0] * h[0] + f[1] * h[1] + f[2] * h[2]
        for row in range(9):
            out[row * LANES + lane] = mu * (f[row] - h[row] / J)
        if fault == 4:
            out[LANES + lane] += 1e-9 * mu
        if fault == 5:
            out[lane] += 1e-6 * mu * state[9 * LANES + lane]
        if fault == 6:
            out[lane] += 1e-6 * mu
        if fault == 12 and f[0] == 1.0:
            out[lane] = math.nan
        if fault == 10:
            out[lane] += 1e-6 * mu * state[0]
        if fault == 9:
            state[lane] += 1e-9


@material_function
def tangent(n, state, out, constants):
    """A = mu (I x I + F^-T x F^-T, crossed), with faults."""
    mu, fault = constants[0], int(constants[1])
    for lane in range(n):
        f = [state[row * LANES + lane] for row in range(9)]
        g = [0.0] * 9
        for i in range(3):
            for j in range(3):
                a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
                g[3 * i + j] = f[3 * a + c] * f[3 * b + d] - f[3 * a + d] * f[3 * b + c]
        J = f[0] * g[0] + f[1] * g[1] + f[2] * g[2]
        for row in range(9):
            g[row] /= J
            out[row * LANES + lane] = mu * (f[row] - g[row]) * (1.0001 if fault == 11 else 1.0)
        for r in range(9):
            for c in range(r, 9):
                crossed = g[3 * (r // 3) + c % 3] * g[3 * (c // 3) + r % 3]
                value = mu * ((1.0 if r == c else 0.0) + crossed)
                if fault == 2:
                    value *= 1.0001
                if fault == 13:
                    value *= -1.0
                if not (fault == 8 and r == 8):
                    out[(9 + r * (17 - r) // 2 + c) * LANES + lane] = value


@final
@attrs.frozen
class Stranger(Material):
    """Neo-Hookean law, written as a stranger would: loops, lists, nothing of ours but the decorator."""

    summary: ClassVar[str] = "neo-Hooke, by someone else"

    modulus: float = number(1e4, unit="Pa", within="(0, inf)", doc="shear modulus")
    fault: str = choice("none", FAULTS, doc="what is wrong with it")

    @property
    def constants(self) -> Any:
        return np.array([self.modulus, float(FAULTS.index(self.fault))])

    def functions(self) -> MaterialFunctions:
        return MaterialFunctions(energy, stress, tangent)


def failing(material: Material) -> set[str]:
    names = set()
    for check in material_checks(material):
        try:
            check()
        except AssertionError:
            names.add(check.__name__.removeprefix("check_"))
    return names


def test_a_strangers_material_passes():
    assert failing(Stranger()) == set()


@pytest.mark.parametrize(
    ("fault", "check"),
    [
        ("energy", "stress_is_derivative"),
        ("tangent", "tangent_is_derivative"),
        ("rotates", "objectivity"),
        ("torque", "cauchy_symmetry"),
        ("sense", "fibre_sign"),
        ("rest", "rest"),
        ("beyond", "lanes"),
        ("unwritten", "lanes"),
        ("writes", "lanes"),
        ("neighbours", "batch_is_single"),
        ("stress of tangent", "stress_in_tangent"),
        ("not finite", "finite"),
        ("soft", "rest"),
    ],
)
def test_a_fault_fails_its_check(fault, check):
    assert check in failing(Stranger(fault=fault))


def test_points_take_any_number_and_one_direction_for_all():
    points = MaterialPoints(Stranger(modulus=2.0))
    gradient = np.eye(3) + 0.1 * np.random.default_rng(3).standard_normal((21, 3, 3))
    stress = points.stress(gradient, np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(stress, 2.0 * (gradient - np.linalg.inv(gradient).transpose(0, 2, 1)), atol=1e-14)
    assert points.energy(gradient).shape == (21,)
    assert points.tangent(gradient).shape == (21, 3, 3, 3, 3)
    assert points.stress(np.empty((0, 3, 3))).shape == (0, 3, 3)
