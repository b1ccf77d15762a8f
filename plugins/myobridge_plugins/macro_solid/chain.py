"""Chain of springs and point masses."""

from __future__ import annotations

from typing import ClassVar, final

import attrs
import numpy as np
import scipy.sparse as sparse

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MacroSolid
from myobridge.parameters import integer
from myobridge_plugins.macro_solid.line import Line, LineMesh


@final
@attrs.frozen(eq=False)
class Chain(Line):
    r"""`n` springs between `n + 1` point masses (thesis, Example 1.32).

    .. math:: W = \sum_{i=1}^{n} \frac{E A}{2 h} \bigl(|x_{i} - x_{i-1}| - h\bigr)^2, \qquad h = L / n

    One site a spring. It is the rope with linear elements and a lumped mass.
    Departures: the force factor is kappa h (printed 2 kappa h), and the two end masses are half the others, so that
    the total is the rope's and the limit is reached at order 2.
    """

    summary: ClassVar[str] = "n springs between point masses, in 1D or 3D (thesis, Example 1.32)"

    springs: int = integer(10, within="[1, inf)", doc="number of springs")

    def cut(self) -> LineMesh:
        n = self.springs
        step = self.length / n
        spring = np.arange(n)
        rows, nodes_of = np.concatenate([spring, spring]), np.concatenate([spring, spring + 1])
        values = np.repeat([-1.0 / step, 1.0 / step], n)
        derivative = sparse.csr_array((values, (rows, nodes_of)), shape=(n, n + 1))
        mass = np.full(n + 1, 1.0 / n)
        mass[[0, -1]] *= 0.5
        nodes = np.linspace(0.0, self.length, n + 1)
        return LineMesh(nodes, 0.5 * (nodes[1:] + nodes[:-1]), derivative, np.full(n, step), mass)


@hookimpl
def myobridge_macro_solids() -> dict[str, type[MacroSolid]]:
    return {"chain": Chain}
