r"""Symmetric tensors of one lane: a tuple of 6 in the order 00, 11, 22, 12, 02, 01.

Straight-line code that is compiled into the loop over the lanes that calls it, as `lane_tensors` of the materials.
"""

from __future__ import annotations

import math

import numpy as np

from myobridge.compiled import LANES
from myobridge_plugins.material.lane_tensors import in_lane

__all__ = [
    "cofactor_symmetric",
    "combination",
    "dyad",
    "load_symmetric",
    "product_symmetric",
    "scalar_product",
    "second_stress",
    "square",
    "store_symmetric",
    "strain_change",
    "upper_factor",
]

_ROW = tuple(np.uint64(row * LANES) for row in range(6))


@in_lane
def load_symmetric(rows, lane):
    """The tensor in rows 0-5."""
    at = np.uint64(lane)
    return (
        rows[at],
        rows[_ROW[1] + at],
        rows[_ROW[2] + at],
        rows[_ROW[3] + at],
        rows[_ROW[4] + at],
        rows[_ROW[5] + at],
    )


@in_lane
def store_symmetric(rows, lane, s):
    """Write the tensor to rows 0-5."""
    at = np.uint64(lane)
    rows[at] = s[0]
    rows[_ROW[1] + at] = s[1]
    rows[_ROW[2] + at] = s[2]
    rows[_ROW[3] + at] = s[3]
    rows[_ROW[4] + at] = s[4]
    rows[_ROW[5] + at] = s[5]


@in_lane
def combination(a, s, b, t):
    """a s + b t."""
    return (
        a * s[0] + b * t[0],
        a * s[1] + b * t[1],
        a * s[2] + b * t[2],
        a * s[3] + b * t[3],
        a * s[4] + b * t[4],
        a * s[5] + b * t[5],
    )


@in_lane
def scalar_product(s, t):
    """s : t."""
    return s[0] * t[0] + s[1] * t[1] + s[2] * t[2] + 2.0 * (s[3] * t[3] + s[4] * t[4] + s[5] * t[5])


@in_lane
def square(f):
    """F^T F."""
    return (
        f[0] * f[0] + f[3] * f[3] + f[6] * f[6],
        f[1] * f[1] + f[4] * f[4] + f[7] * f[7],
        f[2] * f[2] + f[5] * f[5] + f[8] * f[8],
        f[1] * f[2] + f[4] * f[5] + f[7] * f[8],
        f[0] * f[2] + f[3] * f[5] + f[6] * f[8],
        f[0] * f[1] + f[3] * f[4] + f[6] * f[7],
    )


@in_lane
def strain_change(f, d):
    """Symmetric part of F^T D."""
    return (
        f[0] * d[0] + f[3] * d[3] + f[6] * d[6],
        f[1] * d[1] + f[4] * d[4] + f[7] * d[7],
        f[2] * d[2] + f[5] * d[5] + f[8] * d[8],
        0.5 * (f[1] * d[2] + f[4] * d[5] + f[7] * d[8] + f[2] * d[1] + f[5] * d[4] + f[8] * d[7]),
        0.5 * (f[0] * d[2] + f[3] * d[5] + f[6] * d[8] + f[2] * d[0] + f[5] * d[3] + f[8] * d[6]),
        0.5 * (f[0] * d[1] + f[3] * d[4] + f[6] * d[7] + f[1] * d[0] + f[4] * d[3] + f[7] * d[6]),
    )


@in_lane
def cofactor_symmetric(c):
    """Cofactor of a symmetric tensor."""
    return (
        c[1] * c[2] - c[3] * c[3],
        c[0] * c[2] - c[4] * c[4],
        c[0] * c[1] - c[5] * c[5],
        c[4] * c[5] - c[0] * c[3],
        c[5] * c[3] - c[1] * c[4],
        c[4] * c[3] - c[2] * c[5],
    )


@in_lane
def upper_factor(c):
    """U with U^T U = C, upper triangular, as a tuple of 9."""
    u00 = math.sqrt(c[0])
    u01, u02 = c[5] / u00, c[4] / u00
    u11 = math.sqrt(c[1] - u01 * u01)
    u12 = (c[3] - u01 * u02) / u11
    u22 = math.sqrt(c[2] - u02 * u02 - u12 * u12)
    return u00, u01, u02, 0.0, u11, u12, 0.0, 0.0, u22


@in_lane
def second_stress(u, p):
    """S = U^-1 P of an upper triangular U, symmetric by construction."""
    i0, i1, i2 = 1.0 / u[0], 1.0 / u[4], 1.0 / u[8]
    s02, s12, s22 = i2 * p[6], i2 * p[7], i2 * p[8]
    s01, s11 = i1 * (p[3] - u[5] * s02), i1 * (p[4] - u[5] * s12)
    s00 = i0 * (p[0] - u[1] * s01 - u[2] * s02)
    return s00, s11, s22, s12, s02, s01


@in_lane
def product_symmetric(f, s):
    """F S as a tuple of 9."""
    return (
        f[0] * s[0] + f[1] * s[5] + f[2] * s[4],
        f[0] * s[5] + f[1] * s[1] + f[2] * s[3],
        f[0] * s[4] + f[1] * s[3] + f[2] * s[2],
        f[3] * s[0] + f[4] * s[5] + f[5] * s[4],
        f[3] * s[5] + f[4] * s[1] + f[5] * s[3],
        f[3] * s[4] + f[4] * s[3] + f[5] * s[2],
        f[6] * s[0] + f[7] * s[5] + f[8] * s[4],
        f[6] * s[5] + f[7] * s[1] + f[8] * s[3],
        f[6] * s[4] + f[7] * s[3] + f[8] * s[2],
    )


@in_lane
def dyad(v):
    """v[I] v[J]."""
    return v[0] * v[0], v[1] * v[1], v[2] * v[2], v[1] * v[2], v[0] * v[2], v[0] * v[1]
