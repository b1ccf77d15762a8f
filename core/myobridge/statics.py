"""Statics: one solid, one cross-bridge model in its steady state, one continuation strategy; no time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from myobridge.equilibria import Equilibria, SteadyTension
from myobridge.errors import ParameterError, SceneError, nearest
from myobridge.interfaces import (
    Array,
    ContinuationPath,
    ContinuationStrategy,
    CrossBridgeModel,
    MacroSolid,
    Motion,
    PathPoint,
    SarcomereDensity,
    Signal,
)
from myobridge.look_ahead import check_activation
from myobridge.scaling import Scaling
from myobridge.stimulation import located

__all__ = ["Statics"]


class Statics:
    """Composition of plugins whose equilibria are followed as a scale grows.

    Signals (activation, loads) act with their value at time 0. A model with a population pulls with its isometric
    steady tension: a frozen population would drag the solid.

    Parameters
    ----------
    solid : MacroSolid
    continuation : ContinuationStrategy
    cross_bridges : CrossBridgeModel, optional
        Without it the solid is passive.
    activation : Signal, optional
        Activation in [0, 1]; without it the muscle is fully active.
    sarcomere_density : SarcomereDensity, optional
        Local density; 1 without.
    of, to, report
        What the scale multiplies, where it ends, and where states are kept: see `myobridge.scaling.Scaling`.

    Raises
    ------
    SceneError
        If the parts do not go together; the message says which and why.

    Examples
    --------
    >>> import myobridge as mb
    >>> find = lambda family, name: mb.registry().find(family, name).cls
    >>> statics = mb.Statics(
    ...     solid=find("macro_solid", "spring")(stiffness=100.0, length=0.1, area=1e-4),
    ...     cross_bridges=find("cross_bridge", "prescribed")(p_max=1e4),
    ...     continuation=find("continuation", "natural")(),
    ...     to=1.2,
    ... )
    >>> path = statics.trace()
    >>> round(float(path.points[-1].unknowns[0]), 6)
    -0.012
    """

    def __init__(
        self,
        *,
        solid: MacroSolid,
        continuation: ContinuationStrategy,
        cross_bridges: CrossBridgeModel | None = None,
        activation: Signal | None = None,
        sarcomere_density: SarcomereDensity | None = None,
        of: str | None = None,
        to: float = 1.0,
        report: Sequence[float] | float = (),
    ) -> None:
        self.solid = solid
        self.strategy = continuation
        try:
            self.scaling = Scaling(of=of, to=to, report=report)  # pyright: ignore[reportArgumentType]
        except ParameterError as error:
            raise SceneError(f"continuation.{error}") from None
        self.kept = self.scaling.kept()
        parts = {"activation": activation, "sarcomere_density": sarcomere_density}
        self._given = [name for name, given in parts.items() if given is not None]
        try:
            activation = located(activation, solid)
        except ParameterError as error:
            raise SceneError(str(error)) from None
        _check_parts(solid, cross_bridges, activation, sarcomere_density)
        self.tension = _steady_tension(solid, cross_bridges, activation, sarcomere_density)
        self.of = self.scaling.of or ("load" if self.tension is None else "tension")
        self.problem = Equilibria(solid, self.tension, of=self.of, to=self.scaling.to)
        self._check()

    # ------------------------------------------------------------------ the path

    def trace(
        self, watch: Callable[[PathPoint], object] | None = None, earlier: Sequence[PathPoint] = ()
    ) -> ContinuationPath:
        """Follow the path to its end, or until it fails: then the answer says why.

        Parameters
        ----------
        watch : callable, optional
            Told every accepted point at once.
        earlier : sequence of PathPoint
            Last points of a path that ended early, to be continued.
        """
        stops = [level for level in self.kept if 0.0 < level < 1.0]
        return self.strategy.trace(self.problem, self.problem.start, stops=stops, watch=watch, earlier=earlier)

    def scale(self, level: float) -> float:
        """Scale at a level; that of a kept state is the one asked for, to the last digit."""
        return self.kept.get(level, self.scaling.to * level)

    # ------------------------------------------------------------------ what can be asked of a point

    def motion(self, point: PathPoint) -> Motion:
        """Motion of the solid at a point of the path."""
        return self.problem.motion(point.unknowns)

    def stretch_and_tension(self, point: PathPoint) -> tuple[Array, Array]:
        """Fibre stretch [-] and nominal active stress [Pa] at the sites."""
        stretch = self.solid.stretch(self.motion(point).displacement, 0.0)
        law = self.problem.law(point.unknowns, point.level)
        if law is None:
            return stretch, np.zeros(self.solid.n_sites)
        return stretch, law.evaluate(stretch, np.zeros_like(stretch)).tension

    def reactions(self, point: PathPoint) -> dict[str, Array]:
        """Force of each support on the solid [N], under the load at its scale."""
        found = dict(self.solid.reactions(self.motion(point), self.stretch_and_tension(point)[1], 0.0))
        share = 1.0 - self.problem.scales(point.level)[1]
        if share != 0.0:
            for name, force in self.solid.supported_load(0.0).items():
                found[name] = found[name] + share * force
        return found

    def fields(self, point: PathPoint) -> Mapping[str, Array]:
        """Fields at the sites: stretch, tension, activation and sarcomere density, as far as the scene has them."""
        stretch, tension = self.stretch_and_tension(point)
        if self.tension is None:
            return {"stretch": stretch}
        local = {
            "activation": self.tension.activation,
            "sarcomere_density": self.tension.unit / self.tension.model.p_max,
        }
        return {"stretch": stretch, "tension": tension} | {name: local[name] for name in self._given}

    # ------------------------------------------------------------------ what does not go together

    def _check(self) -> None:
        solid, problem = self.solid, self.problem
        if self.tension is None and self.of != "load":
            raise SceneError(
                f"continuation.of: is '{self.of}', and there is no tension to scale; call for the effect "
                "'cross_bridges', or set of = 'load'"
            )
        obstacle = solid.statics_obstacle(problem.motion(problem.start), problem.law(problem.start, 0.0))
        if obstacle:
            raise SceneError(f"solid: {obstacle}")
        if self.of == "load" and not np.any(problem.level_derivative(problem.start, 0.0)):
            raise SceneError(
                f"continuation.of: is 'load', and no load acts on {type(solid).__name__} at time 0: nothing would move"
            )
        if self.strategy.softens and problem.softened(1.0) is None:
            raise SceneError(
                f"continuation.plugin: {type(self.strategy).__name__} lowers the bulk modulus of the tissue, and "
                f"{type(solid).__name__} has none to lower; use 'natural' or 'arclength'"
            )


def _check_parts(
    solid: MacroSolid,
    cross_bridges: CrossBridgeModel | None,
    activation: Signal | None,
    sarcomere_density: SarcomereDensity | None,
) -> None:
    if solid.n_unknowns == 0:
        raise SceneError(
            f"solid: {type(solid).__name__} prescribes the stretch, so without time there is nothing to find; leave "
            "out [continuation] and give a duration and a step"
        )
    if cross_bridges is None:
        for name, given in {"activation": activation, "sarcomere_density": sarcomere_density}.items():
            if given is not None:
                raise SceneError(
                    f"{name}: acts on cross-bridges, and there are none; give cross_bridges or leave it out"
                )
    elif not cross_bridges.has_statics:
        from myobridge.registry import registry

        able = [item.name for item in registry() if item.family == "cross_bridge" and item.cls.has_statics]
        raise SceneError(
            f"cross_bridges: {type(cross_bridges).__name__} has no isometric steady state, and without time a frozen "
            f"population would drag the solid. {nearest('', able)} Or give the scene a duration and a step"
        )
    if activation is not None:
        try:
            check_activation(activation, solid.n_sites, 0.0)
        except ParameterError as error:
            raise SceneError(str(error)) from None


def _steady_tension(
    solid: MacroSolid,
    model: CrossBridgeModel | None,
    activation: Signal | None,
    sarcomere_density: SarcomereDensity | None,
) -> SteadyTension | None:
    if model is None:
        return None
    shape = (solid.n_sites,)
    r = 1.0 if activation is None else activation.value(0.0)
    density = 1.0
    if sarcomere_density is not None:
        try:
            density = sarcomere_density.at(solid.site_positions())
        except ParameterError as error:
            raise ParameterError(f"sarcomere_density.{error.key}", error.problem) from None
    return SteadyTension(
        model,
        np.array(np.broadcast_to(r, shape), dtype=float),
        np.array(np.broadcast_to(model.p_max * np.asarray(density), shape), dtype=float),
    )
