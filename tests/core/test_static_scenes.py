"""Scenes without time, and lists that belong to the solid: mistakes, settings, round trip, what explain says."""

from __future__ import annotations

import re
from typing import NamedTuple

import pytest

import myobridge as mb
from myobridge.location import locate

# Line numbers below count from the first line of this text.
SCENE = """\
[scene]
name = "lifting"
effects = ["cross_bridges", "incompressibility"]

[solid]
plugin = "finite_element"
material = { plugin = "mooney_rivlin" }
mesh = { plugin = "block", size = [0.1, 0.025], cells = [4, 1] }

[[support]]
boundary = "left"

[[load]]
plugin = "traction"
boundary = "right"
traction = [1e3, 0.0]

[[load]]      # a second one
plugin = "pressure"
boundary = "top"
pressure = 10.0

[cross_bridges]
plugin = "prescribed"

[continuation]
plugin = "natural"
of = "tension"
to = 1.2
report = [0, 0.4, 1.2]
"""


class Mistake(NamedTuple):
    """Replace `old` by `new` (or set keys); the message stands at `line`, begins with `key`, says `says`."""

    old: str
    new: str
    line: int | None
    key: str
    says: tuple[str, ...]
    settings: tuple[str, ...] = ()


MODEL = 'plugin = "prescribed"'
SPRING = 'plugin = "spring"\n'
BODY = SCENE[SCENE.index('plugin = "finite') : SCENE.index("[[support]]")]
LISTS = SCENE[SCENE.index("[[support]]") : SCENE.index("[cross_bridges]")]
CONTINUATION = SCENE[SCENE.index("[continuation]") :]
STRETCH = 'plugin = "clamp"\npath = { plugin = "constant", level = 1.0 }\n'

