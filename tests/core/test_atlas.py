"""The stability atlas on tiny cases: what holds, what fails and why, what is kept, who joins."""

from __future__ import annotations

import io
import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar, final

import attrs
import numpy as np
import pytest

import myobridge as mb
from myobridge.atlas import exact_largest_frequency
from myobridge.atlas.largest_step import largest_step
from myobridge.errors import MyobridgeError, PluginError
from myobridge.registry import Registered, registry

SPRING = """
[scene]
name = "tiny"
effects = ["inertia"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 1.0
stiffness = 1e4
displacement = 1e-3
"""


@final
class Tiny(mb.StabilityCase):
    """Twenty steps of an oscillator of 100 rad/s."""

    summary = "a spring"
    scene = SPRING
    limits = (mb.Limit("energy_growth", 1e-9), mb.Limit("halvings", 0))
    vary = ("integrator",)
    methods: ClassVar = {"coarse": {"scene.step": 1e-2, "integrator.plugin": "stoermer_verlet"}}
    expected: ClassVar = {
        "symplectic*": mb.Expectation("fails", "its energy oscillates"),
        "backward_euler": mb.Expectation("fails", "wrongly believed"),
        "bathe": mb.Expectation("holds", "", {"growth_rate": 0.1}),
    }

    def predicted(self, composed: mb.Simulation | mb.Statics) -> Mapping[str, float]:
        return {"growth_rate": 1.0}


@final
class Still(mb.StabilityCase):
    """What is refused."""

    summary = "a spring of negative mass"
    scene = SPRING.replace("mass = 1.0", "mass = -1.0")
    limits = ()
    refused_with = "mass"


def chart_of(case: mb.StabilityCase, *methods: str, name: str = "tiny", **given: object) -> mb.Chart:
    return mb.Atlas([name], methods, extra={name: case}, **given).run(workers=0)  # pyright: ignore[reportArgumentType]


def by_method(chart: mb.Chart) -> dict[str, object]:
    return {finding.method: finding for finding in chart.findings}


@pytest.fixture(scope="module")
def tiny() -> mb.Chart:
    return chart_of(Tiny())


def test_every_installed_integrator_with_inertia_is_tried_once(tiny) -> None:
    names = [finding.method for finding in tiny.findings if finding.axis == "integrator"]
    installed = {item.name for item in registry() if item.family == "time_integrator" and item.cls.inertia}
    assert len(names) == len(set(names))
    assert {*names} == (installed | {"coarse"}) - set(default_of(tiny))
    assert tiny.findings[0].method == "default"


def default_of(chart: mb.Chart) -> tuple[str, ...]:
    return next(cell.method.also for cell in mb.Atlas(["tiny"], extra={"tiny": Tiny()}).cells)


def test_what_holds_and_what_fails_and_why(tiny) -> None:
    found = by_method(tiny)
    assert found["default"].outcome == "holds"
    assert found["default"].expected == "holds"
    assert found["default"].surprise == ""
    assert found["default"].measured["steps"] == 20
    failing = found["stoermer_verlet"]
    assert (failing.outcome, failing.surprise) == ("fails", "")
    assert failing.why == f"energy growth is {failing.measured['energy_growth']:.3g}, at most 1e-09 is allowed"
    # At most (omega dt / 2)^2 of the energy swings, in less than half a period a part of it.
    assert 1e-4 < failing.measured["energy_growth"] < 0.05**2
    assert found["coarse"].measured["steps"] == 2


def test_surprises_are_what_differs_from_what_is_expected(tiny) -> None:
    found = by_method(tiny)
    assert {finding.method for finding in tiny.surprises} == {"backward_euler", "bathe"}
    assert found["backward_euler"].surprise == "must fail, and holds"
    assert found["symplectic_euler"].surprise == ""
    assert found["bathe"].surprise.startswith("growth_rate is ")
    assert found["bathe"].surprise.endswith("predicted is 1 within 10 %")
    assert found["bathe"].predicted == {"growth_rate": 1.0}


def test_a_failing_default_is_a_surprise() -> None:
    @final
    class Impossible(mb.StabilityCase):
        scene = SPRING
        limits = (mb.Limit("energy_loss", -1.0),)

    (finding,) = chart_of(Impossible(), "default").findings
    assert (finding.outcome, finding.surprise) == ("fails", "must hold, and fails")


