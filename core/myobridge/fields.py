"""Fields: what a body looks like at one state, on the nodes and cells of its visible mesh."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import attrs
import numpy as np

from myobridge.errors import MyobridgeError, PluginError, nearest
from myobridge.interfaces import Array, MacroSolid, Motion, VisibleMesh

__all__ = ["FIELDS", "FieldSnapshot", "snapshot"]

FIELDS: Mapping[str, str] = {
    "displacement": "displacement of the nodes [m]",
    "pressure": "hydrostatic pressure, positive in compression [Pa]",
    "stretch": "fibre stretch [-]",
    "tension": "nominal active stress along the fibre [Pa]",
    "activation": "activation [-]",
    "sarcomere_density": "density of sarcomeres relative to a full muscle [-]",
    "fibre": "fibre direction",
    "J": "volume ratio [-]",
}
"""Fields that solids and cross-bridges know; a solid may add its own. What a scene has not is not written."""

# Linear meshes can have as many nodes as cells; then displacement lives at nodes, anything else on cells.
_AT_NODES = ("displacement",)


@attrs.frozen(eq=False)
class FieldSnapshot:
    """Fields of a body at one state.

    Attributes
    ----------
    time : float
        Time [s], or the scale of a state of statics.
    step : int
        Steps from the start.
    at_nodes : mapping
        Name to array (n_points,) or (n_points, 3).
    on_cells : mapping
        Name to array (n_cells,) or (n_cells, 3); NaN where a cell has no sites.
    label : str
        What `time` is: ``time`` or ``scale``.
    """

    time: float
    step: int
    at_nodes: Mapping[str, Array]
    on_cells: Mapping[str, Array]
    label: str = "time"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fields, in the order of `FIELDS`, others behind."""
        known = list(FIELDS)
        found = {*self.at_nodes, *self.on_cells}
        return tuple(sorted(found, key=lambda name: (known.index(name) if name in known else len(known), name)))

    def __getitem__(self, name: str) -> Array:
        for where in (self.at_nodes, self.on_cells):
            if name in where:
                return where[name]
        raise MyobridgeError(f"the result has no field '{name}'. {nearest(name, self.names)}")

    def sharing(self, earlier: FieldSnapshot) -> FieldSnapshot:
        """The same, holding the arrays of `earlier` where they are equal: what does not change is kept once."""

        def shared(now: Mapping[str, Array], before: Mapping[str, Array]) -> dict[str, Array]:
            return {
                name: before[name] if name in before and np.array_equal(before[name], array, equal_nan=True) else array
                for name, array in now.items()
            }

        return attrs.evolve(
            self,
            at_nodes=shared(self.at_nodes, earlier.at_nodes),
            on_cells=shared(self.on_cells, earlier.on_cells),
        )


def snapshot(
    solid: MacroSolid,
    mesh: VisibleMesh,
    motion: Motion,
    time: float,
    at_sites: Mapping[str, Array],
    *,
    names: Iterable[str] | None = None,
    step: int = 0,
    label: str = "time",
) -> FieldSnapshot:
    """Fields of `solid` in `motion`, with what cross-bridges know at its sites averaged over cells.

    Parameters
    ----------
    mesh : VisibleMesh
        That of the solid.
    time : float
        Time [s], or scale: see `label`.
    at_sites : mapping
        Name to array (n_sites,), such as ``tension``.
    names : iterable of str, optional
        Fields to keep; ``displacement`` always is. All that exist without.

    Raises
    ------
    PluginError
        If the solid answers with an array of another shape.
    """
    wanted = None if names is None else {"displacement", *names}
    n_points, n_cells = len(mesh.points), len(mesh.cells)
    at_nodes: dict[str, Array] = {}
    on_cells: dict[str, Array] = {}
    for name, field in solid.visible_fields(motion, time).items():
        if wanted is not None and name not in wanted:
            continue
        array = np.array(field, dtype=float)
        nodal = len(array) == n_points and (n_points != n_cells or name in _AT_NODES)
        (at_nodes if nodal else on_cells)[name] = array
    sites = dict(at_sites)
    if "stretch" not in at_nodes and "stretch" not in on_cells and solid.n_sites:
        sites.setdefault("stretch", solid.stretch(motion.displacement, time))
    for name, values in sites.items():
        if name not in at_nodes and name not in on_cells and (wanted is None or name in wanted):
            on_cells[name] = np.array(solid.on_cells(values), dtype=float)
    _check(solid, {**at_nodes}, n_points, "nodes")
    _check(solid, {**on_cells}, n_cells, "cells")
    if at_nodes.get("displacement", np.empty(0)).shape != (n_points, 3):
        raise PluginError(f"{type(solid).__name__}.visible_fields: expected a displacement of shape ({n_points}, 3)")
    return FieldSnapshot(float(time), step, at_nodes, on_cells, label)


def _check(solid: MacroSolid, fields: Mapping[str, Array], count: int, where: str) -> None:
    for name, array in fields.items():
        if array.shape not in ((count,), (count, 3)):
            raise PluginError(
                f"{type(solid).__name__}: field '{name}' has shape {array.shape}; expected ({count},) or ({count}, 3) "
                f"on {where}"
            )