MISTAKES = {
    "duration too": Mistake(
        "[solid]", "duration = 1.0\n[solid]", 5, "scene.duration", ("makes a scene without time", "leave out")
    ),
    "step too": Mistake("[solid]", "step = 1.0\n[solid]", 5, "scene.step", ("makes a scene without time",)),
    "neither": Mistake(
        CONTINUATION, "", 1, "scene.duration", ("is missing", "or a [continuation] for a scene without time")
    ),
    "integrator": Mistake(
        "[cross_bridges]", '[integrator]\nplugin = "midpoint"\n[cross_bridges]', 23, "integrator", ("has none",)
    ),
    "coupling": Mistake(
        "[cross_bridges]", '[coupling]\nplugin = "splitting"\n[cross_bridges]', 23, "coupling", ("has none",)
    ),
    "an effect of time": Mistake(
        '["cross_bridges", ', '["cross_bridges", "inertia", ', 3, "scene.effects[1]", ("'inertia' acts in time",)
    ),
    "unknown strategy": Mistake('"natural"', '"naturl"', 27, "continuation.plugin", ("'natural'?", "two_parameter")),
    "no strategy": Mistake('plugin = "natural"\n', "", 26, "continuation.plugin", ("is missing", "arclength")),
    "unknown key": Mistake("to = 1.2", "to = 1.2\nsetp = 1", 30, "continuation.setp", ("'step'?",)),
    "scaled what": Mistake('of = "tension"', 'of = "tensoin"', 28, "continuation.of", ("'tension'?", "load")),
    "scale to 0": Mistake("to = 1.2", "to = 0", 29, "continuation.to", ("is 0", "(0, inf)")),
    "reported beyond the end": Mistake(
        "report = [0, 0.4, 1.2]", "report = [0, 1.3]", 30, "continuation.report[1]", ("is 1.3", "at most to = 1.2")
    ),
    "no tension to scale": Mistake(
        '["cross_bridges", "incompressibility"]\n\n[solid]',
        '["incompressibility"]\n\n[solid]',
        23,
        "cross_bridges",
        ("does not call for the effect",),
    ),
    "no load to scale": Mistake(
        BODY + LISTS, SPRING, None, "continuation.of", ("no load acts on Spring",), ("continuation.of=load",)
    ),
    "a spring has no bulk modulus": Mistake(
        BODY + LISTS,
        SPRING,
        None,
        "continuation.plugin",
        ("Spring has none to lower",),
        ("continuation.plugin=two_parameter",),
    ),
    "a clamp": Mistake(BODY + LISTS, STRETCH, 5, "solid", ("Clamp prescribes the stretch",)),
    "no steady state": Mistake(
        MODEL, 'plugin = "liouville"', 23, "cross_bridges", ("would drag the solid", "prescribed", "a duration")
    ),
    "heads one by one": Mistake(
        MODEL, 'plugin = "discrete"', 23, "cross_bridges", ("Discrete has no isometric steady state",)
    ),
    "rows in time": Mistake("[solid]", "[record]\nevery = 2\n[solid]", 6, "record.every", ("has none",)),
    "densities in time": Mistake("[solid]", "[record]\ndensity_at = 0.1\n[solid]", 6, "record.density_at", ("none",)),
    "quantity of time": Mistake(
        "[solid]", '[record]\nquantities = ["moments"]\n[solid]', 6, "record.quantities", ("needs time", "tension")
    ),
    "unknown field": Mistake(
        "[solid]", '[record]\nfields = ["tensoin"]\n[solid]', 6, "record.fields[0]", ("'tension'?",)
    ),
    "list that a spring has not": Mistake(
        BODY + LISTS,
        SPRING + '[[region]]\nname = "tendon"\n',
        7,
        "region[0]",
        ("the solid 'spring' takes no [[region]]", "finite_element"),
    ),
    "load of a spring": Mistake(
        BODY + LISTS[: LISTS.index("[[load]]")],
        SPRING,
        7,
        "load[0]",
        ("the solid 'spring' takes no [[load]]", "solid.load is a table naming a plugin of family 'signal'"),
    ),
    "list twice": Mistake("material =", "load = []\nmaterial =", 14, "load[0]", ("is given, and so is solid.load",)),
    "table instead of list": Mistake("[[support]]", "[support]", 10, "support", ("a list of tables, [[support]]",)),
    "key of the first": Mistake("traction = [", "tracton = [", 16, "load[0].tracton", ("'traction'?",)),
    "key of the second": Mistake("pressure = 10.0", 'pressure = "x"', 21, "load[1].pressure", ("is 'x'",)),
    "plugin of the second": Mistake('"pressure"', '"presure"', 19, "load[1].plugin", ("'pressure'?",)),
    "key missing in the second": Mistake("pressure = 10.0", "", 18, "load[1].pressure", ("is missing",)),
    "key of a support": Mistake('boundary = "left"', "boundry = 1", 11, "support[0].boundry", ("'boundary'?",)),
    "boundary found by the mesh": Mistake('"top"', '"topp"', 20, "load[1].boundary", ("'topp'", "'top'?")),
    "set: no such entry": Mistake("", "", None, "--set load.2.boundary", ("2 entries",), ("load.2.boundary=1",)),
    "set: without index": Mistake("", "", None, "--set load.boundary", ("no table",), ("load.boundary=1",)),
    "set: key of an entry": Mistake("", "", None, "--set load[1].boundry", ("'boundary'?",), ("load.1.boundry=x",)),
    "set: another entry": Mistake(
        '"top"', '"topp"', 20, "load[1].boundary", ("'top'?",), ("load.0.traction=[1, 2]", "load[1].pressure=2")
    ),
}


@pytest.mark.parametrize("kind", MISTAKES)
def test_mistake(kind: str, cli, write) -> None:
    mistake = MISTAKES[kind]
    assert mistake.old in SCENE
    text = SCENE.replace(mistake.old, mistake.new, 1) if mistake.old else SCENE
    if "finite_element" not in text:
        text = text.replace(', "incompressibility"', "", 1)
    path = write(text)
    settings = [word for item in mistake.settings for word in ("--set", item)]
    code, out, err = cli("explain", path, *settings)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1, "one message, one line"
    if mistake.line is None:
        assert mistake.key in err
    else:
        assert err.startswith(f"myobridge: {path}:{mistake.line}: {mistake.key}"), err
    for words in mistake.says:
        assert words in err, err


