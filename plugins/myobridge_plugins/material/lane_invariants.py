r"""Stress and tangent of one lane from the derivatives of W by the invariants.

.. math:: P = \sum_a W_a\,\frac{\partial I_a}{\partial F}, \qquad
          A = \sum_{ab} W_{ab}\,\frac{\partial I_a}{\partial F} \otimes \frac{\partial I_b}{\partial F}
              + \sum_a W_a\,\frac{\partial^2 I_a}{\partial F\,\partial F}

with :math:`I_1 = tr\,C`, :math:`I_2 = (I_1^2 - tr\,C^2)/2`, :math:`J = det\,F`, :math:`I_4 = |F N|^2`,
:math:`I_5 = |C N|^2`. A stress is a tuple of 9. A tangent is a tuple of the six blocks dP[i, :] / dF[k, :] in the order
(0,0), (0,1), (0,2), (1,1), (1,2), (2,2), each a tuple of 9 (see `lane_tensors`).
"""

from __future__ import annotations

from myobridge_plugins.material.lane_tensors import (
    identity,
    in_lane,
    inner,
    outer,
    product,
    sum_of,
    times,
    times_vector,
    transposed,
    twist,
)

__all__ = [
    "both_stresses",
    "both_tangents",
    "fibre_stress",
    "fibre_tangent",
    "fifth_stress",
    "fifth_tangent",
    "isotropic_stress",
    "isotropic_tangent",
    "product_tangent",
    "right_cauchy_green",
    "second_invariant",
    "trace",
]

both_stresses = sum_of


@in_lane
def right_cauchy_green(f):
    """C = F^T F."""
    return product(transposed(f), f)


@in_lane
def trace(c):
    """I1."""
    return c[0] + c[4] + c[8]


@in_lane
def second_invariant(c):
    """I2 of the symmetric c, as the sum of its principal minors."""
    return c[0] * c[4] - c[1] * c[1] + c[0] * c[8] - c[2] * c[2] + c[4] * c[8] - c[5] * c[5]


@in_lane
def _half_slope_of_second(f, c):
    """I1 F - F C, half the derivative of I2."""
    return sum_of(times(trace(c), f), times(-1.0, product(f, c)))


@in_lane
def isotropic_stress(f, h, c, w1, w2, w3):
    """P of W(I1, I2, J): f is F, h its cofactor, c is C."""
    d = _half_slope_of_second(f, c)
    return sum_of(sum_of(times(2.0 * w1, f), times(2.0 * w2, d)), times(w3, h))


@in_lane
def isotropic_tangent(f, h, c, w1, w2, w3, w11, w13, w23, w33):
    """A of W(I1, I2, J) without W12 and W22, which no law here has.

    The second derivative of I2 is 4 F x F + 2 (I1 - b) x I - 2 I x C - 2 F[i, L] F[k, J], whose first term is taken
    with W11; that of J is eps[i, k, m] eps[J, L, M] F[m, M].
    """
    d = _half_slope_of_second(f, c)
    y = sum_of(times(4.0 * (w11 + w2), f), times(2.0 * w13, h))
    z = times(2.0 * w23, h)
    x = sum_of(sum_of(times(2.0 * w13, f), times(2.0 * w23, d)), times(w33, h))
    s = -2.0 * w2
    own = sum_of(identity(2.0 * w1 - s * trace(c)), times(s, c))
    f0, f1, f2 = f[0:3], f[3:6], f[6:9]
    d0, d1, d2 = d[0:3], d[3:6], d[6:9]
    h0, h1, h2 = h[0:3], h[3:6], h[6:9]
    y0, y1, y2 = y[0:3], y[3:6], y[6:9]
    z0, z1, z2 = z[0:3], z[3:6], z[6:9]
    x0, x1, x2 = x[0:3], x[3:6], x[6:9]
    return (
        sum_of(_slopes(f0, d0, h0, y0, z0, x0), sum_of(_crossed(s, f0, f0), own)),
        sum_of(_slopes(f0, d0, h0, y1, z1, x1), sum_of(_crossed(s, f0, f1), times(w3, twist(f2)))),
        sum_of(_slopes(f0, d0, h0, y2, z2, x2), sum_of(_crossed(s, f0, f2), times(-w3, twist(f1)))),
        sum_of(_slopes(f1, d1, h1, y1, z1, x1), sum_of(_crossed(s, f1, f1), own)),
        sum_of(_slopes(f1, d1, h1, y2, z2, x2), sum_of(_crossed(s, f1, f2), times(w3, twist(f0)))),
        sum_of(_slopes(f2, d2, h2, y2, z2, x2), sum_of(_crossed(s, f2, f2), own)),
    )