@pytest.mark.parametrize(("words", "outcome"), [("mass", "holds"), ("volume", "fails")])
def test_a_scene_that_must_be_refused(words, outcome) -> None:
    case = type("Refused", (Still,), {"refused_with": words})() if words != "mass" else Still()
    (finding,) = chart_of(case).findings
    assert finding.outcome == outcome
    assert bool(finding.surprise) == (outcome == "fails")
    if outcome == "fails":
        assert "without the words 'volume'" in finding.why


def test_a_scene_that_should_have_been_refused_and_was_not() -> None:
    case = type("Welcome", (Still,), {"scene": SPRING})()
    (finding,) = chart_of(case).findings
    assert (finding.outcome, finding.why) == ("fails", "the scene was not refused")


def test_methods_that_do_not_go_with_the_scene_do_not_apply() -> None:
    @final
    class Clamped(mb.StabilityCase):
        scene = """
[scene]
effects = ["cross_bridges"]
duration = 0.002
step = 1e-3
[solid]
plugin = "clamp"
path = { plugin = "constant", level = 1.0 }
[cross_bridges]
plugin = "liouville"
"""
        limits = (mb.Limit("ledger_residual", 1e-12),)
        methods: ClassVar = {
            "unknown part": {"cross_bridges.width": -1.0},
            "midpoint": {"integrator.plugin": "midpoint"},
        }

    found = by_method(chart_of(Clamped()))
    assert found["default"].outcome == "holds"
    assert found["unknown part"].outcome == found["midpoint"].outcome == "not applicable"
    assert "width" in found["unknown part"].why
    assert "inertia" in found["midpoint"].why


@pytest.mark.parametrize(
    ("patterns", "says"),
    [
        ({"cases": ["tinny"]}, "--case tinny: matches nothing. Allowed: .*Did you mean 'tiny'?"),
        (
            {"cases": ["tiny"], "methods": ["midpiont"]},
            "--method midpiont: .*Did you mean 'midpoint'?",
        ),
    ],
)
def test_a_pattern_that_matches_nothing_gets_the_nearest_name(patterns, says) -> None:
    with pytest.raises(MyobridgeError, match=says):
        mb.Atlas(**patterns, extra={"tiny": Tiny()})


def test_an_unknown_quantity_is_an_error_of_the_case() -> None:
    case = type("Typo", (Tiny,), {"limits": (mb.Limit("energy_grwoth", 1.0),)})()
    with pytest.raises(PluginError, match=r"'typo': .* 'energy_grwoth'.*Did you mean 'energy_growth'"):
        mb.Atlas(["typo"], extra={"typo": case})


def test_the_default_answers_to_the_names_of_its_plugins() -> None:
    (cell,) = mb.Atlas(["tiny"], [default_of(chart_of(Tiny(), "default"))[0]], extra={"tiny": Tiny()}).cells
    assert cell.method.name == "default"


# --- who joins


@final
@attrs.frozen
class Leaking(mb.TimeIntegrator):
    """Symplectic Euler that makes a little energy in each step."""

    summary: ClassVar[str] = "makes energy"

    def step(self, solid, law, motion, memory, time, dt):
        velocity = 1.001 * (motion.velocity - dt * solid.balance(motion, law, time).force / solid.mass_matrix)
        end = mb.Motion(motion.displacement + dt * velocity, velocity)
        return mb.StepResult(end, memory, mb.StepReport())


@pytest.fixture
def stranger(monkeypatch: pytest.MonkeyPatch) -> None:
    """An integrator of another package, for as long as a test lasts."""
    items = registry()._items["time_integrator"]
    monkeypatch.setitem(items, "leaking", Registered("leaking", "time_integrator", Leaking, "strangers", "1.0"))


@pytest.mark.usefixtures("stranger")
def test_an_integrator_joins_by_being_installed() -> None:
    found = by_method(chart_of(Tiny(), "leaking", "default"))
    assert found["leaking"].outcome == "fails"
    assert found["leaking"].why.startswith("energy growth is ")
    assert found["default"].outcome == "holds"


# --- data


