"""Cell: one case, one variant, one method; and what was found."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import attrs

from myobridge.atlas.methods import DEFAULT, Method
from myobridge.interfaces import Expectation, StabilityCase
from myobridge.registry import registry
from myobridge.scene import Scene

__all__ = ["Cell", "Finding"]

_HOLDS = Expectation("holds", "the default holds every case")
_ANY = Expectation("any")


@attrs.frozen(eq=False)
class Cell:
    """What is to be tried.

    Attributes
    ----------
    name : str
        Of the case; with `variant` it names the row of the atlas.
    case : StabilityCase
    variant : str
    method : Method
    base : Scene
        Scene of the variant; that of the method is made when it is tried.
    full : bool
        Whether the largest step is looked for too.
    """

    name: str
    case: StabilityCase
    variant: str
    method: Method
    base: Scene
    full: bool = False

    @property
    def row(self) -> str:
        """Case and variant."""
        return f"{self.name}:{self.variant}" if self.variant else self.name

    @property
    def address(self) -> str:
        """Name of the cell: row, axis and method."""
        return f"{self.row}/{self.method.axis}/{self.method.name}"

    @property
    def expectation(self) -> Expectation:
        """What is known beforehand; the default must hold."""
        for pattern, expectation in self.case.expected.items():
            variant, colon, name = pattern.rpartition(":")
            if fnmatchcase(self.method.name, name) and (not colon or fnmatchcase(self.variant, variant)):
                return expectation
        return _HOLDS if self.method.name == DEFAULT else _ANY

    @property
    def key(self) -> str:
        """Hash of all that the finding depends on: scene, method, what must hold, and the installed sources."""
        case = self.case
        said = [
            self.address,
            self.base.to_data(),
            dict(self.method.settings),
            self.full,
            [attrs.asdict(limit) for limit in case.limits],
            attrs.asdict(self.expectation),
            [dict(case.reference), case.refused_with, case.bisect, case.seconds],
            sources_digest(),
        ]
        return hashlib.sha256(json.dumps(said, sort_keys=True, default=str).encode()).hexdigest()[:24]


@cache
def sources_digest() -> str:
    """Hash of the sources of the core and of every package that has registered a plugin."""
    packages = {"myobridge", *(item.cls.__module__.partition(".")[0] for item in registry())}
    digest = hashlib.sha256()
    for package in sorted(packages):
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            continue
        origin = Path(spec.origin)
        files = sorted(origin.parent.rglob("*.py")) if spec.submodule_search_locations else [origin]
        for path in files:
            digest.update(str(path.relative_to(origin.parent)).encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _finite(values: Mapping[str, float]) -> dict[str, float | None]:
    """JSON has no infinity: what is not finite becomes null."""
    return {name: value if value is not None and math.isfinite(value) else None for name, value in values.items()}


@attrs.frozen(kw_only=True)
class Finding:
    """What was found in a cell.

    Attributes
    ----------
    case, variant, axis, method : str
    outcome : {"holds", "fails", "not applicable"}
    why : str
        Why it fails or does not apply.
    expected : {"holds", "fails", "any"}
    because : str
        Why that is expected.
    surprise : str
        In what the finding differs from what is expected; empty where it does not.
    measured, predicted : mapping
        Quantities by name; None where not finite.
    largest_step : float or None
        Largest step that holds [s], where it was looked for.
    beyond : bool
        Whether even that step, the largest tried, holds; a `largest_step` None with `beyond` False was not found.
    seconds : float
        Computing time [s].
    key : str
        Hash of what it depends on.
    """

    case: str
    variant: str
    axis: str
    method: str
    outcome: str
    why: str = ""
    expected: str = "any"
    because: str = ""
    surprise: str = ""
    measured: Mapping[str, float | None] = attrs.field(factory=dict, converter=_finite)
    predicted: Mapping[str, float | None] = attrs.field(factory=dict, converter=_finite)
    largest_step: float | None = None
    beyond: bool = False
    seconds: float = 0.0
    key: str = ""

    @property
    def row(self) -> str:
        """Case and variant."""
        return f"{self.case}:{self.variant}" if self.variant else self.case

    @property
    def address(self) -> str:
        """Name of the cell, as `Cell.address`."""
        return f"{self.row}/{self.axis}/{self.method}"

    def as_data(self) -> dict[str, Any]:
        """Plain data, for JSON."""
        return attrs.asdict(self)

    @classmethod
    def of(cls, cell: Cell, outcome: str, **said: Any) -> Finding:
        """Finding of a cell, with what is expected of it beside it; a surprise is worked out unless given."""
        expectation = cell.expectation
        place = {"case": cell.name, "variant": cell.variant, "axis": cell.method.axis, "method": cell.method.name}
        known = {"expected": expectation.outcome, "because": expectation.because, "key": cell.key}
        everything: dict[str, Any] = {**place, **known, "surprise": unlike(expectation, outcome), **said}
        return cls(outcome=outcome, **everything)


def unlike(expectation: Expectation, outcome: str) -> str:
    """In what an outcome differs from what is expected."""
    if expectation.outcome in ("any", outcome):
        return ""
    words = {"holds": "must hold", "fails": "must fail"}[expectation.outcome]
    said = {"holds": "holds", "fails": "fails"}.get(outcome, "does not apply")
    return f"{words}, and {said}"
