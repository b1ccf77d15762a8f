r"""Inf-sup constants of the element pairs, and what becomes of a pair without one: it locks.

.. math:: \beta_h = \inf_q \sup_w \frac{\int q\,\mathrm{div}\,w}{|w|\,\lVert q\rVert}, \qquad
          B A^{-1} B^T q = \beta^2 M q

`A` is the stiffness at rest of a neo-Hookean body of modulus 1, :math:`2 \int \varepsilon(w) : \varepsilon(w)`, `M` the
mass matrix of the pressures: the very matrices of the solid. The unit square and cube, held on the left.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg as sparse_linalg

from myobridge_plugins.load.traction import Traction
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block
from myobridge_plugins.time_integrator.quasi_static import QuasiStatic


def spectrum(shape, pair, n):
    """All eigenvalues beta, rising, of a pair on a mesh of n cells along an edge; 0 is a spurious pressure."""
    d = 2 if shape in ("triangle", "quadrilateral") else 3
    solid = FiniteElement(
        mesh=Block(size=(1.0,) * d, cells=(n,) * d, shape=shape),
        material=NeoHooke(shear_modulus=1.0),
        support=(Support(boundary="left"),),
        elements=pair,
        bulk_modulus=1.0,
    )
    rest = solid.balance(solid.rest_motion(), None, 0.0, tangent=True)
    gradient = rest.constraint_gradient.toarray()
    schur = gradient @ sparse_linalg.splu(rest.stiffness.tocsc()).solve(gradient.T)
    found = scipy.linalg.eigh(schur, rest.constraint_compliance.toarray(), eigvals_only=True)
    return np.sqrt(np.where(found > 1e-12, found, 0.0))


def told(shape, pair, numbers, found):
    ratios = (found[1:] / found[:-1]).round(3)
    text = f"{shape} {pair} on {numbers}: inf-sup constants {found.round(4)}, ratios {ratios}"
    print(text)
    return text


@pytest.mark.parametrize(
    ("shape", "pair", "numbers"),
    [
        ("triangle", "P2-P1", (3, 6, 12)),
        ("quadrilateral", "Q2-P1disc", (3, 6, 12)),
        ("tetrahedron", "P2-P1", (2, 3, 4)),
        ("hexahedron", "Q2-P1disc", (2, 3, 4)),
    ],
)
def test_stable_pairs_have_a_constant(shape, pair, numbers):
    found = np.array([spectrum(shape, pair, n)[0] for n in numbers])
    text = told(shape, pair, numbers, found)
    assert found[0] > 0.4, text
    assert np.all(found[1:] / found[:-1] > 0.9), text


def test_p1_p0_has_none():
    """More and more spurious pressures; and even without them the constant halves with the cells."""
    numbers = (4, 8, 16)
    all_of_them = [spectrum("triangle", "P1-P0", n) for n in numbers]
    spurious = [int(np.sum(found == 0.0)) for found in all_of_them]
    rest = np.array([found[found > 0.0][0] for found in all_of_them])
    text = told("triangle", "P1-P0", numbers, rest) + f", beyond {spurious} spurious pressures"
    assert spurious == [2, 4, 8], text
    assert np.all(rest[1:] / rest[:-1] < 0.55), text


def tip(shape, pair, n, bulk_modulus):
    """Deflection [m] of the end of a beam of 1 x 0.2 m, held on the left, under a small load across its end."""
    solid = FiniteElement(
        mesh=Block(size=(1.0, 0.2), cells=(5 * n, n), shape=shape),
        material=NeoHooke(shear_modulus=1e4),
        support=(Support(boundary="left"),),
        load=(Traction(boundary="right", traction=(0.0, -1.0)),),
        elements=pair,
        bulk_modulus=bulk_modulus,
    )
    step = QuasiStatic().step(solid, None, solid.rest_motion(), {}, 0.0, 1.0)
    assert step.report.converged
    body = solid._body
    end = np.isclose(body.grid.positions[:, 0], 1.0)
    return float(-body.displacement(step.motion.displacement, 0.0).reshape(-1, 2)[end, 1].mean())


def test_p1_p0_locks_in_bending():
    """Beam theory, F L^3 / 3 E' I with E' = 4 mu in plane strain and F L / (5/6 mu A) of shear, is 3 % off here."""
    theory = 0.2 * (1.0 / (3.0 * 4e4 * 0.2**3 / 12.0) + 1.0 / (5.0 / 6.0 * 1e4 * 0.2))
    exact = tip("quadrilateral", "Q2-P1disc", 8, np.inf)
    good = [tip("triangle", "P2-P1", 2, np.inf), tip("quadrilateral", "Q2-P1disc", 2, np.inf)]
    locked = [tip("triangle", "P1-P0", n, 1e9) / exact for n in (2, 4, 8)]
    soft = tip("triangle", "P1-P0", 8, 1e4) / tip("triangle", "P2-P1", 2, 1e4)
    print(f"theory {theory:.4e}, exact {exact:.4e}, stable pairs {good}, P1-P0 {locked}, and {soft:.3f} if kappa = mu")
    assert exact == pytest.approx(theory, rel=0.05)
    assert good == pytest.approx([exact, exact], rel=0.03)
    assert max(locked) < 0.15
    assert locked[-1] < 1.1 * locked[0], "four times finer, and no better"
    assert soft > 0.9, "not the mesh is too coarse, the pair is"
