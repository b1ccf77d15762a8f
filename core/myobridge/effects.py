"""Effects: the phenomena that a scene can call for. What is not called for is neither allocated nor computed."""

from __future__ import annotations

from collections.abc import Mapping

from myobridge.parameters import declared
from myobridge.registry import Registry
from myobridge.scaling import Scaling

__all__ = [
    "EFFECTS",
    "FAMILY_OF_SECTION",
    "FIELDS_OF_SECTION",
    "LISTS_OF_SOLID",
    "NEED_TIME",
    "SECTIONS",
    "known_effects",
    "suppliers",
]

EFFECTS: Mapping[str, str] = {
    "inertia": "masses resist acceleration; without it every step is an equilibrium",
    "gravity": "weight of the solid",
    "incompressibility": "the tissue keeps its volume",
    "viscosity": "the tissue dissipates when it deforms",
    "activation": "the muscle is not always fully active",
    "cross_bridges": "active tension",
    "force_velocity": "tension depends on the rate of stretch",
    "length_dependence": "tension depends on the overlap of the filaments",
    "calcium": "activation follows stimulation with a delay",
    "fibre_stiffening": "passive fibres stiffen with stretch",
    "sarcomere_density": "sarcomeres are not equally dense everywhere",
    "cross_bridge_mass": "myosin heads have mass",
}

# Effects that have a table of their own in a scene: the table is there if and only if the effect is called for.
SECTIONS: Mapping[str, str] = {
    "cross_bridges": "cross_bridge",
    "activation": "signal",
    "calcium": "calcium",
    "sarcomere_density": "sarcomere_density",
}

# Every table of a scene that names a plugin -> the family it is looked up in.
FAMILY_OF_SECTION: Mapping[str, str] = {
    "solid": "macro_solid",
    "integrator": "time_integrator",
    "coupling": "coupling",
    "continuation": "continuation",
    **SECTIONS,
}

# Keys of a section that are not its plugin's.
FIELDS_OF_SECTION: Mapping[str, frozenset[str]] = {"continuation": frozenset(declared(Scaling))}

# Lists at the top of a scene that belong to its solid.
LISTS_OF_SOLID = ("load", "support", "region")

# Effects that do nothing in a scene without time.
NEED_TIME = ("inertia", "viscosity", "calcium", "force_velocity", "cross_bridge_mass")


def suppliers(registry: Registry, effect: str) -> list[str]:
    """Installed plugins that supply `effect`, as ``family 'name'``."""
    return [
        f"{item.family} '{item.name}'"
        for item in registry
        if effect in item.inherent_effects or effect in item.optional_effects
    ]


def known_effects(registry: Registry) -> dict[str, str]:
    """The effects above and those that installed plugins add, with one line each."""
    known = dict(EFFECTS)
    for item in registry:
        for effect in item.inherent_effects | item.optional_effects:
            known.setdefault(effect, f"supplied by {item.family} '{item.name}' of {item.package}")
    return known
