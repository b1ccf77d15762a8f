"""Every mistake in a scene: one clear message with file, line and key, what is allowed, the nearest match."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import pytest

import myobridge as mb

# Line numbers below count from the first line of this text.
SCENE = """\
# A scene with comments, a dotted key, an inline table and a sub-table.
[scene]
name = "sample"   # [not a table]
effects = ["cross_bridges", "activation", "length_dependence"]
duration = 0.01
step = 1e-3

[solid]           # the solid
plugin = "clamp"
sites = 3
path = { plugin = "ramp", initial = 1.0, final = 0.99, end = 0.01 }

[cross_bridges]
plugin = "hill"

[activation]
plugin = "constant"
level = 0.5
"""


class Mistake(NamedTuple):
    """Replace `old` by `new` in the scene (or set keys); the message stands at `line`, names `key`, says `says`."""

    old: str
    new: str
    line: int | None
    key: str
    says: tuple[str, ...]
    settings: tuple[str, ...] = ()


SPRING = 'plugin = "clamp"\nsites = 3\npath = { plugin = "ramp", initial = 1.0, final = 0.99, end = 0.01 }'
PATH = 'path = { plugin = "ramp", initial = 1.0, final = 0.99, end = 0.01 }'

MISTAKES = {
    "invalid TOML": Mistake("step = 1e-3", "step = ", None, "", ("is not valid TOML", "at line 6")),
    "key twice": Mistake("step = 1e-3", "duration = 1", None, "", ("is not valid TOML", "at line 6")),
    "unknown section": Mistake(
        "[cross_bridges]", "[cross_bridge]", 13, "cross_bridge", ("Did you mean 'cross_bridges'?",)
    ),
    "unknown scene key": Mistake(
        "duration", "duratoin", 5, "scene.duratoin", ("Allowed: duration, effects", "'duration'?")
    ),
    "no solid": Mistake(f"[solid]           # the solid\n{SPRING}", "", None, "solid", ("is missing", "[solid]")),
    "no duration": Mistake("duration = 0.01", "", 2, "scene.duration", ("is missing", "(0, inf) [s]")),
    "no step": Mistake("step = 1e-3", "", 2, "scene.step", ("is missing", "(0, inf) [s]")),
    "negative step": Mistake("step = 1e-3", "step = -1e-3", 6, "scene.step", ("is -0.001", "(0, inf) [s]")),
    "step is text": Mistake("step = 1e-3", 'step = "1 ms"', 6, "scene.step", ("is '1 ms'", "expected a number")),
    "step is a date": Mistake("step = 1e-3", "step = 2020-01-01", 6, "scene.step", ("expected a number",)),
    "duration not finite": Mistake("duration = 0.01", "duration = inf", 5, "scene.duration", ("is inf",)),
    "duration beyond all floats": Mistake(
        "duration = 0.01", "duration = 1" + 400 * "0", 5, "scene.duration", ("a number",)
    ),
    "name is a number": Mistake('name = "sample"', "name = 3", 3, "scene.name", ("is 3", "string")),
    "section is no table": Mistake(
        '[cross_bridges]\nplugin = "hill"', "[[cross_bridges]]", 13, "cross_bridges", ("expected a table",)
    ),
    "effects is no list": Mistake(
        '["cross_bridges", "activation", "length_dependence"]', "3", 4, "scene.effects", ("a list of names", "Allowed:")
    ),
    "effects is text": Mistake(
        '["cross_bridges", "activation", "length_dependence"]', '"inertia"', 4, "scene.effects", ("a list of names",)
    ),
    "effect is a number": Mistake('"activation"', "7", 4, "scene.effects", ("a list of names",)),
    "unknown effect": Mistake(
        '"activation"', '"activaton"', 4, "scene.effects[1]", ("no effect 'activaton'", "'activation'?")
    ),
    "effect twice": Mistake(
        '"activation", ', '"activation", "activation", ', 4, "scene.effects[2]", ("'activation' a second time",)
    ),
    "effect without supplier": Mistake(
        '"activation"',
        '"activation", "viscosity"',
        4,
        "scene.effects[2]",
        ("'viscosity' is supplied by none", "solid 'Clamp'"),
    ),
    "effect another plugin has": Mistake(
        '"activation"', '"activation", "gravity"', 4, "scene.effects[2]", ("Supplied by:", "macro_solid 'chain'")
    ),
    "cross-bridges not called for": Mistake(
        '"cross_bridges", "activation", "length_dependence"',
        '"activation"',
        13,
        "cross_bridges",
        ("does not call for the effect 'cross_bridges'",),
    ),
    "table of an absent effect": Mistake(
        ', "activation"', "", 16, "activation", ("does not call for the effect 'activation'", "scene.effects")
    ),
    "effect without its table": Mistake(
        '"length_dependence"', '"calcium"', None, "calcium", ("is missing", "[calcium]")
    ),
    "unknown plugin": Mistake(
        'plugin = "hill"',
        'plugin = "hil"',
        14,
        "cross_bridges.plugin",
        ("unknown cross-bridge model 'hil'", "liouville", "'hill'?"),
    ),
    "plugin of another family": Mistake(
        'plugin = "hill"', 'plugin = "spring"', 14, "cross_bridges.plugin", ("unknown cross-bridge model",)
    ),
    "plugin is a number": Mistake(
        'plugin = "hill"', "plugin = 3", 14, "cross_bridges.plugin", ("unknown cross-bridge model '3'",)
    ),
    "no plugin": Mistake('plugin = "hill"', "", 13, "cross_bridges.plugin", ("is missing", "hill")),
    "unknown nested plugin": Mistake(
        '"ramp"', '"rampe"', 11, "solid.path.plugin", ("unknown function of time 'rampe'", "'ramp'?")
    ),
    "unknown parameter": Mistake("sites = 3", "site = 3", 10, "solid.site", ("unknown to 'clamp'", "'sites'?")),
    "unknown nested parameter": Mistake(
        "initial", "inital", 11, "solid.path.inital", ("unknown to 'ramp'", "'initial'?")
    ),
    "nested sub-table": Mistake(
        PATH,
        '[solid.path]\nplugin = "ramp"\ninitial = 1.0\nfinal = "x"\nend = 1.0',
        14,
        "solid.path.final",
        ("is 'x'",),
    ),
    "nested dotted key": Mistake(
        PATH, 'path.plugin = "ramp"\npath.initial = 1.0\npath.final = true', 13, "solid.path.final", ("is True",)
    ),
    "required parameter missing": Mistake(PATH, "", 8, "solid.path", ("is missing", "family 'signal'")),
    "part is a number": Mistake(PATH, "path = 1.0", 11, "solid.path", ("is 1.0", "family 'signal'")),
    "part is a list": Mistake(PATH, "path = [1.0]", 11, "solid.path", ("family 'signal'",)),
    "wrong type": Mistake("sites = 3", "sites = 3.5", 10, "solid.sites", ("is 3.5", "a whole number in [1, inf)")),
    "out of range": Mistake("sites = 3", "sites = 0", 10, "solid.sites", ("is 0", "[1, inf)")),
    "parameters contradict": Mistake(
        "final = 0.99, ", "final = 0.99, slope = 1.0, ", 11, "solid.path.final", ("both are given",)
    ),
    "list of wrong length": Mistake("final = 0.99", "final = [0.99, 0.98]", 11, "solid.path", ("2 values", "3 sites")),
    "a step longer than the run": Mistake("step = 1e-3", "step = 1.0", 6, "scene.step", ("longer than the duration",)),
    "lists of different lengths": Mistake(
        "initial = 1.0, final = 0.99", "initial = [1, 1], final = [1, 1, 1]", 11, "solid.path.final", ("3 values", "2")
    ),
    "activation of wrong length": Mistake(
        "level = 0.5", "level = [0.5, 0.5]", 16, "activation", ("2 values", "expected 1 or 3")
    ),
    "activation starts out of range": Mistake(
        "level = 0.5", "level = 1.5", 16, "activation", ("is 1.5 at t = 0 s", "[0, 1]")
    ),
    "activation leaves the range later": Mistake(
        'plugin = "constant"\nlevel = 0.5',
        'plugin = "steps"\ntimes = [0, 0.005]\nvalues = [0, -0.5]\ninterpolation = "hold"',
        16,
        "activation",
        ("is -0.5 at t = 0.005 s",),
    ),
    "stretch starts negative": Mistake("initial = 1.0", "initial = -1.0", 11, "solid.path", ("not positive",)),
    "stretch becomes negative": Mistake(
        "final = 0.99", "final = -0.5", 8, "solid", ("is -0.0005 at t = 0.00667 s", "(0, inf)")
    ),
    "parameter of an absent effect": Mistake(
        SPRING, 'plugin = "chain"\ngravity = -9.81', 10, "solid.gravity", ("belongs to the effect 'gravity'",)
    ),
    "inertia without mass": Mistake(
        '"activation"', '"activation", "inertia"', 4, "scene.effects", ("'inertia' has no supplier", "Clamp")
    ),
    "integrator with uncalled inertia": Mistake(
        "[cross_bridges]",
        '[integrator]\nplugin = "midpoint"\n[cross_bridges]',
        14,
        "integrator.plugin",
        ("does not call for it", "'inertia'"),
    ),
    "unknown record key": Mistake("[solid]", "[record]\nevrey = 2\n[solid]", 9, "record.evrey", ("'every'?",)),
    "record out of range": Mistake("[solid]", "[record]\nevery = 0\n[solid]", 9, "record.every", ("[1, inf)",)),
    "unknown quantity": Mistake(
        "[solid]", '[record]\nquantities = ["tensoin"]\n[solid]', 9, "record.quantities", ("'tensoin'", "'tension'?")
    ),
    "quantities is a number": Mistake(
        "[solid]", "[record]\nquantities = 3\n[solid]", 9, "record.quantities", ("a list of names",)
    ),
    "no such site": Mistake(
        "[solid]", "[record]\nsites = [1, 3]\n[solid]", 9, "record.sites", ("site 3", "sites 0 to 2")
    ),
    "sites is a number": Mistake(
        "[solid]", "[record]\nsites = 1\n[solid]", 9, "record.sites", ("a list of site numbers",)
    ),
    "density before the start": Mistake(
        "[solid]", "[record]\ndensity_at = -1.0\n[solid]", 9, "record.density_at", ("[0, inf) [s]",)
    ),
    "probe outside": Mistake(
        SPRING, 'plugin = "chain"\n[record]\npoints = [0.5, 1.5]', 11, "record.points", ("1.5 m, outside the solid",)
    ),
    "missing CSV": Mistake(
        PATH, 'path = { plugin = "table", file = "no.csv" }', 11, "solid.path.file", ("no.csv' does not exist",)
    ),
    "broken CSV": Mistake(
        PATH, 'path = { plugin = "table", file = "bad.csv" }', 11, "solid.path.file", ("line 2", "'much'")
    ),
    "density of wrong length": Mistake(
        '"activation"', '"activation", "sarcomere_density"', 21, "sarcomere_density.values", ("2 entries for 3 sites",)
    ),
    "set: no equals sign": Mistake("", "", None, "--set duration", ("expected KEY=VALUE",), ("duration",)),
    "set: no section": Mistake("", "", None, "--set step", ("expected SECTION.KEY=VALUE",), ("step=1",)),
    "set: unknown section": Mistake("", "", None, "--set soldi", ("'solid'?",), ("soldi.sites=1",)),
    "set: unknown key": Mistake("", "", None, "--set solid.site", ("'sites'?",), ("solid.site=1",)),
    "set: out of range": Mistake("", "", None, "--set scene.step", ("is 0;",), ("scene.step=0",)),
    "set: unknown plugin": Mistake(
        "", "", None, "--set cross_bridges.plugin", ("'hill'?",), ("cross_bridges.plugin=hil",)
    ),
    "set: into a value": Mistake("", "", None, "--set solid.sites.count", ("no table",), ("solid.sites.count=1",)),
    "set: one of the effects": Mistake(
        "", "", None, "--set scene.effects[0]", ("no effect 'cross_bridge'",), ('scene.effects=["cross_bridge"]',)
    ),
}
DENSITY = '\n[sarcomere_density]\nplugin = "table"\nvalues = [1, 1]\n'


@pytest.mark.parametrize("verb", ["run", "explain"])
@pytest.mark.parametrize("kind", MISTAKES)
def test_mistake(kind: str, verb: str, cli, write, tmp_path: Path) -> None:
    mistake = MISTAKES[kind]
    assert mistake.old in SCENE
    text = SCENE.replace(mistake.old, mistake.new, 1) if mistake.old else SCENE
    if "sarcomere_density" in text:
        text = text.rstrip() + DENSITY
    (tmp_path / "bad.csv").write_text("0, 1\n0.5, much\n")
    path = write(text)
    settings = [word for item in mistake.settings for word in ("--set", item)]
    code, out, err = cli(verb, path, *settings)
    assert code == 2
    assert out == ""
    assert err.startswith("myobridge: ")
    assert "Traceback" not in err
    assert err.count("\n") == 1, "one message, one line"
    if mistake.settings:
        assert mistake.key in err
    else:
        place = f"{path}:{mistake.line}: " if mistake.line else f"{path}: "
        assert err.startswith(f"myobridge: {place}{mistake.key}"), err
    for words in mistake.says:
        assert words in err, err
    assert not list(tmp_path.glob("*.h5")), "nothing is written for a scene that is wrong"


def test_the_scene_without_mistakes_runs(cli, write) -> None:
    assert cli("run", write(SCENE), "-q").code == 0


@pytest.mark.parametrize(
    ("path", "says"), [("nowhere.toml", "cannot be read"), (".", "cannot be read"), ("binary.toml", "not a text file")]
)
def test_a_scene_that_cannot_be_read(path: str, says: str, cli, tmp_path: Path) -> None:
    (tmp_path / "binary.toml").write_bytes(bytes(range(128, 256)))
    code, _, err = cli("run", tmp_path / path)
    assert code == 2
    assert says in err
    assert str(tmp_path / path) in err


def test_effects_that_act_on_cross_bridges_need_them(cli, write, scenes) -> None:
    coupled = write(scenes["passive"] + '[coupling]\nplugin = "splitting"\n')
    outcome = cli("explain", coupled)
    assert outcome.code == 2
    assert f"{coupled}:12: coupling: is given, but there is nothing to couple" in outcome.err
    active = write(scenes["passive"].replace('["inertia"]', '["activation"]') + '[activation]\nplugin = "constant"\n')
    outcome = cli("explain", active)
    assert outcome.code == 2
    assert "'activation' acts on cross-bridges; add 'cross_bridges'" in outcome.err


def test_python_gets_the_same_message(write) -> None:
    path = write(SCENE.replace("sites = 3", "site = 3"))
    with pytest.raises(mb.SceneError, match=rf"{re.escape(str(path))}:10: solid\.site: .*Did you mean 'sites'\?"):
        mb.run(path)


def test_files_are_looked_for_beside_the_scene(cli, tmp_path: Path) -> None:
    folder = tmp_path / "elsewhere" / "data"
    folder.mkdir(parents=True)
    (folder / "path.csv").write_text("t, stretch\n0, 1\n0.01, 0.98\n")
    table = 'path = { plugin = "table", file = "data/path.csv" }'
    (folder.parent / "scene.toml").write_text(SCENE.replace(PATH, table))
    assert cli("run", folder.parent / "scene.toml", "-q", "-o", "result.h5").code == 0
    assert mb.Result.load(tmp_path / "result.h5")["stretch"][-1] == pytest.approx(0.98, abs=1e-12)


def test_a_plugin_that_breaks_when_it_is_built_is_named(cli, write, monkeypatch) -> None:
    """Whatever a stranger's constructor raises: the plugin and its package, and no traceback."""
    from myobridge_plugins.macro_solid.clamp import Clamp

    def breaks(_self: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(Clamp, "__attrs_post_init__", breaks)
    code, _, said = cli("explain", write(SCENE))
    assert code == 2
    assert "'clamp' of package 'myobridge' cannot be built" in said
    assert "ZeroDivisionError" in said
    assert "Traceback" not in said
