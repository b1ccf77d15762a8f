"""The command line: what it prints, what it writes, how it ends."""

from __future__ import annotations

import json
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
from myobridge import simulation as simulation_module
from myobridge.cli import main


def test_run_prints_settings_effects_ledger_times_and_writes_the_file(cli, write, scenes, tmp_path: Path) -> None:
    code, out, err = cli("run", write(scenes["clamp"]))
    assert (code, err) == (0, "")
    assert (tmp_path / "scene.h5").is_file()
    for words in (
        "settings of 'clamp'",
        "effects",
        "ledger",
        "energy drift",
        "residual",
        "wrote scene.h5",
        "iterations",
    ):
        assert words in out
    assert re.search(r"solid +│ plugin +│ clamp", out)
    assert re.search(r"p_max +│ 73000 +│ Pa", out), "settings that were not given are shown too"
    assert re.search(r"mechanics +│ +[\d.]+ │ +[\d.]+ %", out)
    assert re.search(r"cross_bridges +│ on ", out)
    assert re.search(r"gravity +│ off +│ not called for", out)


BODY = """
[scene]
name = "block"
effects = ["incompressibility"]
[continuation]
plugin = "natural"
step = 0.5
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.04, 0.01], cells = [4, 1] }
material = "neo_hooke"
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [1e4, 0.0]
"""


def test_the_linear_solver_and_its_reason_are_printed(cli, write) -> None:
    _, explained, _ = cli("explain", write(BODY))
    assert re.search(r"linear solver +│ dense \(\d+ unknowns\)", explained)
    finer = ("--set", "solid.mesh.cells=[16, 4]")
    _, out, _ = cli("run", write(BODY), *finer)
    assert re.search(r"linear solver: superlu \(\d+ unknowns in 2D: about [\d.]+ s a system, \w+ [\d.]+ s\)", out)
    given = ("--set", "continuation.newton.plugin=inexact", "--set", "continuation.newton.linear=amg_gmres")
    _, out, _ = cli("run", write(BODY), *finer, *given)
    assert "linear solver: AmgGmres, as the scene says" in out


def test_verbose_prints_every_iteration(cli, write) -> None:
    _, quiet, _ = cli("run", write(BODY))
    assert "newton:" not in quiet
    _, out, _ = cli("run", write(BODY), "-v")
    found = re.findall(r"newton: iteration (\d+): residual ([\d.e+-]+) -> ([\d.e+-]+), step 1", out)
    spent = sum(int(n) for n in re.findall(r"scale .*: (\d+) iterations", out))
    assert len(found) == spent > 2
    assert all(float(after) < float(before) for _, before, after in found)


def test_quiet_prints_nothing(cli, write, scenes, tmp_path: Path) -> None:
    assert cli("run", write(scenes["clamp"]), "-q", "-o", "quiet.h5") == (0, "", "")
    assert (tmp_path / "quiet.h5").is_file()


def test_names_with_markup_are_printed_as_they_are(cli, write, scenes) -> None:
    path = write(scenes["clamp"].replace('"clamp"\neffects', '"[/red] [bold]x"\neffects'))
    code, out, _ = cli("run", path)
    assert code == 0
    assert "settings of '[/red] [bold]x'" in out


def test_set_overrides_keys_of_every_kind(cli, write, scenes, tmp_path: Path) -> None:
    settings = (
        "scene.duration=0.005",
        "solid.sites=3",
        "solid.path.final=0.9",
        "record.sites=[0, 2]",
        "scene.name=short",
    )
    words = [word for item in settings for word in ("--set", item)]
    assert cli("run", write(scenes["clamp"]), "-q", *words).code == 0
    result = mb.Result.load(tmp_path / "scene.h5")
    assert result["time"][-1] == pytest.approx(0.005, abs=1e-15)
    assert result["stretch"].shape == (6, 2)
    scene = mb.Scene.from_toml(result.scene)
    assert (scene.name, scene.solid["sites"], scene.solid["path"]["final"]) == ("short", 3, 0.9)


