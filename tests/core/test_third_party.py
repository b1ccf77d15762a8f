"""A stranger's package: its own project, its own entry point, installed beside the project, run from a scene."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import myobridge as mb

PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "rubber-heads"
version = "3.1.4"
dependencies = ["myobridge"]

[project.entry-points.myobridge]
rubber-heads = "rubber_heads.model"
"""

MODEL = '''
"""Heads that never let go and hold like rubber."""

from functools import cached_property
from typing import ClassVar, final

import attrs
import numpy as np

from myobridge import AffineLaw, CrossBridgeModel, Fluxes, Promises, hookimpl
from myobridge.parameters import number


@final
@attrs.frozen
class Rubber(CrossBridgeModel):
    """State: Q0, Q1, Q2 of heads that slide; they attach and detach in equal numbers."""

    summary: ClassVar[str] = "heads that never let go"
    inherent_effects: ClassVar[frozenset[str]] = frozenset({"cross_bridges", "elasticity_of_heads"})
    has_statics: ClassVar[bool] = False

    p_max: float = number(5e4, unit="Pa", within="(0, inf)", doc="tension at the start")
    softness: float = number(0.02, within="(0, inf)", doc="stretch that takes all tension away")

    @property
    def gear(self) -> float:
        return 1.0 / self.softness

    @property
    def promises(self) -> Promises:
        return Promises(order=2)

    def initial_state(self, n_sites):
        return np.tile([1.0, 1.0, 1.1], (n_sites, 1))

    def react(self, state, activation, stretch, dt, out=None):
        if out is None:
            return state.copy(), Fluxes.zero(len(state))
        if out is not state:
            out[...] = state
        return out, Fluxes.zero(len(state))

    def slide(self, state, displacement, out=None):
        q0, q1, q2 = state.T.copy()
        out = np.empty_like(state) if out is None else out
        out[:, 0], out[:, 1], out[:, 2] = q0, q1 + displacement * q0, q2 + displacement * (2 * q1 + displacement * q0)
        return out

    def active_law(self, state, activation, stretch):
        return AffineLaw(stretch, state[:, 1].copy(), self.gear * state[:, 0])

    def moments(self, state):
        return state.copy()

    def energy(self, state):
        return 0.5 * state[:, 2] / self.gear


@hookimpl
def myobridge_cross_bridges():
    return {"rubber": Rubber}
'''

OWN_TEST = """
import pytest
from myobridge.testing import cross_bridge_checks
from rubber_heads.model import Rubber


@pytest.mark.parametrize("check", cross_bridge_checks(Rubber()), ids=lambda check: check.__name__)
def test_contract(check):
    check()
"""

SCENE = """
[scene]
name = "rubber"
effects = ["cross_bridges", "elasticity_of_heads"]
duration = 0.01
step = 1e-3
[solid]
plugin = "clamp"
path = { plugin = "ramp", initial = 1.0, final = 0.99, end = 0.01 }
[cross_bridges]
plugin = "rubber"
softness = 0.04
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Mapping[str, str]]:
    """The package built and installed into a folder of its own, and an environment that sees it."""
    source = tmp_path_factory.mktemp("rubber-heads")
    (source / "pyproject.toml").write_text(PROJECT)
    (source / "rubber_heads").mkdir()
    (source / "rubber_heads" / "__init__.py").write_text("")
    (source / "rubber_heads" / "model.py").write_text(MODEL)
    target = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--no-build-isolation", "--no-index", "--target", str(target), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    paths = [str(target), *filter(None, [os.environ.get("PYTHONPATH")])]
    return target, {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def python(arguments: list[str], environment: Mapping[str, str], folder: Path) -> str:
    """Output of a fresh interpreter, which must end well and complain of nothing."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *arguments],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_scene_runs_with_the_model_of_a_stranger(installed, tmp_path: Path) -> None:
    _, environment = installed
    (tmp_path / "scene.toml").write_text(SCENE)
    out = python(["-m", "myobridge.cli", "run", "scene.toml"], environment, tmp_path)
    assert "elasticity_of_heads" in out
    result = mb.Result.load(tmp_path / "scene.h5")
    assert result.provenance["plugin cross_bridges"] == "rubber"
    # Tension falls from p_max along the spring of the heads: p_max (1 + (lambda - 1) / softness).
    expected = 5e4 * (1.0 + (result["stretch"] - 1.0) / 0.04)
    assert expected[-1, 0] == pytest.approx(0.75 * 5e4, rel=1e-12)
    np.testing.assert_allclose(result["tension"], expected, rtol=1e-12)
    assert np.abs(result["energy/residual"]).max() < 1e-14


def test_it_is_listed_with_package_and_version(installed, tmp_path: Path) -> None:
    _, environment = installed
    rows = json.loads(python(["-m", "myobridge.cli", "plugins", "--json"], environment, tmp_path))
    (row,) = [row for row in rows if row["name"] == "rubber"]
    assert (row["package"], row["version"], row["family"]) == ("rubber-heads", "3.1.4", "cross_bridge")
    assert row["description"] == "heads that never let go"
    assert row["effects"] == ["cross_bridges", "elasticity_of_heads"]
    assert {row["package"] for row in rows} == {"myobridge", "rubber-heads"}


def test_its_author_tests_it_with_the_same_kit(installed, tmp_path: Path) -> None:
    _, environment = installed
    (tmp_path / "test_rubber.py").write_text(OWN_TEST)
    out = python(["-m", "pytest", "-q", "-p", "no:cacheprovider", "test_rubber.py"], environment, tmp_path)
    assert " passed" in out
    assert "failed" not in out


def test_without_it_the_scene_names_what_is_missing(tmp_path: Path, cli, write) -> None:
    outcome = cli("run", write(SCENE))
    assert outcome.code == 2
    assert "no effect 'elasticity_of_heads'" in outcome.err
