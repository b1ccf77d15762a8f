"""Registry: what is installed, found through entry points one by one, so that one broken plugin stops nothing else."""

from __future__ import annotations

import functools
import importlib.metadata
import inspect
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import attrs
import pluggy

from myobridge import hookspecs
from myobridge.errors import PluginError, nearest
from myobridge.hookspecs import FAMILIES
from myobridge.parameters import optional_effects

__all__ = ["PluginWarning", "Registered", "Registry", "registry"]

GROUP = "myobridge"


class PluginWarning(UserWarning):
    """A plugin could not be loaded and was left out."""


@attrs.frozen
class Registered:
    """One registered class: short name, family, class, and the distribution that brought it."""

    name: str
    family: str
    cls: type[Any]
    package: str
    version: str

    @property
    def inherent_effects(self) -> frozenset[str]:
        """Effects that are there whenever the plugin is."""
        return getattr(self.cls, "inherent_effects", frozenset())

    @property
    def optional_effects(self) -> frozenset[str]:
        """Effects that the plugin supplies when a scene calls for them."""
        effects = optional_effects(self.cls)
        return effects | {"inertia"} if getattr(self.cls, "inertia", False) else effects

    @property
    def summary(self) -> str:
        """One line of description."""
        return getattr(self.cls, "summary", "") or (inspect.getdoc(self.cls) or "").partition("\n")[0]


class Registry:
    """Everything that installed packages offer, by family and short name.

    Parameters
    ----------
    entry_points : iterable of EntryPoint
        Where to look; by default the entry points of the group ``myobridge``.

    Raises
    ------
    PluginError
        If two packages offer the same name in a family.

    Warns
    -----
    PluginWarning
        Once for each entry point that fails to load or breaks its contract; the rest is there.
    """

    def __init__(self, entry_points: Iterable[importlib.metadata.EntryPoint] | None = None) -> None:
        found = importlib.metadata.entry_points(group=GROUP) if entry_points is None else entry_points
        self._items: dict[str, dict[str, Registered]] = {family: {} for family in FAMILIES}
        manager = pluggy.PluginManager("myobridge")
        manager.add_hookspecs(hookspecs)
        for point in sorted(set(found), key=lambda item: (item.name, item.value)):
            self._load(manager, point)

    def _load(self, manager: pluggy.PluginManager, point: importlib.metadata.EntryPoint) -> None:
        package = point.dist.name if point.dist is not None else "unknown package"
        version = point.dist.version if point.dist is not None else "?"
        try:
            module = point.load()
            manager.register(module, name=f"{package}:{point.name}")
            offered = list(_offers(manager, module))
        except Exception as error:  # a stranger's module may raise anything, and must not stop the rest
            warnings.warn(
                f"plugin '{point.name}' ({point.value}) of package '{package}' was left out: "
                f"{type(error).__name__}: {error}",
                PluginWarning,
                stacklevel=2,
            )
            return
        for family, name, cls in offered:
            known = self._items[family].get(name)
            if known is not None:
                raise PluginError(
                    f"two packages offer the {FAMILIES[family].doc} '{name}': '{known.package}' "
                    f"({known.cls.__module__}) and '{package}' ({cls.__module__}). Uninstall one, or rename its plugin."
                )
            self._items[family][name] = Registered(name, family, cls, package, version)

    def find(self, family: str, name: str) -> Registered:
        """The plugin `name` of `family`.

        Raises
        ------
        PluginError
            If there is none; the message lists those there are and the nearest match.
        """
        items = self._items[family]
        if name not in items:
            raise PluginError(f"unknown {FAMILIES[family].doc} '{name}'. {nearest(name, items)}")
        return items[name]

    def names(self, family: str) -> tuple[str, ...]:
        """Short names of a family, sorted."""
        return tuple(sorted(self._items[family]))

    def __iter__(self) -> Iterator[Registered]:
        for family in FAMILIES:
            for name in self.names(family):
                yield self._items[family][name]


def _offers(manager: pluggy.PluginManager, module: object) -> Iterator[tuple[str, str, type[Any]]]:
    """(family, name, class) of everything a module's hooks return, checked against the interface."""
    for family in FAMILIES.values():
        for implementation in getattr(manager.hook, family.hook).get_hookimpls():
            if implementation.plugin is not module:
                continue
            for name, cls in implementation.function().items():
                if not (isinstance(cls, type) and issubclass(cls, family.interface)):
                    raise PluginError(f"'{name}' is {cls!r}, not a subclass of {family.interface.__name__}")
                if inspect.isabstract(cls):
                    missing = ", ".join(sorted(cls.__abstractmethods__))  # pyright: ignore[reportAttributeAccessIssue]
                    raise PluginError(f"'{name}' ({cls.__name__}) lacks {missing}")
                yield family.name, name, cls


@functools.cache
def registry() -> Registry:
    """The registry of this process, loaded at its first use."""
    return Registry()
