"""Neo-Hookean material."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Material, MaterialFunctions
from myobridge.parameters import choice, number

__all__ = ["NeoHooke"]


@final
@attrs.frozen
class NeoHooke(Material):
    r"""Isotropic material with one modulus.

    .. math:: W = \tfrac{\mu}{2} (I_1 - 3) - \mu \ln J

    This is the form "logarithmic"; "isochoric" is :math:`\tfrac{\mu}{2} (J^{-2/3} I_1 - 3)`. Both are free of stress at
    F = I. It is `mooney_rivlin` with c10 = mu / 2 and c01 = 0, and runs the same compiled code.

    Parameters
    ----------
    shear_modulus : float
        Modulus mu [Pa].
    form : str
        Treatment of the volume, see above.

    References
    ----------
    .. [1] G. A. Holzapfel, Nonlinear Solid Mechanics, Wiley (2000), Section 6.5.
    """

    summary: ClassVar[str] = "isotropic, one modulus; free of stress at rest"

    # 2 (c10 + c01) of the thesis' Mooney-Rivlin material: the same tissue at small strain.
    shear_modulus: float = number(1.34294e5, unit="Pa", within="(0, inf)", doc="shear modulus at small strain")
    form: str = choice("logarithmic", ("logarithmic", "isochoric"), doc="treatment of the volume")

    @property
    def constants(self) -> Array:
        isochoric = self.form == "isochoric"
        return np.array([0.5 * self.shear_modulus, 0.0, 0.0 if isochoric else self.shear_modulus, float(isochoric)])

    def functions(self) -> MaterialFunctions:
        from myobridge_plugins.material import mooney_rivlin_kernels as kernels

        return MaterialFunctions(kernels.energy, kernels.stress, kernels.tangent)


@hookimpl
def myobridge_materials():
    return {"neo_hooke": NeoHooke}
