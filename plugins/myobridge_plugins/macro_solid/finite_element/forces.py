r"""Forces of a body: balance, reactions and stored energy.

.. math:: f = \int P : \nabla N + f_{bedding} - f_{external}, \qquad
          c = \int \psi (J - 1) - \frac{1}{\kappa} M_p\,p, \qquad
          W = \int W(F) + \frac{\kappa}{2} \lVert \Pi (J - 1) \rVert^2

with `Pi` the projection onto the multipliers: `p` is ``kappa Pi (J - 1)``, so the last term is :math:`p^2 / 2 \kappa`.
"""

from __future__ import annotations

import math

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, Balance, Matrix, Motion
from myobridge_plugins.macro_solid.finite_element.body import Body
from myobridge_plugins.macro_solid.finite_element.viscosity import add_viscosity

__all__ = [
    "at_points",
    "balance",
    "cancelled",
    "elastic_energy",
    "external_stiffness",
    "per_support",
    "support_work",
    "total_force",
    "viscous_force",
    "volume_change",
    "with_constraint",
]


def cancelled(stiffness: Array) -> float:
    """Stress [Pa] that cancels in a tension of a given `stiffness` by the stretch, in terms of its round-off.

    A stretch near 1 is known to half an epsilon, a thirty-second of the share of the magnitude that a solver takes for
    zero. Stiff heads multiply it.
    """
    return float(np.abs(stiffness).max(initial=0.0)) / 32.0


def balance(
    body: Body,
    motion: Motion,
    law: ActiveLaw | None,
    time: float,
    bulk_modulus: float | None,
    viscosity: float | None,
    *,
    rate: bool,
    tangent: bool,
) -> Balance:
    """Balance of the free numbers; a bulk modulus that is not finite keeps the volume.

    Where something depends on the rate, the stiffness is the derivative at a given rate of stretch and strain: that at
    a given velocity has one more term, unsymmetric, which vanishes where nothing turns or deforms meanwhile. Newton's
    method hardly misses it.
    """
    assembly, free = body.assembly, body.free
    full, pressure = body.displacement(motion.displacement, time), body.pressure(motion.multiplier)
    viscous = bool(viscosity) and rate
    moving = body.velocity(motion.velocity, time) if rate else None
    tension = stiffness = sensitivity = None
    if law is not None and body.n_sites:
        # A law with a potential does not depend on the rate.
        here = assembly.kinematics(full, None if law.has_potential else moving)
        answer = law.evaluate(here.stretch[: body.n_sites], here.rate[: body.n_sites])
        tension, stiffness = at_points(body, answer.tension), at_points(body, answer.stiffness)
        if rate and not law.has_potential and answer.rate_sensitivity is not None:
            sensitivity = at_points(body, answer.rate_sensitivity)
    sums = assembly.sums(full, pressure, tension, stiffness, tangent=tangent)
    damping = None
    if tangent and sensitivity is not None:
        damping = assembly.sums(full, 0.0 * pressure, None, sensitivity, tangent=True, passive=False).stiffness
    elif tangent and viscous:
        damping = np.zeros_like(sums.stiffness)
    largest = body.modulus + sums.largest + float(np.abs(pressure).max(initial=0.0))
    if stiffness is not None:
        largest += cancelled(stiffness)
    if viscous:
        assert viscosity is not None
        assert moving is not None
        tangents = (sums.stiffness, damping) if tangent else ()
        largest += add_viscosity(assembly, viscosity, full, moving, sums.force, *tangents)
    external = body.loading.external(full, time)
    found = Balance(
        (sums.force + body.loading.bedding(full, time) - external)[free],
        magnitude=largest * body.section + float(np.linalg.norm(external)),
        symmetric=not body.loading.follows,
    )
    found = with_constraint(
        body, found, sums.constraint, sums.gradient if tangent else None, motion.multiplier, bulk_modulus
    )
    if not tangent:
        return found
    matrix = assembly.pattern.stiffness.matrix(sums.stiffness)
    for stored in (True, False):
        added = body.loading.stiffness(full, time, stored=stored)
        if added is not None:
            matrix = matrix + added[free][:, free]
    return found._replace(
        stiffness=matrix, damping=None if damping is None else assembly.pattern.stiffness.matrix(damping)
    )


