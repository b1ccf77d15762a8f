"""Mooney-Rivlin material in a form that is at rest where it should be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Material, MaterialFunctions
from myobridge.parameters import choice, number

__all__ = ["MooneyRivlin"]


@final
@attrs.frozen
class MooneyRivlin(Material):
    r"""Isotropic material of Mooney and Rivlin.

    .. math:: W = c_{10}(I_1 - 3) + c_{01}(I_2 - 3) - 2(c_{10} + 2 c_{01}) \ln J

    This is the form "logarithmic": free of stress at F = I for every bulk modulus that the solid adds, polyconvex, and
    infinite as J goes to 0. "isochoric" is :math:`c_{10}(J^{-2/3} I_1 - 3) + c_{01}(J^{-4/3} I_2 - 3)`. "printed" is
    the thesis' :math:`c_{10}(I_1 - 3) + c_{01}(I_2 - 3)`.

    Parameters
    ----------
    c10, c01 : float
        Moduli [Pa]; for incompressible tissue the shear modulus is 2 (c10 + c01).
    form : str
        Treatment of the volume, see above.

    Notes
    -----
    Departures: the thesis [1]_ uses the printed form, which has P(I) = (2 c10 + 4 c01) I, 141.5 kPa for its numbers:
    with a bulk modulus of 1e6 Pa the tissue rests at J = 0.852, with 1e4 Pa it has no rest state. That form stays to
    reproduce the thesis.

    References
    ----------
    .. [1] The thesis that the project implements: material parameters of its numerical experiments.
    .. [2] T. Heidlauf, O. Roehrle, Front. Physiol. 5 (2014) 498, Table 2.
    """

    summary: ClassVar[str] = "isotropic, two moduli; free of stress at rest (form 'printed': the thesis')"
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # [Pa] [1], which cites [2]; its c10 is 1e11 times that of [2], so this tissue is 18 times stiffer.
        "thesis": {"c10": 6.352e4, "c01": 3.627e3},
        # [Pa] [2], Table 2.
        "heidlauf-roehrle-2014": {"c10": 6.352e-7, "c01": 3.627e3},
    }

    # The set "thesis".
    c10: float = number(6.352e4, unit="Pa", within="[0, inf)", doc="modulus of the first invariant")
    c01: float = number(3.627e3, unit="Pa", within="[0, inf)", doc="modulus of the second invariant")
    form: str = choice("logarithmic", ("logarithmic", "isochoric", "printed"), doc="treatment of the volume")

    @property
    def constants(self) -> Array:
        rest = 2.0 * (self.c10 + 2.0 * self.c01) if self.form == "logarithmic" else 0.0
        return np.array([self.c10, self.c01, rest, float(self.form == "isochoric")])

    def functions(self) -> MaterialFunctions:
        from myobridge_plugins.material import mooney_rivlin_kernels as kernels

        return MaterialFunctions(kernels.energy, kernels.stress, kernels.tangent)


@hookimpl
def myobridge_materials():
    return {"mooney_rivlin": MooneyRivlin}
