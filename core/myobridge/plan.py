"""Plan: what a scene means. Which plugins, how many unknowns, sites and bytes; what is left out, and why."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from myobridge.build import build
from myobridge.effects import EFFECTS, FAMILY_OF_SECTION, FIELDS_OF_SECTION, SECTIONS, known_effects, suppliers
from myobridge.errors import MyobridgeError, ParameterError, SceneError, nearest
from myobridge.interfaces import MacroSolid
from myobridge.look_ahead import check_activation, check_prescribed_stretch, memory_of_this_machine
from myobridge.parameters import declared, optional_effects
from myobridge.registry import Registry, registry
from myobridge.scaling import Scaling
from myobridge.scene import Scene
from myobridge.simulation import Simulation
from myobridge.static_plan import check_effects, composed_statics, lists_given, merged, scaling_of
from myobridge.statics import Statics
from myobridge.stimulation import located

__all__ = ["Plan"]


@attrs.frozen(eq=False)
class Plan:
    """A scene with its plugins built.

    Attributes
    ----------
    scene : Scene
    parts : mapping
        Built plugins by section; a section that the scene does without is absent.
    names : mapping
        Short name of each part's plugin.
    scaling : Scaling or None
        What a scene without time raises.
    """

    scene: Scene
    parts: Mapping[str, Any]
    names: Mapping[str, str]
    scaling: Scaling | None = None

    @classmethod
    def of(cls, scene: Scene, plugins: Registry | None = None) -> Plan:
        """Build every plugin that the scene needs, and none else.

        Raises
        ------
        SceneError
            One clear message: file, line and key, what is wrong, what is allowed, the nearest match.
        """
        found = registry() if plugins is None else plugins
        try:
            tables, scaling = _tables(scene, found), scaling_of(scene)
            parts = {section: _part(found, section, table, scene) for section, table in tables.items()}
            _check_suppliers(scene, found, parts)
            _check_usable(parts)
            if not scene.static:
                _check_inertia(scene, parts)
        except ParameterError as error:
            raise SceneError(f"{scene.origin.of(error.key)}{error.key}: {error.problem}") from None
        return cls(scene, parts, {section: str(table["plugin"]) for section, table in tables.items()}, scaling)

    def composed(self, *, begin: bool = True) -> Simulation | Statics:
        """The simulation, ready to step, or the statics of a scene without time.

        Parameters
        ----------
        begin : bool
            Find the motion in which the scene starts; without, the simulation waits for a state to be restored.

        Raises
        ------
        SceneError
            If the parts do not go together, or would not at some later time.
        """
        scene, parts = self.scene, dict(self.parts)
        try:
            _check_body(scene, parts["solid"])
            if self.scaling is not None:
                return composed_statics(scene, self.scaling, parts)
            _check_memory(self.sizes())
            simulation = _composed(scene, parts, begin=begin)
            _check_record(scene, simulation)
        except ParameterError as error:
            raise SceneError(f"{scene.origin.of(error.key)}{error.key}: {error.problem}") from None
        except MyobridgeError as error:
            section = str(error).partition(":")[0]
            raise SceneError(f"{scene.origin.of(section)}{error}") from None
        return simulation

    def simulation(self) -> Simulation:
        """The simulation, ready to step.

        Raises
        ------
        SceneError
            If the parts do not go together, or the scene is without time.
        """
        found = self.composed()
        if not isinstance(found, Simulation):
            raise SceneError(f"{self.scene.origin.of('continuation')}continuation: a scene without time does not step")
        return found

    def effects(self) -> list[tuple[str, str, str]]:
        """(effect, "on" | "off" | "inherent", what supplies it or why it is off); plugins may add to the known ones."""
        rows: list[tuple[str, str, str]] = []
        supplied = sorted({effect for section, part in self.parts.items() for effect in _supplied(section, part)})
        for effect in dict.fromkeys((*EFFECTS, *supplied)):
            by = [
                f"{section} '{self.names[section]}'"
                for section, part in self.parts.items()
                if effect in _supplied(section, part)
            ]
            if effect in self.scene.effects:
                rows.append((effect, "on", ", ".join(by)))
            # An effect with a table of its own does not act without it, whatever the model could do.
            elif effect not in SECTIONS and any(
                effect in getattr(part, "inherent_effects", ()) for part in self.parts.values()
            ):
                rows.append((effect, "inherent", f"always there in {', '.join(by)}"))
            else:
                rows.append((effect, "off", f"not called for: {EFFECTS.get(effect, 'supplied by ' + ', '.join(by))}"))
        return rows

    def sizes(self) -> dict[str, int]:
        """Unknowns, sites, state values a site, bytes of the population (state and trial)."""
        solid = self.parts["solid"]
        sizes = {"unknowns": solid.n_unknowns, "sites": solid.n_sites}
        model = self.parts.get("cross_bridges")
        if model is not None:
            values = model.initial_state(1).shape[1]
            sizes |= {"values a site": values, "population bytes": 2 * 8 * values * solid.n_sites}
        return sizes


def _tables(scene: Scene, plugins: Registry) -> dict[str, Mapping[str, Any]]:
    """Tables of the sections that exist, defaults filled in."""
    known = known_effects(plugins)
    for index, effect in enumerate(scene.effects):
        if effect not in known:
            raise ParameterError(f"scene.effects[{index}]", f"there is no effect '{effect}'. {nearest(effect, known)}")
    check_effects(scene)
    tables: dict[str, Mapping[str, Any]] = {"solid": merged(scene, plugins)}
    for section in SECTIONS:
        table = getattr(scene, section)
        if table is not None and section not in scene.effects:
            raise ParameterError(
                section, f"is given, but the scene does not call for the effect '{section}'; add it to scene.effects"
            )
        if section in scene.effects:
            if table is None:
                raise ParameterError(
                    section, f"is missing: the scene calls for the effect '{section}', so it needs a table [{section}]"
                )
            if section != "cross_bridges" and "cross_bridges" not in scene.effects:
                raise ParameterError("scene.effects", f"'{section}' acts on cross-bridges; add 'cross_bridges'")
            tables[section] = table
    if scene.continuation is not None:
        return tables | {"continuation": scene.continuation}
    inertia = "inertia" in scene.effects
    tables["integrator"] = scene.integrator or {"plugin": "energy_momentum" if inertia else "quasi_static"}
    if "cross_bridges" in scene.effects:
        tables["coupling"] = scene.coupling or {"plugin": "splitting" if inertia else "corrected"}
    elif scene.coupling is not None:
        raise ParameterError("coupling", "is given, but there is nothing to couple: no effect 'cross_bridges'")
    return tables


def _part(plugins: Registry, section: str, table: Mapping[str, Any], scene: Scene) -> Any:
    mine = {key: value for key, value in table.items() if key not in FIELDS_OF_SECTION.get(section, ())}
    try:
        return build(plugins, FAMILY_OF_SECTION[section], mine, scene.effects, scene.folder or Path())
    except ParameterError as error:
        raise ParameterError(_full_key(section, error.key, scene), error.problem) from None


def _full_key(section: str, key: str, scene: Scene) -> str:
    """Key of a part's parameter as the file has it: lists of the solid may stand at the top."""
    top = section == "solid" and any(key.startswith(f"{name}[") for name in lists_given(scene))
    return key if top else f"{section}.{key}"


