"""Stability case: a hard problem as data: a scene, the methods that are tried on it, and what must hold."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import attrs

if TYPE_CHECKING:
    from myobridge.scene import Scene
    from myobridge.simulation import Simulation
    from myobridge.statics import Statics

__all__ = ["Expectation", "Limit", "StabilityCase"]

Settings = Mapping[str, Any]
"""Keys of a scene that are set on top of it, dotted as in ``--set``."""


@attrs.frozen
class Limit:
    """Range in which a measured quantity must stay; one that is not finite stays in none.

    Attributes
    ----------
    quantity : str
        Name, one of `myobridge.atlas.QUANTITIES` or of the case's own.
    at_most, at_least : float
        Ends of the range, in the unit of the quantity.
    """

    quantity: str
    at_most: float = math.inf
    at_least: float = -math.inf

    def violation(self, value: float) -> str:
        """What is wrong with a value, in words; empty where nothing is."""
        if not math.isfinite(value):
            return "is not finite"
        if value > self.at_most:
            return f"is {value:.3g}, at most {self.at_most:g} is allowed"
        if value < self.at_least:
            return f"is {value:.3g}, at least {self.at_least:g} is needed"
        return ""


@attrs.frozen
class Expectation:
    """What is known of a method on a case before it is tried.

    Attributes
    ----------
    outcome : {"holds", "fails", "any"}
        "any" where only the numbers are known.
    because : str
        Why, in a sentence.
    agrees : mapping
        Relative distance that a measured quantity may have from `StabilityCase.predicted`, by quantity.
    """

    outcome: Literal["holds", "fails", "any"]
    because: str = ""
    agrees: Mapping[str, float] = attrs.field(factory=dict[str, float])


class StabilityCase(ABC):
    """Abstract case of the stability atlas. A case is a class of data; it has no parameters.

    A cell of the atlas is a case, one of its variants and a method. The scene as it stands, with the plugins that it
    takes by default, is the method ``default``, which must hold every case. Further methods are all installed plugins
    of the sections that the case varies, as far as they go with the scene, so that a method joins by being installed.

    Class attributes
    ----------------
    summary : str
        One line for ``myobridge plugins``.
    scene : str
        The scene, as TOML; every case has one.
    limits : sequence of Limit
        What must hold; every case says it.
    variants : mapping
        Settings of the scene by name; without, the scene alone, with the name "".
    vary : sequence of str
        Sections whose plugin is exchanged (``integrator``), and dotted keys of a choice (``solid.elements``).
    methods : mapping
        Settings of further methods by name.
    expected : mapping
        `Expectation` by pattern of a method's name, or of ``variant:name``; the first that matches counts.
    reference : mapping
        Settings of a run that stands for the exact solution.
    longer : mapping
        Settings of the full atlas.
    only_full : sequence of str
        Patterns of variants that the full atlas alone has.
    default_only : sequence of str
        Patterns of variants on which the quick atlas tries the default alone, and methods of which something is
        expected; those that are asked for by name are tried all the same.
    refused_with : str
        Words of the message with which the scene must be refused; empty where it must run.
    bisect : bool
        Whether the full atlas looks for the largest step that holds.
    seconds : float
        Computing time that a cell may take [s].
    """

    summary: ClassVar[str] = ""
    scene: ClassVar[str]
    limits: ClassVar[tuple[Limit, ...]]
    variants: ClassVar[Mapping[str, Settings]] = {"": {}}
    vary: ClassVar[tuple[str, ...]] = ()
    methods: ClassVar[Mapping[str, Settings]] = {}
    expected: ClassVar[Mapping[str, Expectation]] = {}
    reference: ClassVar[Settings] = {}
    longer: ClassVar[Settings] = {}
    only_full: ClassVar[tuple[str, ...]] = ()
    default_only: ClassVar[tuple[str, ...]] = ()
    refused_with: ClassVar[str] = ""
    bisect: ClassVar[bool] = True
    seconds: ClassVar[float] = 120.0

    def measured(self, scene: Scene) -> Mapping[str, float] | None:
        """Quantities of a case that is no run: worked out here. None where the scene is to be run."""
        return None

    def predicted(self, composed: Simulation | Statics) -> Mapping[str, float]:
        """What theory says of measured quantities, by their names."""
        return {}
