"""The house: who may know whom, and what things are called."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.sources

ROOT = Path(__file__).parents[2]
CORE = ROOT / "core" / "myobridge"
PLUGINS = ROOT / "plugins" / "myobridge_plugins"
SOURCES = sorted([*CORE.rglob("*.py"), *PLUGINS.rglob("*.py")])
FORBIDDEN = re.compile(
    r"(^|_)(utils?|helpers?|managers?)(_|$)|Base($|[A-Z])|Impl($|[A-Z])|(Util|Helper|Manager)s?($|[A-Z])"
)


def _name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def _imports(path: Path) -> Iterator[tuple[str, str]]:
    """(module, name) of every import in a file, at the top or inside a function; the name of a plain import is ""."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{_name(path)} imports relatively: names of wings would be hidden"
            yield from ((node.module or "", alias.name) for alias in node.names)


def _public_names(module: str) -> set[str] | None:
    """``__all__`` of a plugin module as written; None without."""
    path = PLUGINS.parent.joinpath(*module.split("."))
    source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    for node in ast.parse(source.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return None


def test_there_is_something_to_look_at() -> None:
    assert len([path for path in SOURCES if CORE in path.parents]) > 20
    assert len([path for path in SOURCES if PLUGINS in path.parents]) > 20


@pytest.mark.parametrize("path", sorted(CORE.rglob("*.py")), ids=_name)
def test_core_never_imports_plugins(path: Path) -> None:
    assert [module for module, _ in _imports(path) if module.split(".")[0] == "myobridge_plugins"] == []


def test_importing_the_core_loads_no_plugin() -> None:
    program = "import sys, myobridge; print([name for name in sys.modules if name.startswith('myobridge_plugins')])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_nobody_imports_a_folder_of_the_repository(path: Path) -> None:
    assert [module for module, _ in _imports(path) if module.split(".")[0] in {"core", "plugins", "tests"}] == []


@pytest.mark.parametrize("path", sorted(PLUGINS.rglob("*.py")), ids=_name)
def test_wings_share_public_names_only(path: Path) -> None:
    wing = path.relative_to(PLUGINS).parts[0]
    for module, name in _imports(path):
        parts = module.split(".")
        if parts[0] != "myobridge_plugins" or len(parts) < 2 or parts[1] == wing:
            continue
        public = _public_names(module)
        assert not any(part.startswith("_") for part in (*parts, name)), f"{module}.{name} is private"
        assert public is not None, f"{module} is used by another wing, and has no __all__"
        assert name in public, f"{module}.{name} is not in __all__ of its module"


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_no_plugin_reaches_into_private_names_of_the_core(path: Path) -> None:
    if PLUGINS not in path.parents:
        own = path.stem
        private = [
            f"{module}.{name}"
            for module, name in _imports(path)
            if name.startswith("_") and module != f"myobridge.{own}"
        ]
    else:
        private = [f"{module}.{name}" for module, name in _imports(path) if module.startswith("myobridge.")]
        private = [name for name in private if any(part.startswith("_") for part in name.split("."))]
    assert [name for name in private if not name.startswith("__future__")] == []


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_one_idea_a_file(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_names_say_what_a_thing_is(path: Path) -> None:
    classes = [
        node.name for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.ClassDef)
    ]
    names = [part.removesuffix(".py") for part in path.relative_to(ROOT).parts] + classes
    assert [name for name in names if FORBIDDEN.search(name)] == []


@pytest.mark.parametrize(
    "name", ["utils", "my_helpers", "manager", "SolidBase", "BaseSolid", "ModelImpl", "RunManager"]
)
def test_forbidden_names_are_recognised(name: str) -> None:
    assert FORBIDDEN.search(name)


def test_top_level_is_what_was_agreed() -> None:
    agreed = {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "core", "plugins", "tests", "examples", "docs"}
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:  # an unpacked source distribution has no history; then look at what is there
        found = {path.name for path in ROOT.iterdir()}
    else:
        found = {line.split("/")[0] for line in listed.stdout.splitlines()}
    assert {name for name in found if not name.startswith(".")} <= agreed
    assert {"pyproject.toml", "core", "plugins", "tests"} <= found
