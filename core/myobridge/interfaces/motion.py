"""Motion of a solid, and what it answers about one: balance, works, looks."""

from __future__ import annotations

from typing import Any, NamedTuple

import attrs
import numpy as np

from myobridge.interfaces.active_law import Array

__all__ = ["Balance", "Matrix", "Motion", "VisibleMesh", "Works"]

Matrix = Any
"""A dense ndarray or a scipy sparse array."""


@attrs.frozen(eq=False)
class Motion:
    """State of a solid.

    Attributes
    ----------
    displacement : ndarray, shape (n_unknowns,)
        Free displacements [m].
    velocity : ndarray, shape (n_unknowns,)
        Their rates [m/s]; without inertia the differences over the last step.
    multiplier : ndarray, shape (n_constraints,)
        Lagrange multipliers, such as the pressure [Pa]; empty without constraint.
    """

    displacement: Array
    velocity: Array
    multiplier: Array = attrs.field(factory=lambda: np.empty(0))


class Balance(NamedTuple):
    """Balance of momentum (and constraint) at a point, with its tangent where asked for.

    Attributes
    ----------
    force : ndarray, shape (n_unknowns,)
        Internal (with active) minus external force [N].
    stiffness : matrix or None
        d force / d displacement [N/m].
    damping : matrix or None
        d force / d velocity [N s/m]; None when nothing depends on the rate.
    constraint : ndarray, shape (n_constraints,), or None
        Residual of the constraint; `force` holds the gradient's transpose times the multiplier.
    constraint_gradient : matrix, shape (n_constraints, n_unknowns), or None
        d constraint / d displacement.
    constraint_compliance : matrix, shape (n_constraints, n_constraints), or None
        Minus d constraint / d multiplier, positive semi-definite; None where it is zero.
    magnitude : float
        Norm of the terms that cancel in `force` [N]: a force below their round-off is zero to the solver.
    symmetric : bool
        Whether stiffness (and damping) is symmetric; follower loads are not.
    constraint_magnitude : float
        Norm of the terms that cancel in `constraint`, in its unit: of the volumes that J and 1 stand for, say.
    acting_gradient : matrix, shape (n_constraints, n_unknowns), or None
        Gradient whose transpose acts on the multipliers in `force`, where it is not `constraint_gradient`.
    """

    force: Array
    stiffness: Matrix | None = None
    damping: Matrix | None = None
    constraint: Array | None = None
    constraint_gradient: Matrix | None = None
    constraint_compliance: Matrix | None = None
    magnitude: float = 0.0
    symmetric: bool = True
    constraint_magnitude: float = 0.0
    acting_gradient: Matrix | None = None


class Works(NamedTuple):
    """Work [J] done on a solid over a step.

    Attributes
    ----------
    external : float
        Of loads and of supports that move.
    active : float
        Of a law without potential, positive when it moves the solid.
    viscous : float
        Taken away by viscosity, at least 0.
    numerical : float
        Added by the discretisation itself.
    """

    external: float = 0.0
    active: float = 0.0
    viscous: float = 0.0
    numerical: float = 0.0


class VisibleMesh(NamedTuple):
    """What a body looks like: nodes, cells, and meshio's word for the kind of cell (``triangle6``, ``tetra10`` ...).

    `points` is (n_points, 3) [m], `cells` (n_cells, nodes of a cell) in the order of that kind.
    """

    points: Array
    cells: Any
    kind: str
