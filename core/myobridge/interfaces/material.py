r"""Material: the passive law of the tissue, as compiled functions over a few points at a time.

.. math:: W = W(F, N), \qquad P = \partial W / \partial F, \qquad A = \partial P / \partial F

`F` is the deformation gradient (3 x 3 also in plane strain, with :math:`F_{33} = 1`), `N` the unit fibre direction in
the reference. `W` is an energy per reference volume [J/m^3], `P` the first Piola-Kirchhoff stress [Pa]. The volumetric
part of nearly incompressible tissue is not the material's: the solid adds ``p (J - 1)``. A material must be stress free
at ``F = I``, or the body would move without a load.

The functions work on `LANES` points side by side. An array of ``k`` rows is flat, ``(k * LANES,)``: row ``r`` of
lane ``l`` stands at ``r * LANES + l``, so that one loop over the lanes becomes vector instructions::

    @material_function
    def stress(n, state, out, constants):
        for lane in range(n):
            ...

* ``state``: rows 0-8 are ``F[i, J]`` at row ``3 * i + J``, rows 9-11 are ``N``.
* ``energy`` writes row 0: `W`.
* ``stress`` writes rows 0-8: ``P[i, J]`` at row ``3 * i + J``.
* ``tangent`` writes the same rows 0-8, then the 45 entries of the upper triangle of `A`, which is symmetric: with
  ``r = 3 * i + J``, ``c = 3 * k + L`` and ``r <= c``, dP[i, J] / dF[k, L] at row ``9 + r * (17 - r) // 2 + c``.

``n`` is at most `LANES`; lanes beyond it hold anything and must not be written.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

from myobridge.compiled import LANES, CompiledFunction
from myobridge.interfaces.active_law import Array

__all__ = ["LANES", "Material", "MaterialFunctions"]


class MaterialFunctions(NamedTuple):
    """Compiled energy, stress and tangent of a material, made with `myobridge.compiled.material_function`."""

    energy: CompiledFunction
    stress: CompiledFunction
    tangent: CompiledFunction


class Material(ABC):
    """Abstract material; its parameters are the attributes of a frozen class.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    inherent_effects : frozenset of str
        Effects that are always there; optional ones are tied to a parameter.
    """

    summary: ClassVar[str] = ""
    inherent_effects: ClassVar[frozenset[str]] = frozenset()

    @property
    @abstractmethod
    def constants(self) -> Array:
        """The numbers that the compiled functions are given, shape (any,); switches of a form are numbers too."""

    @abstractmethod
    def functions(self) -> MaterialFunctions:
        """Compiled functions; import their module here, so that nothing is compiled before it is needed."""
