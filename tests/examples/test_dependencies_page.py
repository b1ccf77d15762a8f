"""docs/dependencies.md gives the reason for every dependency that pyproject.toml declares, and for none else."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_dependency_has_its_line() -> None:
    said = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = said["project"]
    required = [*said["build-system"]["requires"], *project["dependencies"]]
    for group in project["optional-dependencies"].values():
        required += group
    declared = {re.split(r"[\[<>=!~ ;]", item)[0] for item in required} - {project["name"]}
    page = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    explained = re.findall(r"^\| `([\w-]+)` \|", page, flags=re.MULTILINE)
    assert len(explained) == len(set(explained))
    assert set(explained) == declared
