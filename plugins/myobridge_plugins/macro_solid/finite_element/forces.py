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

__all__ = [
    "at_points",
    "balance",
    "bulk_energy",
    "external_stiffness",
    "per_support",
    "support_work",
    "total_force",
]


def balance(
    body: Body,
    motion: Motion,
    law: ActiveLaw | None,
    time: float,
    bulk_modulus: float | None,
    *,
    rate: bool,
    tangent: bool,
) -> Balance:
    """Balance of the free numbers; a bulk modulus that is not finite keeps the volume.

    Where the law depends on the rate, the stiffness is the derivative at a given stretch rate: that at a given velocity
    has one more term, unsymmetric, which vanishes where fibres do not turn. Newton's method hardly misses it.
    """
    assembly, free = body.assembly, body.free
    full, pressure = body.displacement(motion.displacement, time), body.pressure(motion.multiplier)
    tension = stiffness = sensitivity = None
    if law is not None and body.n_sites:
        # A law with a potential does not depend on the rate.
        moving = body.velocity(motion.velocity, time) if rate and not law.has_potential else None
        here = assembly.kinematics(full, moving)
        answer = law.evaluate(here.stretch[: body.n_sites], here.rate[: body.n_sites])
        tension, stiffness = at_points(body, answer.tension), at_points(body, answer.stiffness)
        if moving is not None and answer.rate_sensitivity is not None:
            sensitivity = at_points(body, answer.rate_sensitivity)
    sums = assembly.sums(full, pressure, tension, stiffness, tangent=tangent)
    external = body.loading.external(full, time)
    largest = body.modulus + sums.largest + float(np.abs(pressure).max(initial=0.0))
    found = Balance(
        (sums.force + body.loading.bedding(full, time) - external)[free],
        magnitude=largest * body.section + float(np.linalg.norm(external)),
        symmetric=not body.loading.follows,
    )
    soft = bulk_modulus is not None and math.isfinite(bulk_modulus)
    if pressure.size:
        constraint = sums.constraint[body.free_multipliers]
        if soft:
            constraint = constraint - body.multiplier_mass @ motion.multiplier / bulk_modulus
        found = found._replace(constraint=constraint, constraint_magnitude=body.constraint_magnitude)
    if not tangent:
        return found
    pattern = assembly.pattern
    matrix = pattern.stiffness.matrix(sums.stiffness)
    for stored in (True, False):
        added = body.loading.stiffness(full, time, stored=stored)
        if added is not None:
            matrix = matrix + added[free][:, free]
    found = found._replace(stiffness=matrix)
    if pressure.size:
        found = found._replace(constraint_gradient=pattern.gradient.matrix(sums.gradient))
        if soft:
            found = found._replace(constraint_compliance=body.multiplier_mass / bulk_modulus)
    if sensitivity is not None:
        damping = assembly.sums(full, 0.0 * pressure, None, sensitivity, tangent=True, passive=False)
        found = found._replace(damping=pattern.stiffness.matrix(damping.stiffness))
    return found


def total_force(body: Body, motion: Motion, tension: Array, time: float) -> Array:
    """Internal minus external force on every number, held ones included [N]: there it is the reaction."""
    full, pressure = body.displacement(motion.displacement, time), body.pressure(motion.multiplier)
    active = at_points(body, tension) if tension.size else None
    sums = body.assembly.sums(full, pressure, active, None, tangent=False)
    return sums.force + body.loading.bedding(full, time) - body.loading.external(full, time)


def support_work(
    body: Body, stage: Motion, law: ActiveLaw | None, stage_time: float, times: tuple[float, float]
) -> float:
    """Reactions at a stage times the way of what is held, between two times [J]."""
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


def bulk_energy(body: Body, full: Array, bulk_modulus: float | None) -> float:
    """Energy stored in the change of volume [J]; none where the volume is kept."""
    if bulk_modulus is None or not math.isfinite(bulk_modulus):
        return 0.0
    change = body.assembly.sums(full, np.zeros(body.grid.n_multipliers), None, None, tangent=False).constraint
    free = change[body.free_multipliers]
    return 0.5 * bulk_modulus * float(free @ body.projection(free))


def at_points(body: Body, values: Array) -> Array:
    """Values at the sites as values at all points: tendon pulls with nothing."""
    n = body.grid.n_points
    if values.size == n:
        return np.ascontiguousarray(values)
    found = np.zeros(n)
    found[: values.size] = values
    return found
