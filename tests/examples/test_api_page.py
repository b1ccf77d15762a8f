"""docs/api.md is what the docstrings say. Written anew by ``python tests/examples/test_api_page.py``."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import myobridge as mb

PAGE = Path(__file__).parents[2] / "docs" / "api.md"

TOPICS: Mapping[str, Sequence[str]] = {
    "Scenes and runs": ("Scene", "Plan", "run", "resume", "Run", "StaticRun", "Record", "Result"),
    "Composition in Python": ("Simulation", "Statics", "CouplingBus", "Ledger", "registry"),
    "Studies": ("Study", "StudyResult"),
    "Stability": ("Atlas", "Chart", "StabilityCase", "Limit", "Expectation"),
    "Interfaces": (
        "CrossBridgeModel",
        "MacroSolid",
        "TimeIntegrator",
        "CouplingScheme",
        "ContinuationStrategy",
        "Signal",
        "ActivationKinetics",
        "Overlap",
        "SarcomereDensity",
        "Material",
        "MeshSource",
        "Fibres",
        "Load",
        "LinearSolver",
        "ActiveLaw",
        "ContinuationProblem",
    ),
    "What interfaces pass to each other": (
        "AffineLaw",
        "Fluxes",
        "Promises",
        "Motion",
        "StepReport",
        "StepResult",
        "PathPoint",
        "ContinuationPath",
    ),
    "Hooks": ("hookimpl",),
    "Errors": ("MyobridgeError", "SceneError", "ParameterError", "PluginError", "StepFailed", "ContinuationFailed"),
}
MODULES = (
    "myobridge.coupling",
    "myobridge.parameters",
    "myobridge.interfaces",
    "myobridge.compiled",
    "myobridge.material_points",
    "myobridge.mesh_check",
    "myobridge.mesh_names",
    "myobridge.recording",
    "myobridge.fields",
    "myobridge.vtkhdf",
    "myobridge.pictures",
    "myobridge.bodies",
    "myobridge.solvers",
    "myobridge.atlas",
    "myobridge.study",
    "myobridge.work",
    "myobridge.testing",
    "myobridge.testing.strategies",
)


# Their docstrings are those of another package, and change with it.
FOREIGN = {
    "hookimpl": "Marks the function of a plugin module that offers its classes.",
    "Array": "Array of 64-bit floats.",
    "Matrix": "Dense array or sparse one of scipy.",
    "Memory": "What an integrator hands on from step to step, by name.",
}


def summary(item: object) -> str:
    """First paragraph of the docstring, in Markdown."""
    said = " ".join((inspect.getdoc(item) or "").partition("\n\n")[0].split())
    return re.sub(r":math:`([^`]*)`", r"$\1$", said).replace("``", "`").replace("|", "\\|")


def table(names: Sequence[str], module: object) -> list[str]:
    """A line for each name that has a docstring of its own."""
    lines = ["| name | what it is |", "|---|---|"]
    for name in names:
        item = getattr(module, name)
        if callable(item):  # constants and type aliases have no docstring of their own
            lines.append(f"| `{name}` | {FOREIGN.get(name) or summary(item)} |")
    return lines


def page() -> str:
    """Text of docs/api.md."""
    lines = [
        "# Public API",
        "",
        "Generated from the docstrings by `python tests/examples/test_api_page.py`; `tests/examples/test_api_page.py`",
        "fails when the two differ. `help(name)` in Python prints the whole docstring: parameters, units, shapes.",
        "",
        "## `import myobridge as mb`",
    ]
    for topic, names in TOPICS.items():
        lines += ["", f"### {topic}", "", *table(names, mb)]
    lines += ["", "## Modules"]
    for name in MODULES:
        module = importlib.import_module(name)
        # What `mb` offers too has its line above.
        names = [item for item in module.__all__ if item not in mb.__all__]
        lines += ["", f"### `{name}`", "", summary(module), "", *table(names, module)]
    return "\n".join(lines) + "\n"


def test_every_public_name_has_its_place() -> None:
    named = [name for names in TOPICS.values() for name in names]
    assert sorted(named) == sorted(mb.__all__)


def test_every_public_name_has_a_docstring() -> None:
    for name in mb.__all__:
        assert len(summary(getattr(mb, name))) > 10, name


def test_the_page_is_that_of_the_docstrings() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python tests/examples/test_api_page.py writes it anew"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