def test_explain_says_what_is_there_what_is_not_and_computes_nothing(
    cli, write, scenes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What a step costs is measured by a few steps where it is not known yet (tests/core/test_study_prediction.py).
    monkeypatch.setattr("myobridge.study.prediction.predicted", lambda plan: None)
    monkeypatch.setattr(simulation_module.Simulation, "step", lambda self, end=0.0: pytest.fail("explain stepped"))
    code, out, err = cli("explain", write(scenes["chain"]))
    assert (code, err) == (0, "")
    assert "4 unknowns" in out
    assert "4 sites" in out
    assert "20 steps of 0.001 s" in out
    assert re.search(r"population +│.*3 values a site", out)
    assert re.search(r"activation +│ on +│ .*activation 'ramp'", out)
    assert re.search(r"inertia +│ off +│ not called for", out)
    assert re.search(r"force_velocity +│ inherent +│ always there in cross_bridges 'distributed_moment'", out)
    assert not list(tmp_path.glob("*.h5"))


def test_plugins_lists_everything_installed(cli) -> None:
    code, out, _ = cli("plugins")
    assert code == 0
    rows = json.loads(cli("plugins", "--json").out)
    assert {"name", "family", "package", "version", "effects", "description"} == set(rows[0])
    assert [row for row in rows if not row["description"]] == []
    assert {(row["family"], row["name"]) for row in rows} == {(item.family, item.name) for item in mb.registry()}
    for row in rows:
        assert row["name"] in out
    by_name = {row["name"]: row for row in rows if row["family"] == "cross_bridge"}
    assert "length_dependence" in by_name["hill"]["effects"]
    assert by_name["hill"]["package"] == "myobridge"


@pytest.mark.parametrize("name", ["clamp", "spring", "chain", "rope", "passive"])
def test_show_draws_every_kind_of_result(name: str, cli, write, scenes, tmp_path: Path) -> None:
    cli("run", write(scenes[name]), "-q")
    code, out, err = cli("show", "scene.h5", "-o", "picture.png")
    assert (code, err) == (0, "")
    assert "wrote picture.png" in out
    picture = (tmp_path / "picture.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 10_000


def test_show_of_what_is_no_result(cli, write, scenes, tmp_path: Path) -> None:
    outcome = cli("show", write(scenes["clamp"]))
    assert outcome.code == 2
    assert "is damaged, or no result of myobridge" in outcome.err
    assert cli("show", "nothing.h5").code == 2
    cli("run", tmp_path / "scene.toml", "-q")
    outcome = cli("show", "scene.h5", "-o", "picture.docx")
    assert outcome.code == 2
    assert "picture.docx: the picture cannot be written" in outcome.err


@pytest.fixture
def no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever steps, fails."""
    monkeypatch.setattr(simulation_module.Simulation, "step", lambda self, end=0.0: pytest.fail("it stepped"))


@pytest.mark.usefixtures("no_step")
@pytest.mark.parametrize(
    ("output", "says"),
    [
        ("nowhere/result.h5", "there is no folder nowhere"),
        ("scene.toml/result.h5", "there is no folder scene.toml"),
        ("folder", "is a folder; name a file in it"),
        ("scene.toml", "exists and is no result file; it is not overwritten"),
        ("x" * 250 + ".h5", "cannot be written (File name too long)"),
    ],
)
def test_an_impossible_output_is_said_before_the_first_step(
    output: str, says: str, cli, write, scenes, tmp_path
) -> None:
    (tmp_path / "folder").mkdir()
    path = write(scenes["clamp"])
    code, _, err = cli("run", path, "-o", output)
    assert code == 2
    assert f"{output}: " in err
    assert says in err
    assert path.read_text() == scenes["clamp"]


@pytest.mark.usefixtures("no_step")
def test_a_folder_that_is_read_only_is_said_before_the_first_step(
    cli, write, scenes, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The permission itself cannot be taken from an administrator, under whom tests may run.
    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "touch", refuse)
    code, _, err = cli("run", write(scenes["clamp"]), "-o", "result.h5")
    assert code == 2
    assert err == "myobridge: result.h5: cannot be written (Permission denied)\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "run: give a scene file, or --resume"),
        (("scene.toml", "--resume", "x.h5"), "run: give a scene file, or --resume"),
        (("--resume", "nothing.h5"), "nothing.h5: there is no such file"),
        (("scene.toml", "--until", "-1"), "--until -1.0: expected a time"),
        (("scene.toml", "--until", "nan"), "--until nan: expected a time"),
    ],
)
def test_wrong_arguments(arguments: tuple[str, ...], says: str, cli, write, scenes) -> None:
    write(scenes["clamp"])
    code, out, err = cli("run", *arguments)
    assert (code, out) == (2, "")
    assert says in err


@pytest.mark.parametrize("arguments", [["walk"], ["run", "--until", "soon"], []])
def test_what_is_no_command_has_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert "usage: myobridge" in capsys.readouterr().err


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"myobridge {mb.__version__}\n"


def test_a_run_stopped_by_until_and_resumed_is_the_whole_run(cli, write, scenes, tmp_path: Path) -> None:
    path = write(scenes["chain"])
    assert cli("run", path, "-q", "-o", "whole.h5").code == 0
    assert cli("run", path, "-q", "-o", "part.h5", "--until", "0.0115").code == 0
    assert mb.Result.load(tmp_path / "part.h5")["time"][-1] == pytest.approx(0.012, abs=1e-15)
    assert cli("run", "-q", "--resume", "part.h5").code == 0
    whole, resumed = mb.Result.load(tmp_path / "whole.h5"), mb.Result.load(tmp_path / "part.h5")
    for name, rows in whole.series.items():
        np.testing.assert_array_equal(rows, resumed.series[name], err_msg=name)


def test_resuming_what_is_finished_says_so(cli, write, scenes) -> None:
    cli("run", write(scenes["clamp"]), "-q")
    code, out, _ = cli("run", "--resume", "scene.h5")
    assert code == 0
    assert "is the end already" in out


def test_a_run_that_fails_has_code_1_and_keeps_what_it_had(cli, write, scenes, tmp_path: Path) -> None:
    # The load turns the line inside out: no step is small enough.
    path = write(scenes["chain"].replace("length = 0.1", 'length = 0.1\nload = { plugin = "ramp", slope = -2e4 }'))
    code, _, err = cli("run", path, "-q")
    assert code == 1
    assert "failed even after 12 halvings" in err
    assert "Traceback" not in err
    kept = mb.Result.load(tmp_path / "scene.h5")
    assert 0.0 < kept["time"][-1] < 0.02
    assert np.all(np.isfinite(kept["tension"]))


PROGRAM = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job is born deaf to it
from myobridge.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_a_killed_run_leaves_a_file_that_opens_and_resumes(
    number: int, code: int, write, scenes, tmp_path: Path
) -> None:
    path = write(scenes["spring"])
    output = tmp_path / "result.h5"
    settings = ["--set", "scene.duration=1e3", "--set", "record.checkpoint_every=0.01", "--set", "record.every=13"]
    command = [sys.executable, "-c", PROGRAM, "run", str(path), "-q", "-o", str(output), *settings]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        while not output.exists() and process.poll() is None:
            time.sleep(0.01)
        time.sleep(0.2)
        os.kill(process.pid, number)
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == code, err
    assert "Traceback" not in err
    left = mb.Result.load(output)
    steps = int(left.checkpoint.scalars["steps"])
    assert 0 < steps < 10**6
    end = (steps + 20) * 1e-3
    continued, scene = mb.resume(output, tmp_path / "resumed.h5", {"scene.duration": end})
    resumed = continued.to(scene.duration)
    whole = mb.run(scene)
    assert whole.checkpoint.scalars["steps"] == steps + 20
    for name, rows in whole.series.items():
        np.testing.assert_array_equal(rows, resumed.series[name], err_msg=name)
    if number != signal.SIGKILL:
        assert not output.with_name("result.h5.part").exists()


def test_a_view_may_begin_with_a_minus(cli, write, tmp_path: Path) -> None:
    cli("run", write(BODY), "-q")
    for words in (["--view", "-60,22"], ["--view=-60,22"]):
        code, _, err = cli("show", "scene.h5", *words)
        assert (code, err) == (0, "")
