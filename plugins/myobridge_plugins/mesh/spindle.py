"""The two-dimensional muscle: thick in the middle, narrow at the ends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, final

import attrs
import numpy as np

from myobridge.errors import ParameterError
from myobridge.hookspecs import hookimpl
from myobridge.interfaces import MeshSource
from myobridge.mesh_check import check_mesh
from myobridge.parameters import choice, integer, number
from myobridge_plugins.mesh.grid import grid, moved
from myobridge_plugins.mesh.outline import Outline

if TYPE_CHECKING:
    from skfem import Mesh  # pyright: ignore[reportMissingTypeStubs]

__all__ = ["Spindle"]


@final
@attrs.frozen
class Spindle(MeshSource):
    r"""Muscle of plane strain between two straight ends, symmetric about y = 0.

    .. math:: X = \big(L s,\; \tfrac12 \eta\, w(s)\big), \quad 0 \le s \le 1, \; -1 \le \eta \le 1, \qquad
              w(s) = w_e + (w_b - w_e)\,\sin^2\!\Big(\pi\,\frac{s - \tau}{1 - 2\tau}\Big)

    w is constant in the tendons, the share tau of the length at each end. Area: L (w_e + (1 - 2 tau) (w_b - w_e) / 2).
    A refinement halves every cell and puts the new nodes onto the curved outline; the old nodes stay.

    Boundaries: left, right (the ends), bottom, top (the outline). Subdomains: muscle; with tendons also tendon_left,
    tendon_right and tendon (both).

    Parameters
    ----------
    length, width, end_width : float
        From end to end, at the belly, at the ends [m].
    tendon : float
        Share of the length that the tendon at each end takes.
    cells : int
        Cells along the length, before refinement; the tendons get their share of them, at least one each.
    across : int, optional
        Cells across; by default an even number that makes them about square.
    shape : {"triangle", "quadrilateral"}
        Of the cells.
    refinements : int
        How often every cell is halved in both directions.

    Departures
    ----------
    The thesis gives a picture of its mesh and no numbers; length and width are those of the scenes of this project, the
    outline is ours.

    References
    ----------
    .. [1] The thesis, Fig. 2 of the chapter on numerical results (a coarse mesh and two uniform refinements).
    """

    summary: ClassVar[str] = "2D muscle, thick in the middle and narrow at the ends, with or without tendons"

    length: float = number(0.1, unit="m", within="(0, inf)", doc="from end to end")
    width: float = number(0.03, unit="m", within="(0, inf)", doc="at the belly")
    end_width: float = number(0.012, unit="m", within="(0, inf)", doc="at the ends")
    tendon: float = number(0.0, within="[0, 0.5)", doc="share of the length that the tendon at each end takes")
    cells: int = integer(24, within="[2, inf)", doc="cells along the length, before refinement")
    across: int | None = integer(None, within="[1, inf)", doc="cells across; about square ones by default")
    shape: str = choice("triangle", ("triangle", "quadrilateral"), doc="of the cells")
    refinements: int = integer(0, within="[0, 8]", doc="how often every cell is halved in both directions")

    def __attrs_post_init__(self) -> None:
        if self.end_width > self.width:
            raise ParameterError("end_width", f"is {self.end_width!r}; expected a number in (0, {self.width}] [m]")

    def mesh(self) -> Mesh:
        outline = Outline(self.width, self.end_width, self.tendon)
        levels = outline.levels(self.cells, self.refinements)
        area = self.end_width + (0.5 - self.tendon) * (self.width - self.end_width)
        across = self.across or 2 * math.ceil(0.5 * self.cells * area / self.length)
        flat = grid(self.shape, [levels, np.linspace(-1.0, 1.0, across * 2**self.refinements + 1)])
        s, eta = flat.p
        mesh = moved(flat, np.stack([self.length * s, 0.5 * eta * outline.at(s)]))
        mesh = mesh.with_subdomains(outline.parts(s[flat.t].mean(axis=0)))
        check_mesh(mesh, "cells")
        return mesh


@hookimpl
def myobridge_meshes():
    return {"spindle": Spindle}
