"""Mooney-Rivlin matrix with passive fibres that stiffen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, final

import attrs
import numpy as np

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Array, Material, MaterialFunctions
from myobridge.parameters import number

__all__ = ["TransverselyIsotropic"]


@final
@attrs.frozen
class TransverselyIsotropic(Material):
    r"""Skeletal muscle of Heidlauf and Roehrle.

    .. math:: W = c_{10}(I_1 - 3) + c_{01}(I_2 - 3) - 2(c_{10} + 2 c_{01}) \ln J
                  + \tfrac{b}{d} (\lambda^d - 1) - b \ln \lambda, \qquad \lambda = |F N|

    The nominal fibre stress is :math:`b (\lambda^{d-1} - \lambda^{-1})`. Fibres carry no compression: below
    :math:`\lambda = 1` their term is left out; the stress is continuous there, the tangent jumps by :math:`b\,d`.
    Without the effect `fibre_stiffening` there is no fibre term at all.

    Parameters
    ----------
    c10, c01 : float
        Moduli of the matrix [Pa].
    fibre_modulus : float
        Modulus b [Pa]; effect `fibre_stiffening`.
    fibre_exponent : float
        Exponent d [-]; effect `fibre_stiffening`.

    Notes
    -----
    Departures: the matrix has the logarithm that frees it of stress at F = I (see `MooneyRivlin`); fibres are slack in
    compression, where the formula alone would let them push.

    References
    ----------
    .. [1] T. Heidlauf, O. Roehrle, Front. Physiol. 5 (2014) 498, Table 2.
    """

    summary: ClassVar[str] = "Mooney-Rivlin with stiffening fibres (Heidlauf and Roehrle 2014)"
    parameter_sets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # [Pa] [1], Table 2. The fibres' numbers come with the effect.
        "heidlauf-roehrle-2014": {"c10": 6.352e-7, "c01": 3.627e3},
        # [Pa] The thesis, which cites [1]; its c10 is 1e11 times larger, so its tissue is 18 times stiffer.
        "thesis": {"c10": 6.352e4, "c01": 3.627e3},
    }

    # [1], Table 2.
    c10: float = number(6.352e-7, unit="Pa", within="[0, inf)", doc="modulus of the first invariant")
    c01: float = number(3.627e3, unit="Pa", within="[0, inf)", doc="modulus of the second invariant")
    fibre_modulus: float = number(
        0.0, unit="Pa", within="[0, inf)", doc="modulus of the fibres", effect="fibre_stiffening", on=2.756e-2
    )
    fibre_exponent: float = number(
        43.373, within="(0, inf)", doc="exponent of the fibres", effect="fibre_stiffening", on=43.373
    )

    @property
    def constants(self) -> Array:
        rest = 2.0 * (self.c10 + 2.0 * self.c01)
        return np.array([self.c10, self.c01, rest, self.fibre_modulus, self.fibre_exponent])

    def functions(self) -> MaterialFunctions:
        from myobridge_plugins.material import transversely_isotropic_kernels as kernels

        return MaterialFunctions(kernels.energy, kernels.stress, kernels.tangent)


@hookimpl
def myobridge_materials():
    return {"transversely_isotropic": TransverselyIsotropic}
