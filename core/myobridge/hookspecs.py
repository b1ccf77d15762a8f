"""Hooks through which every plugin, built in or a stranger's, offers its classes.

A plugin module names an entry point of the group ``myobridge`` and ends with::

    @hookimpl
    def myobridge_cross_bridges():
        return {"my_model": MyModel}
"""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import pluggy

from myobridge.interfaces import (
    ActivationKinetics,
    ContinuationStrategy,
    CouplingScheme,
    CrossBridgeModel,
    Fibres,
    LinearSolver,
    Load,
    MacroSolid,
    Material,
    MeshSource,
    NewtonMethod,
    Overlap,
    SarcomereDensity,
    Signal,
    StabilityCase,
    TimeIntegrator,
)

__all__ = ["FAMILIES", "Family", "hookimpl", "hookspec"]

hookspec = pluggy.HookspecMarker("myobridge")
hookimpl = pluggy.HookimplMarker("myobridge")


@hookspec
def myobridge_cross_bridges() -> Mapping[str, type[CrossBridgeModel]]:  # pyright: ignore[reportReturnType]
    """Cross-bridge models by short name."""


@hookspec
def myobridge_macro_solids() -> Mapping[str, type[MacroSolid]]:  # pyright: ignore[reportReturnType]
    """Solids by short name."""


@hookspec
def myobridge_time_integrators() -> Mapping[str, type[TimeIntegrator]]:  # pyright: ignore[reportReturnType]
    """Time integrators by short name."""


@hookspec
def myobridge_continuations() -> Mapping[str, type[ContinuationStrategy]]:  # pyright: ignore[reportReturnType]
    """Continuation strategies by short name."""


@hookspec
def myobridge_couplings() -> Mapping[str, type[CouplingScheme]]:  # pyright: ignore[reportReturnType]
    """Coupling schemes by short name."""


@hookspec
def myobridge_signals() -> Mapping[str, type[Signal]]:  # pyright: ignore[reportReturnType]
    """Functions of time by short name: activations, loads, prescribed stretches."""


@hookspec
def myobridge_calcium_kinetics() -> Mapping[str, type[ActivationKinetics]]:  # pyright: ignore[reportReturnType]
    """Stages between stimulation and activation by short name."""


@hookspec
def myobridge_overlaps() -> Mapping[str, type[Overlap]]:  # pyright: ignore[reportReturnType]
    """Filament overlaps by short name."""


@hookspec
def myobridge_sarcomere_densities() -> Mapping[str, type[SarcomereDensity]]:  # pyright: ignore[reportReturnType]
    """Sarcomere densities by short name."""


@hookspec
def myobridge_materials() -> Mapping[str, type[Material]]:  # pyright: ignore[reportReturnType]
    """Passive laws of tissue by short name."""


@hookspec
def myobridge_meshes() -> Mapping[str, type[MeshSource]]:  # pyright: ignore[reportReturnType]
    """Sources of meshes by short name."""


@hookspec
def myobridge_fibres() -> Mapping[str, type[Fibres]]:  # pyright: ignore[reportReturnType]
    """Fields of fibre directions by short name."""


@hookspec
def myobridge_loads() -> Mapping[str, type[Load]]:  # pyright: ignore[reportReturnType]
    """Loads on named boundaries by short name."""


@hookspec
def myobridge_linear_solvers() -> Mapping[str, type[LinearSolver]]:  # pyright: ignore[reportReturnType]
    """Linear solvers by short name."""


@hookspec
def myobridge_newton_methods() -> Mapping[str, type[NewtonMethod]]:  # pyright: ignore[reportReturnType]
    """Newton's methods by short name."""


@hookspec
def myobridge_stability_cases() -> Mapping[str, type[StabilityCase]]:  # pyright: ignore[reportReturnType]
    """Cases of the stability atlas by short name."""


@attrs.frozen
class Family:
    """A kind of plugin: its hook, the interface that every member implements, what it is in words."""

    name: str
    hook: str
    interface: type
    doc: str


FAMILIES: Mapping[str, Family] = {
    family.name: family
    for family in (
        Family("cross_bridge", "myobridge_cross_bridges", CrossBridgeModel, "cross-bridge model"),
        Family("macro_solid", "myobridge_macro_solids", MacroSolid, "solid"),
        Family("time_integrator", "myobridge_time_integrators", TimeIntegrator, "time integrator"),
        Family("continuation", "myobridge_continuations", ContinuationStrategy, "continuation strategy"),
        Family("coupling", "myobridge_couplings", CouplingScheme, "coupling scheme"),
        Family("signal", "myobridge_signals", Signal, "function of time"),
        Family("calcium", "myobridge_calcium_kinetics", ActivationKinetics, "calcium kinetics"),
        Family("overlap", "myobridge_overlaps", Overlap, "filament overlap"),
        Family("sarcomere_density", "myobridge_sarcomere_densities", SarcomereDensity, "sarcomere density"),
        Family("material", "myobridge_materials", Material, "passive law of the tissue"),
        Family("mesh", "myobridge_meshes", MeshSource, "source of a mesh"),
        Family("fibres", "myobridge_fibres", Fibres, "field of fibre directions"),
        Family("load", "myobridge_loads", Load, "load on a boundary"),
        Family("linear_solver", "myobridge_linear_solvers", LinearSolver, "linear solver"),
        Family("newton", "myobridge_newton_methods", NewtonMethod, "Newton's method"),
        Family("stability_case", "myobridge_stability_cases", StabilityCase, "stability case"),
    )
}
