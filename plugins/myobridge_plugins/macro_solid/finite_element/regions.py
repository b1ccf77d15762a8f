"""Regions: named parts of a mesh that are made of something else."""

from __future__ import annotations

from typing import final

import attrs

from myobridge.interfaces import Fibres, Material
from myobridge.parameters import flag, part, text

__all__ = ["Region"]


@final
@attrs.frozen(kw_only=True)
class Region:
    """A named part of the mesh with its own tissue.

    Parameters
    ----------
    name : str
        Subdomain of the mesh.
    material : Material, optional
        Its passive law; the solid's without.
    fibres : Fibres, optional
        Its fibre directions; the solid's without.
    cross_bridges : bool
        Whether it has cross-bridges; tendon has none, and then no population is allocated there.
    """

    name: str = text(doc="subdomain of the mesh")
    material: Material | None = part("material", None, doc="passive law of the region; the solid's when left out")
    fibres: Fibres | None = part("fibres", None, doc="fibre directions; the solid's when left out")
    cross_bridges: bool = flag(True, doc="whether the region has cross-bridges (tendon: false)")
