"""Every plugin file has its line in pyproject, and what is installed agrees with it."""

from __future__ import annotations

import ast
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from myobridge.hookspecs import FAMILIES

ROOT = Path(__file__).parents[2]
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]["myobridge"]


def test_installed_metadata_are_those_of_the_project() -> None:
    points = metadata.entry_points(group="myobridge")
    installed = {
        point.name: point.value for point in points if point.dist is not None and point.dist.name == "myobridge"
    }
    assert installed == DECLARED, "entry points changed: install the project again (pip install -e .)"


@pytest.mark.sources
def test_every_file_with_a_hook_has_a_line() -> None:
    hooks = {family.hook for family in FAMILIES.values()}
    with_hook: set[str] = set()
    for top in (ROOT / "core", ROOT / "plugins"):
        for path in top.rglob("*.py"):
            if path.name == "hookspecs.py":
                continue
            body = ast.parse(path.read_text(encoding="utf-8")).body
            if any(isinstance(node, ast.FunctionDef) and node.name in hooks for node in body):
                with_hook.add(".".join(path.relative_to(top).with_suffix("").parts))
    assert with_hook == set(DECLARED.values())


def test_lines_are_named_after_family_and_file() -> None:
    for name, module in DECLARED.items():
        family, _, plugin = name.partition("-")
        assert family in FAMILIES or family == "core", name
        assert module.split(".")[-1] == plugin, name
