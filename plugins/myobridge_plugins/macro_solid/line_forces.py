r"""Forces of an elastic line: at a point, and over a step as a discrete gradient.

.. math:: P = \Bigl(E (\lambda - 1) + T + \eta \lambda^2 \dot\lambda\Bigr) \frac{g}{\lambda}, \qquad
          \bar P = \Bigl(\frac{2}{\lambda_0 + \lambda_1}
          \bigl(E (\bar\lambda - 1) + \bar T\bigr) + \eta \frac{\lambda_1^2 - \lambda_0^2}{2 \Delta t}\Bigr) \bar g

with bars for means of both ends. Energies quadratic in the stretch change by exactly :math:`\bar P \cdot (g_1 - g_0)`,
and the force is along the mean line, so that the angular momentum is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from myobridge.interfaces import ActiveLaw, Array, Balance, Motion, Works

if TYPE_CHECKING:
    from myobridge_plugins.macro_solid.line import Line

__all__ = ["balance", "step_balance", "step_works", "viscous_force"]


def balance(
    line: Line, motion: Motion, law: ActiveLaw | None, time: float, *, rate: bool = True, tangent: bool = False
) -> Balance:
    """Balance at a point, as `MacroSolid.balance` has it."""
    gradient, stretch = line.gradient(motion.displacement)
    direction = gradient / stretch[:, None]
    stress = line.modulus * (stretch - 1.0)
    slope: Array | float = line.modulus
    sensitivity: Array | None = None
    viscosity = line.viscosity if rate else None
    if law is not None or viscosity is not None:
        speed = np.zeros_like(stretch)
        if rate:
            moving = (line.derivative @ motion.velocity).reshape(gradient.shape)
            speed = np.einsum("ia,ia->i", direction, moving)
        if law is not None:
            answer = law.evaluate(stretch, speed)
            stress = stress + answer.tension
            slope = slope + answer.stiffness
            sensitivity = answer.rate_sensitivity
        if viscosity is not None:
            stress = stress + viscosity * stretch**2 * speed
            slope = slope + 2.0 * viscosity * stretch * speed
            sensitivity = viscosity * stretch**2 + (0.0 if sensitivity is None else sensitivity)
    external = line.external_force(motion.displacement, time)
    force = line.transposed @ ((line.site_volumes * stress)[:, None] * direction).ravel() - external
    magnitude = _magnitude(line, slope, stress, external)
    if not tangent:
        return Balance(force, magnitude=magnitude)
    along = np.einsum("ia,ib->iab", direction, direction)
    across = np.eye(line.n_axes) - along
    blocks = along * (line.site_volumes * slope)[:, None, None]
    blocks += across * (line.site_volumes * stress / stretch)[:, None, None]
    damping = None
    if sensitivity is not None:
        damping = line.between(along * (line.site_volumes * sensitivity)[:, None, None])
    return Balance(force, line.between(blocks), damping, magnitude=magnitude)


def step_balance(
    line: Line, start: Motion, end: Motion, law: ActiveLaw | None, times: tuple[float, float], *, tangent: bool
) -> Balance:
    """Balance over a step, as `MacroSolid.step_balance` has it."""
    dt, half = times[1] - times[0], 0.5 * (times[0] + times[1])
    (before, first), (after, last) = line.gradient(start.displacement), line.gradient(end.displacement)
    both, middle = first + last, 0.5 * (before + after)
    stress = line.modulus * (0.5 * both - 1.0)
    slope: Array | float = 0.5 * line.modulus
    if law is not None:
        answer = law.evaluate(0.5 * both, (last - first) / dt)
        stress, slope = stress + answer.tension, slope + 0.5 * answer.stiffness
        if answer.rate_sensitivity is not None:
            slope = slope + answer.rate_sensitivity / dt
    along = 2.0 * stress / both  # second Piola-Kirchhoff stress, and its derivative by the stretch at the end
    change = 2.0 * slope / both - along / both
    if line.viscosity is not None:
        along = along + line.viscosity * (last**2 - first**2) / (2.0 * dt)
        change = change + line.viscosity * last / dt
    external = line.external_force(0.5 * (start.displacement + end.displacement), half)
    force = line.transposed @ ((line.site_volumes * along)[:, None] * middle).ravel() - external
    magnitude = _magnitude(line, 2.0 * slope, stress, external)
    if not tangent:
        return Balance(force, magnitude=magnitude, symmetric=False)
    blocks = np.einsum("i,ia,ib->iab", line.site_volumes * change / last, middle, after)
    blocks += (0.5 * line.site_volumes * along)[:, None, None] * np.eye(line.n_axes)
    return Balance(force, line.between(blocks), magnitude=magnitude, symmetric=False)


def step_works(line: Line, start: Motion, end: Motion, law: ActiveLaw | None, times: tuple[float, float]) -> Works:
    """Works over a step, as `MacroSolid.step_works` has them."""
    dt, half = times[1] - times[0], 0.5 * (times[0] + times[1])
    first, last = line.stretch(start.displacement, times[0]), line.stretch(end.displacement, times[1])
    middle = 0.5 * (start.displacement + end.displacement)
    external = float(line.external_force(middle, half) @ (end.displacement - start.displacement))
    active, viscous = 0.0, 0.0
    if law is not None and not law.has_potential:
        tension = law.evaluate(0.5 * (first + last), (last - first) / dt).tension
        active = -float(np.dot(line.site_volumes * tension, last - first))
    if line.viscosity is not None:
        viscous = line.viscosity / dt * float(np.dot(line.site_volumes, 0.25 * (last**2 - first**2) ** 2))
    return Works(external, active, viscous)


def viscous_force(line: Line, motion: Motion) -> Array | None:
    """Share of viscosity in the force [N]; None without."""
    if line.viscosity is None:
        return None
    gradient, _ = line.gradient(motion.displacement)
    moving = (line.derivative @ motion.velocity).reshape(gradient.shape)
    along = line.viscosity * np.einsum("ia,ia->i", gradient, moving)
    return line.transposed @ ((line.site_volumes * along)[:, None] * gradient).ravel()


def _magnitude(line: Line, slope: Array | float, stress: Array, external: Array) -> float:
    """Positions are rounded as the length is: that round-off, times the stiffness, is what the force cannot beat."""
    along = line.area * (slope + np.abs(stress)) * line.length / line.mesh.lengths
    return float(np.sqrt(along @ along) + np.sqrt(external @ external))
