"""Published numbers and closed forms of the materials."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings

from myobridge.build import build
from myobridge.errors import ParameterError
from myobridge.material_points import MaterialPoints
from myobridge.registry import registry
from myobridge.testing.strategies import deformations

ALONG = np.array([1.0, 0.0, 0.0])
REST = np.eye(3)[None]


def material(name, effects=None, **parameters):
    return build(registry(), "material", {"plugin": name, **parameters}, effects)


def uniaxial(law, stretch):
    """Nominal stress [Pa] of incompressible tissue drawn along the fibre, free across it."""
    across = stretch**-0.5
    stress = MaterialPoints(law).stress(np.diag([stretch, across, across])[None], ALONG)[0]
    np.testing.assert_allclose(stress - np.diag(np.diag(stress)), 0.0, atol=1e-12 * np.abs(stress).max())
    return stress[0, 0] - stress[1, 1] * across / stretch


@pytest.mark.parametrize("form", ["logarithmic", "isochoric"])
def test_neo_hooke_uniaxial(form):
    assert uniaxial(material("neo_hooke", shear_modulus=10.0, form=form), 2.0) == pytest.approx(17.5, rel=1e-14)


@pytest.mark.parametrize("form", ["logarithmic", "isochoric", "printed"])
def test_mooney_rivlin_uniaxial(form):
    law = material("mooney_rivlin", c10=2.5, c01=2.5, form=form)
    assert uniaxial(law, 2.0) == pytest.approx(13.125, rel=1e-14)


def test_holzapfel_ogden_uniaxial():
    law = material("holzapfel_ogden", a=0.059, b=8.023, af=18.472, bf=16.026)
    assert uniaxial(law, 1.1) == pytest.approx(17.32206451, abs=5e-9)


def test_the_printed_form_is_not_free_of_stress_at_rest():
    law = material("mooney_rivlin", parameters="thesis", form="printed")
    stress = MaterialPoints(law).stress(REST)[0]
    np.testing.assert_allclose(stress, (2 * 6.352e4 + 4 * 3.627e3) * np.eye(3), rtol=1e-14)
    assert stress[0, 0] == pytest.approx(141.5e3, rel=1e-3)


def _pressed(law, bulk_modulus, J):
    """Stress of the material and of a bulk modulus at a change of volume J [Pa]."""
    size = J ** (1.0 / 3.0)
    return MaterialPoints(law).stress(size * REST)[0, 0, 0] + bulk_modulus * (J - 1.0) * size**2


def test_where_the_printed_form_rests():
    """J = 0.852 for a bulk modulus of 1e6 Pa; nowhere for 1e4 Pa, where the form that is ours rests at J = 1."""
    printed, ours = material("mooney_rivlin", form="printed"), material("mooney_rivlin")
    J = scipy.optimize.brentq(lambda J: _pressed(printed, 1e6, J), 0.7, 1.0, xtol=1e-12)
    assert pytest.approx(0.852, abs=5e-4) == J
    assert min(_pressed(printed, 1e4, J) for J in np.geomspace(1e-6, 1.0, 200)) > 0.0
    J = scipy.optimize.brentq(lambda J: _pressed(ours, 1e4, J), 0.5, 1.5, xtol=1e-14)
    assert pytest.approx(1.0, abs=1e-12) == J


@pytest.mark.parametrize("form", ["logarithmic", "isochoric"])
def test_moduli_at_rest(form):
    c10, c01 = 5e3, 2e3
    tangent = MaterialPoints(material("mooney_rivlin", c10=c10, c01=c01, form=form)).tangent(REST)[0]
    shear = np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 0.5
    # Twice the energy of a shear gamma is mu gamma^2.
    assert np.einsum("ij,ijkl,kl", shear, tangent, shear) == pytest.approx(2.0 * (c10 + c01), rel=1e-13)
    bulk = np.einsum("iikk", tangent) / 9.0
    expected = (4.0 * c10 + 16.0 * c01) / 3.0 if form == "logarithmic" else 0.0
    assert bulk == pytest.approx(expected, rel=1e-13, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "resistance"),
    [
        ("mooney_rivlin", 2.0 * (6.352e4 + 2.0 * 3.627e3)),
        ("neo_hooke", 2.0 * (6.352e4 + 3.627e3)),
        ("transversely_isotropic", 2.0 * (6.352e-7 + 2.0 * 3.627e3)),
        ("holzapfel_ogden", 59.0),
    ],
)
def test_collapse_costs_unbounded_energy(name, resistance):
    """W grows as -d ln J without bound."""
    size = np.geomspace(1e-10, 1e-90, 9)
    energy = MaterialPoints(material(name)).energy(size[:, None, None] * np.eye(3))
    np.testing.assert_allclose(np.diff(energy), -3.0 * resistance * np.diff(np.log(size)), rtol=1e-9)


@pytest.mark.parametrize("name", ["mooney_rivlin", "neo_hooke"])
@settings(max_examples=20)
@given(points=deformations())
def test_the_isochoric_form_does_not_feel_the_volume(name, points):
    law = MaterialPoints(material(name, form="isochoric"))
    gradient, direction = points
    stress = law.stress(gradient, direction)
    size = np.abs(law.tangent(gradient, direction)).max(axis=(1, 2, 3, 4))
    assert np.all(np.abs(np.einsum("nij,nij->n", stress, gradient)) <= 1e-12 * size)
    np.testing.assert_allclose(law.energy(1.3 * gradient), law.energy(gradient), atol=1e-12 * size.max())


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("mooney_rivlin", {}),
        ("mooney_rivlin", {"form": "printed"}),
        ("neo_hooke", {}),
        ("holzapfel_ogden", {}),
        ("transversely_isotropic", {"fibre_modulus": 50.0, "fibre_exponent": 12.0}),
    ],
)
@settings(max_examples=20)
@given(points=deformations())
def test_polyconvex_laws_are_rank_one_convex(name, changes, points):
    """A[a x b] . (a x b) >= 0 for all a and b: no direction in which the tissue folds by itself."""
    gradient, direction = points
    tangent = MaterialPoints(material(name, **changes)).tangent(gradient, direction)
    a, b = np.random.default_rng(1).standard_normal((2, 200, 3))
    bent = np.einsum("nijkl,si,sj,sk,sl->ns", tangent, a, b, a, b, optimize=True)
    size = np.abs(tangent).max(axis=(1, 2, 3, 4))[:, None] * np.sum(a * a, axis=1) * np.sum(b * b, axis=1)
    assert np.all(bent >= -1e-12 * size)


def test_fibres_of_the_transversely_isotropic_material():
    """b (lambda^(d-1) - 1/lambda) in extension, nothing in compression."""
    plain = material("transversely_isotropic", {"incompressibility"})
    fibred = material("transversely_isotropic", {"fibre_stiffening"})
    assert (fibred.fibre_modulus, fibred.fibre_exponent) == (2.756e-2, 43.373)
    for stretch in (1.0, 1.05, 1.2, 1.4):
        expected = 2.756e-2 * (stretch**42.373 - 1.0 / stretch)
        gradient = np.diag([stretch, 1.1, 0.9])[None]
        extra = MaterialPoints(fibred).stress(gradient, ALONG) - MaterialPoints(plain).stress(gradient, ALONG)
        assert extra[0, 0, 0] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        assert np.abs(extra.ravel()[1:]).max() == 0.0
    slack = np.diag([0.9, 1.3, 1.1])[None]
    for what in ("energy", "stress", "tangent"):
        same = getattr(MaterialPoints(fibred), what)(slack, ALONG), getattr(MaterialPoints(plain), what)(slack, ALONG)
        np.testing.assert_array_equal(*same)


def _guccione(law, gradient, direction):
    """P = F S, S from the components of E in a frame whose first axis is the fibre."""
    across = np.cross(direction, np.where(np.abs(direction[:, :1]) < 0.9, ALONG, [0.0, 1.0, 0.0]))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    frame = np.stack([direction, across, np.cross(direction, across)], axis=2)
    strain = 0.5 * (gradient.transpose(0, 2, 1) @ gradient - np.eye(3))
    local = frame.transpose(0, 2, 1) @ strain @ frame
    weights = np.full((3, 3), law.bt)
    weights[0, 1:] = weights[1:, 0] = law.bfs
    weights[0, 0] = law.bf
    exponent = np.einsum("ij,nij,nij->n", weights, local, local)
    second = law.c * np.exp(exponent)[:, None, None] * weights * local
    return 0.5 * law.c * np.expm1(exponent), gradient @ frame @ second @ frame.transpose(0, 2, 1)


@settings(max_examples=20)
@given(points=deformations())
def test_guccione_in_components(points):
    law = material("guccione", c=1.3e3, bf=7.0, bt=2.5, bfs=3.1)
    energy, stress = _guccione(law, *points)
    found = MaterialPoints(law)
    np.testing.assert_allclose(found.energy(*points), energy, rtol=1e-12)
    size = np.abs(found.tangent(*points)).max(axis=(1, 2, 3, 4))[:, None, None]
    assert np.all(np.abs(found.stress(*points) - stress) <= 1e-12 * size)


def test_guccione_takes_large_strains():
    """Q = 600: the exponential is right to the last digits as long as it is a number."""
    law = material("guccione")
    stretch = np.sqrt(1.0 + 2.0 * np.sqrt(600.0 / law.bf))
    stress = MaterialPoints(law).stress(np.diag([stretch, 1.0, 1.0])[None], ALONG)[0]
    assert stress[0, 0] == pytest.approx(law.c * law.bf * np.sqrt(600.0 / law.bf) * stretch * np.exp(600.0), rel=1e-12)


def test_parameter_sets():
    thesis = material("mooney_rivlin", parameters="thesis")
    cited = material("mooney_rivlin", parameters="heidlauf-roehrle-2014")
    assert material("mooney_rivlin") == thesis
    assert thesis.c10 / cited.c10 == pytest.approx(1e11)
    # Shear moduli: 18 times stiffer.
    assert (thesis.c10 + thesis.c01) / (cited.c10 + cited.c01) == pytest.approx(18.5, abs=0.05)
    beam = material("guccione", parameters="land-2015-1")
    assert (beam.c, beam.bf, beam.bt, beam.bfs) == (2e3, 8.0, 2.0, 4.0)
    pig = material("holzapfel_ogden", parameters="holzapfel-ogden-2009")
    assert (pig.a, pig.b, pig.af, pig.bf) == (59.0, 8.023, 18472.0, 16.026)
    # Neo-Hooke by default is the thesis' tissue at small strain.
    assert material("neo_hooke").shear_modulus == pytest.approx(2.0 * (thesis.c10 + thesis.c01), rel=1e-12)


def test_effects():
    with pytest.raises(ParameterError, match="belongs to the effect 'fibre_stiffening'"):
        material("transversely_isotropic", {"gravity"}, fibre_modulus=1.0)
    for name in ("guccione", "holzapfel_ogden"):
        assert registry().find("material", name).inherent_effects == {"fibre_stiffening"}
    assert registry().find("material", "transversely_isotropic").optional_effects == {"fibre_stiffening"}


def test_messages():
    with pytest.raises(ParameterError, match="Did you mean 'isochoric'"):
        material("mooney_rivlin", form="izochoric")
    with pytest.raises(ParameterError, match=r"c10: is -1.0; expected a number in \[0, inf\) \[Pa\]"):
        material("mooney_rivlin", c10=-1.0)