def with_constraint(
    body: Body,
    found: Balance,
    change: Array,
    gradient: Array | None,
    multiplier: Array,
    bulk_modulus: float | None,
) -> Balance:
    """The balance with its constraint: `change` of volume on all numbers, and the data of its gradient where wanted."""
    if not multiplier.size:
        return found
    constraint, compliance = change[body.free_multipliers], None
    if bulk_modulus is not None and math.isfinite(bulk_modulus):
        constraint = constraint - body.multiplier_mass @ multiplier / bulk_modulus
        compliance = body.multiplier_mass / bulk_modulus if gradient is not None else None
    return found._replace(
        constraint=constraint,
        constraint_magnitude=body.constraint_magnitude,
        constraint_gradient=None if gradient is None else body.assembly.pattern.gradient.matrix(gradient),
        constraint_compliance=compliance,
    )


def viscous_force(body: Body, motion: Motion, time: float, viscosity: float) -> Array:
    """Share of viscosity in the internal force on every number [N]."""
    force = np.zeros(body.n_full)
    full, moving = body.displacement(motion.displacement, time), body.velocity(motion.velocity, time)
    add_viscosity(body.assembly, viscosity, full, moving, force)
    return force


def total_force(body: Body, motion: Motion, tension: Array, time: float, viscosity: float | None = None) -> Array:
    """Internal minus external force on every number, held ones included [N]: there it is the reaction."""
    full, pressure = body.displacement(motion.displacement, time), body.pressure(motion.multiplier)
    active = at_points(body, tension) if tension.size else None
    sums = body.assembly.sums(full, pressure, active, None, tangent=False)
    force = sums.force + body.loading.bedding(full, time) - body.loading.external(full, time)
    return force + viscous_force(body, motion, time, viscosity) if viscosity else force


def support_work(
    body: Body, stage: Motion, law: ActiveLaw | None, stage_time: float, times: tuple[float, float]
) -> float:
    """Reactions at a stage times the way of what is held, between two times [J].

    Without those of viscosity: what it takes is booked on the free numbers alone (`viscous_force`).
    """
    if not body.held.moving:
        return 0.0
    start, end = (body.held.displacement(np.zeros(body.n_full), time) for time in times)
    if np.array_equal(start, end):
        return 0.0
    tension = np.empty(0)
    if law is not None and body.n_sites:
        here = body.assembly.kinematics(
            body.displacement(stage.displacement, stage_time), body.velocity(stage.velocity, stage_time)
        )
        tension = law.evaluate(here.stretch[: body.n_sites], here.rate[: body.n_sites]).tension
    return float(total_force(body, stage, tension, stage_time) @ (end - start))


def per_support(body: Body, force: Array) -> dict[str, Array]:
    """Sum over each support of a force on all numbers; a number that two supports hold counts for the first."""
    left, found = force.copy(), dict[str, Array]()
    for support, numbers in zip(body.held.supports, body.held.numbers, strict=True):
        axes = numbers % body.grid.dimension
        total = np.zeros(body.grid.dimension)
        np.add.at(total, axes, left[numbers])
        left[numbers] = 0.0
        found[support.boundary] = found[support.boundary] + total if support.boundary in found else total
    return found


def external_stiffness(body: Body, displacement: Array, time: float) -> Matrix | None:
    """Minus the derivative of the external force, free part [N/m]; None for dead loads."""
    found = body.loading.stiffness(body.displacement(displacement, time), time, stored=False)
    return None if found is None else found[body.free][:, body.free]


def elastic_energy(body: Body, full: Array, bulk_modulus: float | None) -> float:
    """Energy stored in tissue, bedding and the change of volume [J]; none is in a volume that is kept."""
    stored = body.assembly.energy(full) + body.loading.energy(full)
    if bulk_modulus is None or not math.isfinite(bulk_modulus):
        return stored
    change = volume_change(body, full)
    return stored + 0.5 * bulk_modulus * float(change @ body.projection(change))


def volume_change(body: Body, full: Array) -> Array:
    r"""What the free multipliers see of the change of volume, :math:`\int \psi (J - 1)` [m^3]."""
    pressure = np.zeros(body.grid.n_multipliers)
    sums = body.assembly.sums(full, pressure, None, None, tangent=False, passive=False)
    return sums.constraint[body.free_multipliers]


def at_points(body: Body, values: Array) -> Array:
    """Values at the sites as values at all points: tendon pulls with nothing."""
    n = body.grid.n_points
    if values.size == n:
        return np.ascontiguousarray(values)
    found = np.zeros(n)
    found[: values.size] = values
    return found
