"""Small scenes, and the command line called in this process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest

from myobridge.cli import main

CLAMP = """
[scene]
name = "clamp"
effects = ["cross_bridges"]
duration = 0.02
step = 1e-3
[solid]
plugin = "clamp"
sites = 2
path = { plugin = "ramp", initial = 1.0, final = 0.98, start = 0.005, end = 0.015 }
[cross_bridges]
plugin = "distributed_moment"
"""

SPRING = """
[scene]
name = "spring"
effects = ["cross_bridges", "inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 0.1
stiffness = 500.0
velocity = 0.05
[cross_bridges]
plugin = "liouville"
"""

CHAIN = """
[scene]
name = "chain"
effects = ["cross_bridges", "activation"]
duration = 0.02
step = 1e-3
[solid]
plugin = "chain"
springs = 4
length = 0.1
[cross_bridges]
plugin = "distributed_moment"
[activation]
plugin = "ramp"
initial = 0.2
final = 1.0
end = 0.01
"""

ROPE = """
[scene]
name = "rope"
effects = ["cross_bridges", "inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "rope"
elements = 2
modulus = 1e6
length = 0.1
mass = 0.01
stretch_at_start = 1.02
[cross_bridges]
plugin = "hill"
"""

PASSIVE = """
[scene]
name = "passive"
effects = ["inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 0.1
stiffness = 500.0
velocity = 0.05
"""


class Outcome(NamedTuple):
    """What a call of the command line gave."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session")
def scenes() -> Mapping[str, str]:
    """TOML of small scenes by name."""
    return {"clamp": CLAMP, "spring": SPRING, "chain": CHAIN, "rope": ROPE, "passive": PASSIVE}


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    """Write the text of a scene into a file of its own."""

    def to_file(text: str, name: str = "scene.toml") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return to_file


@pytest.fixture
def cli(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Outcome]:
    """Call ``myobridge ARGUMENTS`` in this process, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")  # tables are not folded

    def call(*arguments: object) -> Outcome:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        said = capsys.readouterr()
        return Outcome(code, said.out, said.err)

    return call
