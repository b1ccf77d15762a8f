r"""Starts: from what the solid says of its motion at t = 0 to one that a simulation can begin with.

``as_given``
    As it is. With inertia and a strict constraint it must lie on it, :math:`c(u) = 0` and :math:`B v + \dot c = 0`: a
    method that keeps the constraint would jump onto it in the first step, at speeds that tear the body apart.
``projected``
    The nearest displacement and velocity on the constraint, in the norm of the mass.
``equilibrium``
    At rest, in equilibrium under the loads and the activation just before t = 0, cross-bridges in their isometric
    steady state. The loads grow from nothing by natural continuation.
"""

from __future__ import annotations

from typing import NamedTuple

import attrs
import numpy as np

from myobridge.equilibria import Equilibria, SteadyTension
from myobridge.errors import SceneError
from myobridge.instant import just_before
from myobridge.interfaces import (
    Array,
    ContinuationStrategy,
    CrossBridgeModel,
    LinearSystem,
    MacroSolid,
    Matrix,
    Motion,
    NewtonProblem,
    TimeIntegrator,
)
from myobridge.solvers import (
    Ordinary,
    constraint_at,
    constraint_rate,
    elastic_multiplier,
    gradient_at,
    projected_displacement,
    projected_velocity,
)
from myobridge.steady_population import steady_population
from myobridge.stimulation import Stimulation

__all__ = ["STARTS", "Fibres", "Start", "begun"]

STARTS = ("as_given", "projected", "equilibrium")

# Of the size of the constraint, and of that of its rate: what a start may be off.
_OFF = 1e-8
# Of the tension: what that of a population may be off in the equilibrium, and how often it is corrected.
_EXACT, _MANY = 1e-11, 5
_NEWTON = Ordinary(tolerance=1e-10)


class Fibres(NamedTuple):
    """What a start needs to know of cross-bridges: model, activation over time, nominal tension at the sites [Pa]."""

    model: CrossBridgeModel
    stimulation: Stimulation
    unit: Array


@attrs.frozen(eq=False)
class Start:
    """Where a simulation begins.

    Attributes
    ----------
    motion : Motion
    population : ndarray or None
        Micro state (n_sites, m); the model's own where it is None.
    said : str
        What was done, for the progress; empty where nothing was.
    iterations : int
        Newton iterations that it took.
    """

    motion: Motion
    population: Array | None = None
    said: str = ""
    iterations: int = 0


def begun(how: str, solid: MacroSolid, integrator: TimeIntegrator, dt: float, fibres: Fibres | None) -> Start:
    """Start of a simulation.

    Parameters
    ----------
    how : str
        One of `STARTS`.
    dt : float
        Nominal step [s]: what supports do is looked at within it.

    Raises
    ------
    SceneError
        If the motion violates the constraint, or there is no equilibrium; the message says how far, or why.
    """
    if how not in STARTS:
        raise SceneError(f"scene.start: is {how!r}; expected one of {', '.join(STARTS)}")
    if how == "equilibrium":
        return _equilibrium(solid, dt, fibres)
    motion = solid.rest_motion()
    if not integrator.inertia:
        if how == "projected":
            raise SceneError(
                "scene.start: is 'projected', and without inertia the first step finds an equilibrium anyway; leave it "
                "out, or set it to 'equilibrium'"
            )
        return Start(motion)
    if not motion.multiplier.size:
        return Start(motion)
    elastic = elastic_multiplier(solid, motion.displacement, 0.0)
    if elastic is not None and not (how == "projected" and solid.stiff_constraint):
        return Start(attrs.evolve(motion, multiplier=elastic))
    if how == "projected":
        return _projected(solid, motion, dt)
    _check(solid, motion, dt)
    return Start(motion)


# ---------------------------------------------------------------------- on the constraint


def _check(solid: MacroSolid, motion: Motion, dt: float) -> None:
    violation, size = constraint_at(solid, motion.displacement, 0.0)
    off = float(np.linalg.norm(violation)) / size
    advice = "or set scene.start = 'projected' for the nearest one that does"
    if not off <= _OFF:
        raise SceneError(
            f"solid: the displacement at the start does not keep the volume: J - 1 is about {off:.3g}, and at most "
            f"{_OFF:g} is allowed. Give one that does, {advice}"
        )
    if not motion.velocity.any():
        return
    gradient = gradient_at(solid, motion.displacement, 0.0, motion.multiplier)
    rate = gradient @ motion.velocity
    allowed = _OFF * float(np.linalg.norm(abs(gradient) @ np.abs(motion.velocity)))
    moved = rate + constraint_rate(solid, motion.displacement, 0.0, dt)
    off = min(float(np.linalg.norm(rate)), float(np.linalg.norm(moved)))
    if not off <= allowed:
        raise SceneError(
            f"solid: the velocity at the start does not keep the volume: J changes at about {off / size:.3g} 1/s, and "
            f"at most {allowed / size:.2g} 1/s is allowed. Give one that does, {advice}"
        )