def test_the_data_have_the_promised_form(tiny, tmp_path: Path) -> None:
    data = json.loads(tiny.save(tmp_path / "atlas.json").read_text())
    assert set(data) == {"format", "full", "versions", "quantities", "cases", "cells"}
    assert data["format"] == "myobridge stability atlas 1"
    keys = {"case", "variant", "axis", "method", "outcome", "why", "expected", "because", "surprise", "measured"}
    keys |= {"predicted", "largest_step", "beyond", "seconds", "key"}
    for cell in data["cells"]:
        assert set(cell) == keys
        assert cell["outcome"] in ("holds", "fails", "not applicable")
        assert set(cell["measured"]) <= set(data["quantities"])
    assert data["cases"]["tiny"]["limits"][0] == {"quantity": "energy_growth", "at_most": 1e-9}
    again = mb.Chart.load(tmp_path / "atlas.json")
    assert again.findings == tiny.findings


def test_numbers_that_are_not_finite_are_null() -> None:
    finding = mb.Atlas(["tiny"], extra={"tiny": Tiny()}).run(workers=0).findings[0]
    bad = attrs.evolve(finding, measured={"energy_growth": math.inf, "halvings": 1.0})
    assert bad.measured == {"energy_growth": None, "halvings": 1.0}
    json.loads(json.dumps(bad.as_data(), allow_nan=False))


