"""Runs of scenes without time: what is printed and written, failures, interrupts, and paths that are continued."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import myobridge as mb
from myobridge.static_run import UnstableEquilibrium

CHAIN = """
[scene]
name = "pulled"
effects = ["cross_bridges"]
[solid]
plugin = "chain"
springs = 3
length = 0.1
modulus = 1e6
load = { plugin = "constant", level = 2.0 }
[cross_bridges]
plugin = "hill"
[continuation]
plugin = "natural"
to = 1.2
report = [0, 0.4, 0.8, 1.2]
"""

# A fibre beyond its optimum: the more it is stretched the less it pulls. The load k x + A T(x) has a top and a valley.
POPPING = """
[scene]
name = "popping"
effects = ["cross_bridges", "length_dependence"]
[solid]
plugin = "spring"
stiffness = 20.0
load = { plugin = "constant", level = 15.0 }
[cross_bridges]
plugin = "hill"
[continuation]
plugin = "natural"
of = "load"
step = 0.04
"""


def popping_limit() -> float:
    """Largest load that the fibre bears before it pops [N], over 15 N."""
    overlap = mb.registry().find("overlap", "gaussian").cls()
    x = np.linspace(-0.05, 0.2, 200_001)
    load = 20.0 * x + 1e-4 * 73e3 * overlap.fraction(1.0 + x / 0.1)
    top = np.flatnonzero(np.diff(load) < 0.0)[0]
    return float(load[top]) / 15.0


def test_run_tells_every_point_the_table_and_the_file(cli, write, tmp_path: Path) -> None:
    code, out, err = cli("run", write(CHAIN))
    assert (code, err) == (0, "")
    told = re.findall(r"^scale ([\d.]+) of 1\.2: \d+ iterations, stable(, kept)?$", out, re.MULTILINE)
    result = mb.Result.load(tmp_path / "scene.h5")
    np.testing.assert_allclose([float(scale) for scale, _ in told], result["scale"], atol=1e-6)
    assert [float(scale) for scale, kept in told if kept] == [0.0, 0.4, 0.8, 1.2]
    assert re.search(r"in all +│ +13 │", out)
    assert "wrote scene.h5" in out
    assert re.search(r"continuation +│ plugin +│ natural", out)
    assert result.provenance["plugin continuation"] == "natural"
    assert "time" not in result.series
    stretch = 1.0 + (2.0 / 1e-4 - 73e3 * result["scale"]) / 1e6
    np.testing.assert_allclose(result["stretch"], np.tile(stretch[:, None], 3), rtol=1e-9)


def test_quiet_prints_nothing_but_what_is_unstable(cli, write) -> None:
    assert cli("run", write(CHAIN), "-q") == (0, "", "")
    stretched = POPPING.replace("natural", "arclength").replace("step = 0.04", "largest = 0.03")
    code, out, err = cli("run", write(stretched), "-q")
    assert (code, out) == (0, "")
    assert re.fullmatch(r"myobridge: WARNING: \d+ of \d+ states are unstable, at scales from .*\n", err)


def test_until_has_no_meaning(cli, write) -> None:
    code, _, err = cli("run", write(CHAIN), "--until", "1")
    assert code == 2
    assert "the scene has no time; set continuation.to" in err


def test_a_path_that_ends_early_is_kept_and_goes_on_with_another_strategy(cli, write, tmp_path: Path) -> None:
    code, out, err = cli("run", write(POPPING))
    assert code == 1
    limit = popping_limit()
    assert 0.3 < limit < 0.9
    for words in ("natural continuation stopped at level", "limit point", "'arclength'", "is in scene.h5", "--resume"):
        assert words in err
    assert re.search(r"in all +│", out), "the table of the path so far"
    first = mb.Result.load(tmp_path / "scene.h5")
    assert first["scale"][-1] == pytest.approx(limit, abs=2e-4)
    assert set(first["negative_eigenvalues"]) == {0.0}

    code, out, err = cli(
        "run", "--resume", "scene.h5", "--set", "continuation.plugin=arclength", "--set", "continuation.largest=0.03"
    )
    assert code == 0, err
    assert "UNSTABLE: 1 negative eigenvalues" in out
    assert "myobridge: WARNING:" in err
    result = mb.Result.load(tmp_path / "scene.h5")
    rows = len(first["scale"])
    np.testing.assert_array_equal(result["scale"][:rows], first["scale"])
    assert result["scale"][-1] == 1.0
    falling = np.diff(result["scale"]) < 0.0
    assert falling.any()
    assert np.all(np.diff(result["stretch"][:, 0]) > 0.0), "the path goes on, it is not retraced"
    steep = 20.0 * (result["stretch"][-1, 0] - 1.0) * 0.1
    assert steep == pytest.approx(15.0, rel=1e-6), "popped, the fibre does not pull any more"

    code, out, err = cli("run", "--resume", "scene.h5")
    assert code == 0
    assert "complete already" in out


def test_python_is_told_too(write, tmp_path: Path) -> None:
    path = write(POPPING)
    with pytest.raises(mb.ContinuationFailed, match="limit point") as caught:
        mb.run(path, tmp_path / "a.h5")
    assert caught.value.result["scale"][-1] == pytest.approx(popping_limit(), abs=2e-4)
    with pytest.warns(UnstableEquilibrium):
        mb.run(path, settings={"continuation.plugin": "arclength", "continuation.largest": 0.03})


def test_nothing_found_writes_no_file(cli, write, tmp_path: Path) -> None:
    """A spring without stiffness: no equilibrium under its load."""
    text = CHAIN.replace('"chain"\nsprings = 3\nlength = 0.1\nmodulus = 1e6', '"spring"\nstiffness = 0.0')
    code, _, err = cli("run", write(text))
    assert code == 1
    assert "no equilibrium at level 0" in err
    assert "of = 'tension_and_load' raises them" in err
    assert "no file was written" in err
    assert not list(tmp_path.glob("*.h5"))


@pytest.mark.parametrize("strategy", ["natural", "arclength"])
def test_an_interrupted_path_is_on_disk_and_continued(strategy: str, write, tmp_path: Path) -> None:
    """Ctrl-C after the sixth point; the states that were reported are there once, and the end is the same."""
    path = write(CHAIN)
    settings = {"continuation.plugin": strategy, "continuation.step": 0.1}
    whole = mb.run(path, settings=settings)
    plan = mb.Plan.of(mb.Scene.load(path, settings))
    from myobridge.run import start

    run = start(plan, tmp_path / "part.h5")
    assert isinstance(run, mb.StaticRun)
    count = 0

    def interrupt(statics: mb.Statics, point: mb.PathPoint) -> None:
        nonlocal count
        count += 1
        if count == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.trace(interrupt)
    part = mb.Result.load(tmp_path / "part.h5")
    assert len(part["scale"]) == 4
    assert part["scale"][-1] < 1.2
    continued, scene = mb.resume(tmp_path / "part.h5")
    assert scene == plan.scene
    assert isinstance(continued, mb.StaticRun)
    result = continued.trace()
    np.testing.assert_array_equal(result["scale"][:4], part["scale"])
    assert np.all(np.diff(result["scale"]) > 0.0)
    assert list(result["scale"][result["kept"] == 1.0]) == [0.0, 0.4, 0.8, 1.2]
    np.testing.assert_allclose(result["stretch"][-1], whole["stretch"][-1], rtol=1e-12)
    assert mb.Result.load(tmp_path / "part.h5")["scale"][-1] == 1.2


@pytest.mark.parametrize("key", ["solid.modulus", "continuation.to", "continuation.of", "scene.duration"])
def test_what_would_be_another_problem_cannot_be_resumed(key: str, cli, write) -> None:
    cli("run", write(CHAIN), "-q")
    code, _, err = cli("run", "--resume", "scene.h5", "--set", f"{key}=2")
    assert code == 2
    assert f"--set {key}: cannot change when a run is resumed" in err
    assert "continuation.plugin" in err


def test_the_file_of_another_problem_is_refused(write, tmp_path: Path) -> None:
    result = mb.run(write(CHAIN), tmp_path / "a.h5")
    with pytest.raises(mb.MyobridgeError, match="the path does not fit the scene"):
        mb.StaticRun(mb.Plan.of(mb.Scene.load(write(POPPING, "b.toml"))).composed()).resume(result)  # pyright: ignore


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_path_at_a_whole_point(number: int, code: int, write, tmp_path: Path) -> None:
    path = write(CHAIN.replace("report = [0, 0.4, 0.8, 1.2]", "step = 1e-5\nsmallest = 1e-6"))
    # A job that a script put into the background is born deaf to Ctrl-C.
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    program += "from myobridge.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-u", "-c", program, "run", str(path), "-o", str(tmp_path / "out.h5")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("scale"):
                break
        time.sleep(0.2)
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    assert process.returncode == code, err
    assert "--resume" in err
    part = mb.Result.load(tmp_path / "out.h5")
    assert 1 < len(part["scale"]) < 1e5
    np.testing.assert_allclose(part["scale"], 1.2e-5 * np.arange(len(part["scale"])), rtol=1e-9, atol=1e-15)


BODY = """
[scene]
name = "body"
effects = ["cross_bridges", "incompressibility"]
[solid]
plugin = "finite_element"
material = { plugin = "mooney_rivlin" }
mesh = { plugin = "block", size = [0.1, 0.025], cells = [3, 1] }
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [3e3, 2e2]
[[load]]
plugin = "pressure"
boundary = "top"
pressure = 1e3
[cross_bridges]
plugin = "prescribed"
[continuation]
plugin = "natural"
step = 0.5
to = 1.2
report = [0, 0.4, 1.2]
"""


@pytest.mark.parametrize(
    ("strategy", "of"),
    [
        ("natural", "tension"),
        ("natural", "load"),
        ("arclength", "tension_and_load"),
        ("two_parameter", "tension_and_load"),
    ],
)
def test_a_body_of_finite_elements(strategy: str, of: str) -> None:
    """All strategies find the same body; its supports hold the scaled load; its fields are those of the kept scales."""
    settings = {"continuation.plugin": strategy, "continuation.of": of}
    result = mb.run(mb.Scene.from_toml(BODY), settings=settings)
    assert list(result["scale"][result["kept"] == 1.0]) == [0.0, 0.4, 1.2]
    assert [state.time for state in result.fields] == [0.0, 0.4, 1.2]
    assert {state.label for state in result.fields} == {"scale"}
    assert set(result["negative_eigenvalues"]) == {0.0}
    volume = result.fields[-1]["J"]
    assert np.abs(volume - 1.0).max() < 0.1, "strictly incompressible in the mean of an element"
    share = result["scale"] if of != "tension" else np.ones_like(result["scale"])
    pull = np.array([3e3, 2e2]) * 0.025
    held = result["reaction/left"]
    push = -(held + share[:, None] * pull) / np.where(share > 0.0, share, 1.0)[:, None]
    # What is left is the pressure: p times the length of the deformed top turned by a right angle.
    assert np.all(np.abs(push[share > 0.0]) < 1e3 * 0.13)
    if strategy != "natural":
        expected = mb.run(mb.Scene.from_toml(BODY), settings={"continuation.of": of})
        end = result.fields[-1]["displacement"]
        np.testing.assert_allclose(end, expected.fields[-1]["displacement"], atol=1e-9)
        np.testing.assert_allclose(held[-1], expected["reaction/left"][-1], rtol=1e-6)


def test_an_interrupted_body_keeps_its_last_state_for_the_picture_only(tmp_path: Path) -> None:
    from myobridge.run import start

    scene = mb.Scene.from_toml(BODY)
    run = start(mb.Plan.of(scene), tmp_path / "body.h5")
    assert isinstance(run, mb.StaticRun)

    def interrupt(statics: mb.Statics, point: mb.PathPoint) -> None:
        if 0.4 < point.level < 1.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.trace(interrupt)
    part = mb.Result.load(tmp_path / "body.h5")
    assert [state.time for state in part.fields] == pytest.approx([0.0, 0.4, part["scale"][-1]])
    assert part["kept"][-1] == 0.0
    continued, _ = mb.resume(tmp_path / "body.h5")
    assert isinstance(continued, mb.StaticRun)
    result = continued.trace()
    assert [state.time for state in result.fields] == [0.0, 0.4, 1.2]