@in_lane
def _slopes(f, d, h, y, z, x):
    """Products of first derivatives, of row i (f, d, h) with row k (y, z, x)."""
    return sum_of(sum_of(outer(f, y), outer(d, z)), outer(h, x))


@in_lane
def _crossed(s, fi, fk):
    """s (F[i, L] F[k, J] + b[i, k] I[J, L])."""
    return times(s, sum_of(outer(fk, fi), identity(inner(fi, fk))))


@in_lane
def fibre_stress(m, n, w4):
    """P of W(I4), with m = F N."""
    return _rows(2.0 * w4, m, n)


@in_lane
def _rows(s, m, n):
    return times(s, outer(m, n))


@in_lane
def fibre_tangent(m, n, w4, w44):
    """A of W(I4)."""
    nn = outer(n, n)
    s, w = 2.0 * w4, 4.0 * w44
    return (
        times(s + w * m[0] * m[0], nn),
        times(w * m[0] * m[1], nn),
        times(w * m[0] * m[2], nn),
        times(s + w * m[1] * m[1], nn),
        times(w * m[1] * m[2], nn),
        times(s + w * m[2] * m[2], nn),
    )


@in_lane
def fifth_stress(f, m, n, w5):
    """P of w5 I5 at fixed w5, with m = F N: 2 w5 (m x q + F q x N), q = F^T m."""
    q = times_vector(transposed(f), m)
    r = times_vector(f, q)
    return times(2.0 * w5, sum_of(outer(m, q), outer(r, n)))


@in_lane
def fifth_tangent(f, m, n, w5):
    """A of w5 I5 at fixed w5."""
    q = times_vector(transposed(f), m)
    nn = outer(n, n)
    own = sum_of(outer(n, q), outer(q, n))
    f0, f1, f2 = f[0:3], f[3:6], f[6:9]
    s = 2.0 * w5
    return (
        times(s, sum_of(own, _fifth_block(f0, f0, m[0], m[0], n, nn))),
        times(s, _fifth_block(f0, f1, m[0], m[1], n, nn)),
        times(s, _fifth_block(f0, f2, m[0], m[2], n, nn)),
        times(s, sum_of(own, _fifth_block(f1, f1, m[1], m[1], n, nn))),
        times(s, _fifth_block(f1, f2, m[1], m[2], n, nn)),
        times(s, sum_of(own, _fifth_block(f2, f2, m[2], m[2], n, nn))),
    )


@in_lane
def _fifth_block(fi, fk, mi, mk, n, nn):
    """m_i m_k I[J, L] + m_i F[k, J] N[L] + N[J] m_k F[i, L] + b[i, k] N[J] N[L]."""
    mixed = sum_of(times(mi, outer(fk, n)), times(mk, outer(n, fi)))
    return sum_of(sum_of(identity(mi * mk), mixed), times(inner(fi, fk), nn))


@in_lane
def product_tangent(p, s):
    """s P x P."""
    p0, p1, p2 = p[0:3], p[3:6], p[6:9]
    return (
        _rows(s, p0, p0),
        _rows(s, p0, p1),
        _rows(s, p0, p2),
        _rows(s, p1, p1),
        _rows(s, p1, p2),
        _rows(s, p2, p2),
    )


@in_lane
def both_tangents(a, b):
    """Sum of two tangents."""
    return (
        sum_of(a[0], b[0]),
        sum_of(a[1], b[1]),
        sum_of(a[2], b[2]),
        sum_of(a[3], b[3]),
        sum_of(a[4], b[4]),
        sum_of(a[5], b[5]),
    )