def _check_body(scene: Scene, solid: MacroSolid) -> None:
    """A solid may be made when it is first asked, and may find only then what is wrong with its parameters."""
    try:
        solid.rest_motion()
    except ParameterError as error:
        raise ParameterError(_full_key("solid", error.key, scene), error.problem) from None


def _check_memory(sizes: Mapping[str, int]) -> None:
    needed, there = sizes.get("population bytes", 0), memory_of_this_machine()
    if needed > there:
        raise ParameterError(
            "solid",
            f"has {sizes['sites']:,} sites, whose population needs {needed / 2**30:,.0f} GiB, and this machine has "
            f"{there / 2**30:,.0f}; use fewer sites or bins",
        )


def _composed(scene: Scene, parts: Mapping[str, Any], *, begin: bool) -> Simulation:
    if scene.step > scene.duration:
        raise ParameterError("scene.step", f"is {scene.step:g} s, longer than the duration of {scene.duration:g} s")
    solid, activation = parts["solid"], located(parts.get("activation"), parts["solid"])
    if activation is not None:
        check_activation(activation, solid.n_sites, scene.duration)
    if solid.n_unknowns == 0:
        check_prescribed_stretch(solid, scene.duration)
    try:
        start = (scene.start or "as_given") if begin else None
        return Simulation(dt=scene.step, tolerance=scene.tolerance, start=start, **parts)
    except ParameterError as error:  # the density is the only part that meets the sites at this moment
        raise ParameterError(f"sarcomere_density.{error.key}", error.problem) from None


def _check_record(scene: Scene, simulation: Simulation) -> None:
    try:
        scene.record.check(simulation, round(scene.duration / scene.step))
    except ParameterError as error:
        raise ParameterError(f"record.{error.key}", error.problem) from None


def _supplied(section: str, part: Any) -> frozenset[str]:
    cls = type(part)
    effects = frozenset({section}) if section in SECTIONS else frozenset[str]()
    effects |= getattr(cls, "inherent_effects", frozenset()) | optional_effects(cls)
    for name, item in declared(cls).items():
        inner = getattr(part, name, None)
        if item.kind == "part" and inner is not None:
            effects |= _supplied("", inner)
        if item.kind in ("parts", "records"):
            effects |= frozenset().union(*(_supplied("", entry) for entry in inner or ()))
    if section == "integrator" and cls.inertia:
        effects |= {"inertia"}
    return effects


def _check_usable(parts: Mapping[str, Any]) -> None:
    """What needs a package that is not here is said before anything is computed."""
    for section in ("integrator", "continuation"):
        solver = getattr(getattr(parts.get(section), "newton", None), "linear", None)
        obstacle = "" if solver is None else solver.obstacle()
        if obstacle:
            raise ParameterError(f"{section}.newton.linear", f"cannot be used on this machine: {obstacle}")


def _check_suppliers(scene: Scene, plugins: Registry, parts: Mapping[str, Any]) -> None:
    for index, effect in enumerate(scene.effects):
        if effect == "inertia" or any(effect in _supplied(section, part) for section, part in parts.items()):
            continue
        chosen = ", ".join(f"{section} '{type(part).__name__}'" for section, part in parts.items())
        others = suppliers(plugins, effect)
        hint = f"Supplied by: {', '.join(others)}." if others else "No installed plugin supplies it."
        raise ParameterError(
            f"scene.effects[{index}]", f"'{effect}' is supplied by none of the chosen plugins ({chosen}). {hint}"
        )


def _check_inertia(scene: Scene, parts: Mapping[str, Any]) -> None:
    wanted = "inertia" in scene.effects
    integrator, solid = parts["integrator"], parts["solid"]
    if wanted and not solid.inertia:
        raise ParameterError("scene.effects", f"'inertia' has no supplier: {type(solid).__name__} has no mass")
    if wanted and not integrator.inertia:
        raise ParameterError(
            "integrator.plugin", "leaves inertia out, and the scene calls for 'inertia'; drop one of the two"
        )
    if not wanted and integrator.inertia:
        raise ParameterError(
            "integrator.plugin",
            "integrates inertia, and the scene does not call for it; add 'inertia' to scene.effects",
        )