def test_what_is_no_atlas_is_told(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text('{"format": "something else"}')
    with pytest.raises(MyobridgeError, match="is no stability atlas"):
        mb.Chart.load(tmp_path / "x.json")
    with pytest.raises(MyobridgeError, match="cannot be read"):
        mb.Chart.load(tmp_path / "y.json")


def test_picture_page_and_table(tiny, tmp_path: Path) -> None:
    from rich.console import Console

    from myobridge.atlas.table import chart_table

    assert tiny.draw(tmp_path / "atlas.png").read_bytes().startswith(b"\x89PNG")
    page, picture = tiny.write_page(tmp_path / "stability.md")
    assert picture == tmp_path / "pictures" / "stability.png"
    written = page.read_text()
    assert "pictures/stability.png" in written
    assert "| `stoermer_verlet` | fails |" in written
    assert "`backward_euler`: must fail, and holds" in written
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(chart_table(tiny))
    said = console.export_text()
    assert "2 differ from what is expected" in said
    assert "holds" in said


# --- what is kept


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Addresses of the cells that are really tried."""
    from myobridge.atlas import judgement

    true, seen = judgement.found, []

    def watched(cell):
        seen.append(cell.address)
        return true(cell)

    monkeypatch.setattr(judgement, "found", watched)
    return seen


def atlas(**given: object) -> mb.Atlas:
    return mb.Atlas(["tiny"], ["default", "mid*", "bdf2", "*verlet"], extra={"tiny": Tiny()}, **given)  # pyright: ignore


def test_resume_tries_only_what_is_not_known(tried, tmp_path: Path) -> None:
    whole = atlas().run(tmp_path, workers=0)
    assert len(tried) == len(whole.findings) == 4
    tried.clear()
    again = atlas().run(tmp_path, workers=0, resume=True)
    assert tried == []
    assert again.findings == whole.findings
    atlas().run(tmp_path, workers=0)
    assert len(tried) == 4, "without resume everything is tried anew"


def test_an_interrupted_atlas_goes_on_where_it_was(tried, tmp_path: Path) -> None:
    def stop(finding, left: int) -> None:
        if left == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        atlas().run(tmp_path, workers=0, watch=stop)
    assert len(tried) == 2
    # The line under way when the power failed.
    with (tmp_path / "cells.jsonl").open("a") as file:
        file.write('{"case": "tiny", "vari')
    tried.clear()
    chart = atlas().run(tmp_path, workers=0, resume=True)
    assert len(tried) == 2
    assert len(chart.findings) == 4


def test_a_finding_of_another_scene_is_not_taken_over(tried, tmp_path: Path) -> None:
    atlas().run(tmp_path, workers=0)
    tried.clear()
    softer = type("Softer", (Tiny,), {"scene": SPRING.replace("1e4", "2e4")})()
    mb.Atlas(["tiny"], ["default"], extra={"tiny": softer}).run(tmp_path, workers=0, resume=True)
    assert tried == ["tiny/default/default"]


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(MyobridgeError, match="cannot be written"):
        atlas().run(tmp_path / "file", workers=0)


def test_workers_know_installed_cases_only(tmp_path: Path) -> None:
    with pytest.raises(MyobridgeError, match="set workers = 0"):
        atlas().run(workers=2)


# --- numbers


@pytest.mark.parametrize("limit", [0.3, 1.0, 3.7, 700.0])
def test_the_largest_step_is_found_by_bisection(limit: float) -> None:
    scene = mb.Scene.from_toml(SPRING.replace("duration = 0.02", "duration = 10.0"))
    calls = []

    def holds(other: mb.Scene) -> bool:
        calls.append(other.step)
        return other.step <= limit * 1e-3

    step, beyond = largest_step(scene, holds, limit >= 1.0)
    assert step is not None
    assert beyond == (limit > 64.0)
    assert step == pytest.approx(min(limit, 64.0) * 1e-3, rel=0.05)
    assert step <= limit * 1e-3
    assert len(calls) < 20


def test_no_step_holds() -> None:
    assert largest_step(mb.Scene.from_toml(SPRING), lambda scene: False, False) == (None, False)


def test_the_full_atlas_finds_the_limit_of_verlet() -> None:
    case = type("Bounded", (Tiny,), {"limits": (mb.Limit("energy_growth", 10.0),)})()
    longer = type(case)
    longer.longer = {"scene.duration": 2.0}
    found = by_method(chart_of(longer(), "stoermer_verlet", "default", full=True))
    assert found["stoermer_verlet"].largest_step == pytest.approx(2.0 / 100.0, rel=0.06)
    assert found["default"].beyond
    assert found["default"].measured["largest_step"] > 0.06


def test_the_largest_frequency_is_that_of_the_dense_problem() -> None:
    spring = registry().find("macro_solid", "spring").cls(mass=2.0, stiffness=8e4)
    assert exact_largest_frequency(spring) == pytest.approx(200.0, rel=1e-12)
    chain = registry().find("macro_solid", "chain").cls(springs=40, length=1.0, modulus=1e5, area=1e-4, mass=0.1)
    # Lumped masses: 2 c / h times the sine of the largest wave number, c = sqrt(E A L / m), one end held, one free.
    wave = 2.0 * math.sqrt(1e5 * 1e-4 / 0.1) * 40 * math.sin(0.5 * math.pi * 39.5 / 40)
    assert exact_largest_frequency(chain) == pytest.approx(wave, rel=1e-9)


def test_a_fine_run_stands_for_the_exact_solution() -> None:
    @final
    class Compared(mb.StabilityCase):
        scene = SPRING
        reference: ClassVar = {"scene.step": 2.5e-5}
        limits = (mb.Limit("displacement_error", 0.01),)
        vary = ("integrator",)

    found = by_method(chart_of(Compared(), "default", "backward_euler"))
    assert found["default"].outcome == "holds"
    assert 1e-5 < found["default"].measured["displacement_error"] < 0.01
    assert found["backward_euler"].outcome == "fails"


def test_gauges_are_those_of_closed_forms() -> None:
    """Explicit Euler: the amplitude grows by sqrt(1 + (omega dt)^2) a step, its energy from nothing."""
    case = type("Growing", (Tiny,), {"limits": (mb.Limit("growth_rate", 1e9), mb.Limit("energy_growth", 1e9))})()
    (finding,) = chart_of(case, "half_explicit").findings
    rate = 0.5 * math.log(1.0 + 0.1**2) / 1e-3
    assert finding.measured["growth_rate"] == pytest.approx(rate, rel=1e-6)
    assert finding.measured["energy_growth"] == pytest.approx(1.01**20 - 1.0, rel=1e-6)
    assert np.isfinite(finding.seconds)


# --- workers

PACKAGE = '''
import os, time
from typing import ClassVar
import attrs
from myobridge import Limit, Motion, StabilityCase, StepReport, StepResult, TimeIntegrator, hookimpl

class Bad(TimeIntegrator):
    summary = "does harm"
    def step(self, solid, law, motion, memory, time_, dt):
        self.harm()
        return StepResult(motion, memory, StepReport())

@attrs.frozen
class Crashing(Bad):
    def harm(self): os._exit(7)

@attrs.frozen
class Hanging(Bad):
    def harm(self): time.sleep(1e3)

@attrs.frozen
class Raising(Bad):
    def harm(self): raise RuntimeError("out of cheese")

@attrs.frozen
class Chatting(Bad):
    def harm(self): print("hello")

class Fragile(StabilityCase):
    summary = "a spring at rest"
    scene = """
[scene]
effects = ["inertia"]
duration = 0.003
step = 1e-3
[solid]
plugin = "spring"
"""
    limits = (Limit("halvings", 0),)
    vary = ("integrator",)
    seconds = 1.0

@hookimpl
def myobridge_time_integrators():
    return {"crashing": Crashing, "hanging": Hanging, "raising": Raising, "chatting": Chatting}

@hookimpl
def myobridge_stability_cases():
    return {"fragile": Fragile}
'''


@pytest.fixture
def fragile(tmp_path: Path) -> Mapping[str, str]:
    """Environment in which a package with a case and bad integrators is installed."""
    site = tmp_path / "site"
    info = site / "bad_pack-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "bad_pack.py").write_text(PACKAGE)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: bad-pack\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[myobridge]\nbad-pack = bad_pack\n")
    paths = [str(site), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "COLUMNS": "200"}


PROGRAM = """
import json, sys
import myobridge as mb
atlas = mb.Atlas(["fragile"], ["default", "crashing", "hanging", "raising", "chatting"])
chart = atlas.run(workers=1, patience=8.0)
print(json.dumps([finding.as_data() for finding in chart.findings]))
"""


def test_a_worker_that_crashes_or_hangs_is_a_cell_that_fails(fragile) -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], env=fragile, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = {cell["method"]: cell for cell in json.loads(done.stdout)}
    assert found["default"]["outcome"] == "holds"
    assert found["chatting"]["outcome"] == "holds", "what a plugin prints does not get between the answers"
    assert (found["crashing"]["outcome"], found["crashing"]["why"]) == ("fails", "the process died: exit code 7")
    assert (found["hanging"]["outcome"], found["hanging"]["why"]) == ("fails", "did not end within 9 s")
    assert found["raising"]["outcome"] == "fails"
    assert "RuntimeError at t = 0 s: out of cheese" in found["raising"]["why"]


def _run(words: list[str], environment: Mapping[str, str], folder: Path) -> subprocess.Popen[str]:
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    program += "from myobridge.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", program, "stability", "--case", "fragile", *words]
    return subprocess.Popen(
        command, env=environment, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def test_ctrl_c_keeps_what_is_done(fragile, tmp_path: Path) -> None:
    process = _run(["--method", "default", "hanging", "--workers", "1"], fragile, tmp_path)
    kept = tmp_path / "atlas" / "cells.jsonl"
    try:
        until = time.monotonic() + 300.0
        while not (kept.exists() and kept.read_text()) and time.monotonic() < until:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
    finally:
        process.kill()
    assert process.returncode == 130, err
    assert "Traceback" not in err
    (line,) = kept.read_text().splitlines()
    assert json.loads(line)["outcome"] == "holds"


# --- command line


def test_the_command_writes_data_picture_page_and_says_when_something_is_wrong(cli, tmp_path: Path) -> None:
    words = ("--case", "staggering:r=5*", "--method", "default", "staggered", "--workers", "0")
    code, out, err = cli("stability", *words, "--docs", "docs/stability.md")
    assert (code, err) == (0, "")
    assert "4 cells: 2 hold, 2 fail" in out
    for name in ("atlas/atlas.json", "atlas/atlas.png", "docs/stability.md", "docs/pictures/stability.png"):
        assert (tmp_path / name).is_file()
    page = (tmp_path / "docs/stability.md").read_text()
    assert "-5 (predicted -5)" in page
    data = json.loads((tmp_path / "atlas/atlas.json").read_text())
    assert len(data["cells"]) == 4


def test_the_exit_code_tells_of_surprises(cli, monkeypatch: pytest.MonkeyPatch) -> None:
    items = registry()._items["stability_case"]
    monkeypatch.setitem(items, "tiny", Registered("tiny", "stability_case", Tiny, "strangers", "1.0"))
    code, out, _ = cli("stability", "--case", "tiny", "--workers", "0", "-q")
    assert code == 1
    assert "tiny, backward_euler: must fail, and holds" in out
    assert cli("stability", "--case", "tiny", "--method", "default", "--workers", "0", "-q").code == 0


def test_cells_are_listed_without_trying_them(cli, tried) -> None:
    code, out, _ = cli("stability", "--list", "--case", "staggering*")
    assert code == 0
    assert "staggering:r=5, 0.001/coupling/staggered" in out
    assert tried == []


def test_a_wrong_pattern_has_code_2(cli) -> None:
    code, _, err = cli("stability", "--case", "stagering")
    assert code == 2
    assert "Did you mean 'staggering'?" in err
