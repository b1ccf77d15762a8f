"""Exponential material of Guccione, McCulloch and Waldman."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Material, MaterialFunctions
from myobridge.parameters import number

__all__ = ["Guccione"]


@final
@attrs.frozen
class Guccione(Material):
    r"""Exponential of the strain, transversely isotropic about the fibre.

    .. math:: W = \tfrac{C}{2} (e^Q - 1), \qquad
              Q = b_f E_{ff}^2 + b_t (E_{ss}^2 + E_{nn}^2 + 2 E_{sn}^2) + 2 b_{fs} (E_{fs}^2 + E_{fn}^2)

    with the Green strain :math:`E = (F^T F - I)/2`, f along the fibre N, s and n across it. Stiffening with stretch is
    inherent. At Q beyond 700 the exponential overflows to infinity.

    Parameters
    ----------
    c : float
        Modulus C [Pa].
    bf, bt, bfs : float
        Exponents along the fibre, across it, and of the shear between [-].

    Notes
    -----
    Departures: none; the volume is not treated, and nothing but the solid's constraint or bulk modulus resists J -> 0.

    References
    ----------
    .. [1] J. M. Guccione, A. D. McCulloch, L. K. Waldman, J. Biomech. Eng. 113 (1991) 42-55.
    .. [2] S. Land et al., Proc. R. Soc. A 471 (2015) 20150641, constitutive law and problems 1 and 2.
    """

    summary: ClassVar[str] = "exponential of the strain, transversely isotropic (Guccione 1991)"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"fibre_stiffening"})
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # [Pa], [-] [2], problem 1: the beam.
        "land-2015-1": {"c": 2e3, "bf": 8.0, "bt": 2.0, "bfs": 4.0},
        # [Pa], [-] [2], problem 2: the inflated ellipsoid, isotropic.
        "land-2015-2": {"c": 1e4, "bf": 1.0, "bt": 1.0, "bfs": 1.0},
    }

    # The set "land-2015-1".
    c: float = number(2e3, unit="Pa", within="(0, inf)", doc="modulus C")
    bf: float = number(8.0, within="(0, inf)", doc="exponent along the fibre")
    bt: float = number(2.0, within="(0, inf)", doc="exponent across the fibre")
    bfs: float = number(4.0, within="(0, inf)", doc="exponent of the shear between fibre and cross direction")

    @property
    def constants(self) -> Array:
        return np.array([self.c, self.bf, self.bt, self.bfs])

    def functions(self) -> MaterialFunctions:
        from myobridge_plugins.material import guccione_kernels as kernels

        return MaterialFunctions(kernels.energy, kernels.stress, kernels.tangent)


@hookimpl
def myobridge_materials():
    return {"guccione": Guccione}
