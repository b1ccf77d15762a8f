"""Structural material of Holzapfel and Ogden, with one family of fibres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Material, MaterialFunctions
from myobridge.parameters import number

__all__ = ["HolzapfelOgden"]


@final
@attrs.frozen
class HolzapfelOgden(Material):
    r"""Exponential matrix with exponential fibres, transversely isotropic.

    .. math:: W = \frac{a}{2b} \left(e^{b (I_1 - 3)} - 1\right) - a \ln J
                  + \frac{a_f}{2 b_f} \left(e^{b_f (I_4 - 1)^2} - 1\right), \qquad I_4 = |F N|^2

    The fibre term counts in extension alone, :math:`I_4 > 1`; the stress is continuous there, and the tangent jumps.
    Stiffening with stretch is inherent.

    Parameters
    ----------
    a, b : float
        Modulus [Pa] and exponent [-] of the matrix.
    af, bf : float
        Modulus [Pa] and exponent [-] of the fibres.

    Notes
    -----
    Departures: the terms of the sheets (a_s, b_s, a_fs, b_fs) are left out, as skeletal muscle has none; and
    :math:`-a \ln J` is added, so that the material is free of stress at F = I. Where J = 1 it changes the pressure
    alone.

    References
    ----------
    .. [1] G. A. Holzapfel, R. W. Ogden, Phil. Trans. R. Soc. A 367 (2009) 3445-3475, Eq. (5.38) and Table 1.
    """

    summary: ClassVar[str] = "exponential matrix and fibres (Holzapfel and Ogden 2009), one family of fibres"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"fibre_stiffening"})
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # [Pa], [-] [1], Table 1, fitted to the shear tests of Dokos et al. (2002) on pig myocardium.
        "holzapfel-ogden-2009": {"a": 59.0, "b": 8.023, "af": 18472.0, "bf": 16.026},
    }

    # The set "holzapfel-ogden-2009".
    a: float = number(59.0, unit="Pa", within="(0, inf)", doc="modulus of the matrix")
    b: float = number(8.023, within="(0, inf)", doc="exponent of the matrix")
    af: float = number(18472.0, unit="Pa", within="[0, inf)", doc="modulus of the fibres")
    bf: float = number(16.026, within="(0, inf)", doc="exponent of the fibres")

    @property
    def constants(self) -> Array:
        return np.array([self.a, self.b, self.af, self.bf])

    def functions(self) -> MaterialFunctions:
        from myobridge_plugins.material import holzapfel_ogden_kernels as kernels

        return MaterialFunctions(kernels.energy, kernels.stress, kernels.tangent)


@hookimpl
def myobridge_materials():
    return {"holzapfel_ogden": HolzapfelOgden}
