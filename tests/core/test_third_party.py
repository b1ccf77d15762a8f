"""A stranger's package: its own project, its own entry points, installed beside the project, run from a scene.

The package is that of the plugin author's guide, ``docs/plugins.md``, file by file.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import myobridge as mb

SOFTNESS, SLIP = 0.04, 10.0  # of the page's scene


@pytest.fixture(scope="module")
def source(blocks, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of the guide, in a folder of their own."""
    folder = tmp_path_factory.mktemp("rubber-heads")
    for block in blocks("plugins.md"):
        if block.file:
            (folder / block.file).parent.mkdir(exist_ok=True)
            (folder / block.file).write_text(block.text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def installed(source, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Mapping[str, str]]:
    """The package built and installed into a folder of its own, and an environment that sees it."""
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


def test_a_scene_runs_with_the_model_of_a_stranger(installed, source, tmp_path: Path) -> None:
    _, environment = installed
    shutil.copy(source / "rubber.toml", tmp_path)
    out = python(["-m", "myobridge.cli", "run", "rubber.toml"], environment, tmp_path)
    assert "slip_rate" in out
    result = mb.Result.load(tmp_path / "rubber.h5")
    assert result.provenance["plugin cross_bridges"] == "rubber"
    # Each step slips by half, shortens along the spring of the heads, slips by half.
    kept, tension = math.exp(-0.5e-3 * SLIP), [1.0]
    for change in np.diff(result["stretch"][:, 0]):
        tension.append(kept * (kept * tension[-1] + change / SOFTNESS))
    assert tension[-1] < 0.7
    np.testing.assert_allclose(result["tension"][:, 0], 5e4 * np.array(tension), rtol=1e-12)
    assert np.abs(result["energy/residual"]).max() < 1e-14


def test_it_is_listed_with_package_and_version(installed, tmp_path: Path) -> None:
    _, environment = installed
    rows = json.loads(python(["-m", "myobridge.cli", "plugins", "--json"], environment, tmp_path))
    (row,) = [row for row in rows if row["name"] == "rubber"]
    assert (row["package"], row["version"], row["family"]) == ("rubber-heads", "3.1.4", "cross_bridge")
    assert row["description"] == "heads that never let go"
    assert row["effects"] == ["cross_bridges", "slip"]
    named = {(row["family"], row["name"]) for row in rows if row["package"] == "rubber-heads"}
    plugins = {("cross_bridge", "rubber"), ("signal", "delayed"), ("material", "gent"), ("mesh", "wedge")}
    assert named == plugins | {("stability_case", "swinging")}
    assert {row["package"] for row in rows} == {"myobridge", "rubber-heads"}


def test_a_body_is_made_of_the_material_of_a_stranger(installed, source, tmp_path: Path) -> None:
    _, environment = installed
    shutil.copy(source / "gent.toml", tmp_path)
    python(["-m", "myobridge.cli", "run", "gent.toml"], environment, tmp_path)
    result = mb.Result.load(tmp_path / "gent.h5")
    # Plane strain, volume kept: I1 - 3 = (s - 1/s)^2, and the nominal stress is mu g (s - 1/s^3).
    s = result["stretch"][-1]
    assert s.min() > 1.4
    np.testing.assert_allclose(1e5 * 2.0 / (2.0 - (s - 1.0 / s) ** 2) * (s - s**-3), 3e5, rtol=1e-9)


@pytest.mark.parametrize("page", ["test_rubber.py", "test_gent.py"])
def test_its_author_tests_it_with_the_same_kit(page, installed, source, tmp_path: Path) -> None:
    _, environment = installed
    shutil.copy(source / page, tmp_path)
    out = python(["-m", "pytest", "-q", "-p", "no:cacheprovider", page], environment, tmp_path)
    assert " passed" in out
    assert "failed" not in out


def test_its_case_and_its_model_are_in_the_atlas(installed, tmp_path: Path) -> None:
    _, environment = installed
    words = ["--method", "default", "midpoint", "backward_euler", "--workers", "1", "-q"]
    python(["-m", "myobridge.cli", "stability", "--case", "swinging", *words], environment, tmp_path)
    data = json.loads((tmp_path / "atlas" / "atlas.json").read_text())
    found = {cell["method"]: cell for cell in data["cells"]}
    assert {name: cell["outcome"] for name, cell in found.items()} == {
        "default": "holds",
        "midpoint": "holds",
        "backward_euler": "fails",
    }
    assert found["default"]["measured"]["steps"] == 500
    out = python(["-m", "myobridge.cli", "stability", "--list", "--method", "rubber"], environment, tmp_path)
    assert "contraction:plain/cross_bridges/rubber" in out


def test_without_it_the_scene_names_what_is_missing(source, cli) -> None:
    outcome = cli("run", source / "rubber.toml")
    assert outcome.code == 2
    assert "no effect 'slip'" in outcome.err