def _projected(solid: MacroSolid, motion: Motion, dt: float) -> Start:
    violation, size = constraint_at(solid, motion.displacement, 0.0)
    off = float(np.linalg.norm(violation)) / size
    displacement, moved, iterations = motion.displacement, 0.0, 0
    if off > 0.0:
        found = projected_displacement(solid, displacement, motion.multiplier, 0.0)
        if found.reason:
            raise SceneError(f"scene.start: cannot be projected, {found.reason}; give a displacement closer to it")
        moved = float(np.abs(found.displacement - displacement).max(initial=0.0))
        displacement, iterations = found.displacement, found.iterations
    velocity = projected_velocity(solid, motion.velocity, motion.multiplier, displacement, 0.0, dt)
    changed = float(np.abs(velocity - motion.velocity).max(initial=0.0))
    said = (
        f"projected in {iterations} corrections: J - 1 was about {off:.2g}, displacements changed by at most "
        f"{moved:.2g} m, velocities by {changed:.2g} m/s"
    )
    return Start(Motion(displacement, velocity, np.zeros_like(motion.multiplier)), None, said, iterations)


# ---------------------------------------------------------------------- in equilibrium


class _FullLoad(NewtonProblem):
    """Equilibrium under the full load, as Newton's methods see it."""

    def __init__(self, problem: Equilibria) -> None:
        self._problem = problem

    def residual(self, unknowns: Array) -> tuple[Array, float]:
        return self._problem.residual(unknowns, 1.0), self._problem.magnitude(unknowns, 1.0)

    def tangent(self, unknowns: Array) -> Matrix | LinearSystem:
        return self._problem.tangent(unknowns, 1.0)

    def admissible(self, unknowns: Array) -> bool:
        return self._problem.admissible(unknowns)


def _equilibrium(solid: MacroSolid, dt: float, fibres: Fibres | None) -> Start:
    time, tension = just_before(0.0, dt), None
    if fibres is not None:
        if not fibres.model.has_statics:
            raise SceneError(
                f"scene.start: is 'equilibrium', and {type(fibres.model).__name__} has no isometric steady state to "
                "start from; leave it out, or use another model"
            )
        tension = SteadyTension(fibres.model, fibres.stimulation.before(time), fibres.unit)
    if solid.n_unknowns == 0:
        motion = solid.rest_motion()
        if tension is None:
            return Start(motion)
        stretch = solid.stretch(motion.displacement, time)
        return Start(motion, steady_population(tension.model, tension.activation, stretch), "cross-bridges are steady")
    problem = Equilibria(solid, tension, of="load" if tension is None else "tension_and_load", time=time)
    obstacle = solid.statics_obstacle(problem.motion(problem.start), problem.law(problem.start, 1.0))
    if obstacle:
        raise SceneError(f"solid: {obstacle}")
    path = _natural().trace(problem, problem.start)
    if not path.completed:
        raise SceneError(f"scene.start: there is no equilibrium to start from: {path.reason}")
    last, iterations = path.points[-1], sum(point.iterations for point in path.points)
    unknowns, population = last.unknowns, None
    if tension is not None:
        unknowns, population, more = _as_counted(problem, tension, unknowns, time)
        iterations += more
    said = f"equilibrium under the loads before t = 0, in {len(path.points)} levels and {iterations} iterations"
    if last.negative_eigenvalues > 0:
        said += f"; it is unstable, with {last.negative_eigenvalues} negative eigenvalues"
    return Start(problem.motion(unknowns), population, said, iterations)


def _natural() -> ContinuationStrategy:
    from myobridge.registry import registry

    return registry().find("continuation", "natural").cls()


def _as_counted(problem: Equilibria, tension: SteadyTension, unknowns: Array, time: float) -> tuple[Array, Array, int]:
    """Equilibrium with the tension of the population itself, which is the steady one but for how a model counts heads.

    Otherwise what its bins miss would set the body in motion.
    """
    solid, iterations, unit = problem.solid, 0, tension.unit
    for _ in range(_MANY):
        stretch = solid.stretch(problem.motion(unknowns).displacement, time)
        still = np.zeros_like(stretch)
        population = steady_population(tension.model, tension.activation, stretch)
        law = tension.model.active_law(population, tension.activation, stretch).scaled(tension.unit)
        counted = law.evaluate(stretch, still).tension
        steady = tension.law(stretch, 1.0).evaluate(stretch, still).tension
        pulls = steady != 0.0
        right = np.where(pulls, tension.unit * counted / np.where(pulls, steady, 1.0), tension.unit)
        if np.all(np.abs(right - unit) <= _EXACT * np.abs(tension.unit)):
            break
        unit = right
        problem = Equilibria(solid, attrs.evolve(tension, unit=unit), of=problem.of, time=time)
        found = _NEWTON.solve(_FullLoad(problem), unknowns)
        iterations += found.iterations
        if not found.converged:
            raise SceneError(
                f"scene.start: the equilibrium with the cross-bridges as they are was lost: {found.reason}"
            )
        unknowns = found.unknowns
    return unknowns, population, iterations