def test_the_scene_without_mistakes_is_explained(cli, write) -> None:
    code, out, err = cli("explain", write(SCENE))
    assert (code, err) == (0, "")
    assert re.search(r"continuation +│ plugin +│ natural", out)
    assert re.search(r"│ to +│ 1\.2 ", out)
    assert re.search(r"time +│ none: a path of equilibria", out)
    assert re.search(r"scale +│ tension, from 0 to 1\.2, by the strategy 'natural'", out)
    assert re.search(r"states +│ kept at the scales 0, 0\.4, 1\.2", out)
    assert re.search(r"population +│ none: without time", out)
    assert "duration" not in out


def test_a_list_holds_tables() -> None:
    solid = {"plugin": "finite_element"}
    with pytest.raises(mb.ParameterError, match=r"load\[1\]: is 3; expected a table"):
        mb.Scene(solid=solid, continuation="natural", loads=[{"plugin": "traction"}, 3])  # pyright: ignore
    with pytest.raises(mb.ParameterError, match=r"region: is 'tendon'; expected a list of tables, \[\[region\]\]"):
        mb.Scene(solid=solid, continuation="natural", regions="tendon")  # pyright: ignore


def test_python_gets_the_same_messages() -> None:
    with pytest.raises(mb.ParameterError, match=r"duration: is missing.*continuation"):
        mb.Scene(solid={"plugin": "spring"})
    with pytest.raises(mb.ParameterError, match="step: is given"):
        mb.Scene(solid={"plugin": "spring"}, step=1.0, continuation="natural")  # pyright: ignore
    with pytest.raises(mb.SceneError, match="without time does not step"):
        mb.Plan.of(mb.Scene.from_toml(SCENE)).simulation()


def test_round_trip_and_settings_of_entries() -> None:
    scene = mb.Scene.from_toml(SCENE)
    assert mb.Scene.from_toml(scene.to_toml()) == scene
    assert scene.static
    assert scene.supports == ({"boundary": "left"},)
    before = scene.to_data()
    for key in ("load.1.pressure", "load[1].pressure"):
        changed = scene.with_settings({key: 20.0, "support.0.components": "x"}).to_data()
        assert changed["load"] == [before["load"][0], {"plugin": "pressure", "boundary": "top", "pressure": 20.0}]
        assert changed["support"] == [{"boundary": "left", "components": "x"}]
    other = scene.with_settings({"load.1.plugin": "traction", "load.1.traction": [0.0, 1.0]}).to_data()
    assert other["load"][1] == {"plugin": "traction", "boundary": "top", "traction": [0.0, 1.0]}


def test_another_strategy_drops_what_only_the_old_one_knew_and_keeps_what_is_the_scenes() -> None:
    arclength = SCENE.replace('"natural"', '"arclength"').replace("to = 1.2", "to = 1.2\nturn = 3.0\nstep = 0.2")
    changed = mb.Scene.from_toml(arclength).with_settings({"continuation.plugin": "natural"}).to_data()
    said = {"plugin": "natural", "of": "tension", "to": 1.2, "report": [0, 0.4, 1.2], "step": 0.2}
    assert changed["continuation"] == said


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("load", 2),
        ("load[0]", 2),
        ("load[0].scale.level", 7),
        ("load[0].nothing", 2),
        ("load[1]", 8),
        ("load[1].boundary", 9),
        ("load[1].scale.level", 10),
        ("support[0].boundary", 12),
        ("solid.load[1].a", 16),
        ("solid.load[0].a", 14),
        ("region[0]", 0),
    ],
)
def test_entries_of_lists_are_located(key: str, line: int) -> None:
    written = """\
load_factor = 3
[[load]]
boundary = "left"
traction = [
  [1], [2]]
[load.scale]
level = 1
[[load]]
boundary = "right"
scale.level = 1
[[support]]
boundary = "left"
[[solid.load]]
a = 1
[[solid.load]]
a = 2
"""
    assert locate("file", written, key) == (f"file:{line}: " if line else "file: ")
