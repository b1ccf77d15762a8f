"""A scene is the same thing as data, as TOML and as a frozen object."""

from __future__ import annotations

import string
from typing import Any

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge.effects import EFFECTS
from myobridge.recording import QUANTITIES

KEYS = st.text(string.ascii_letters + string.digits + "_-", min_size=1, max_size=8) | st.sampled_from(
    ["a key", "dotted.key", 'with "quotes"', "größe", "µ"]
)
TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False),
    TEXTS,
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=8,
)
TABLES = st.builds(lambda plugin, rest: {**rest, "plugin": plugin}, TEXTS, st.dictionaries(KEYS, VALUES, max_size=4))
POSITIVE = st.floats(1e-300, 1e300)
TIMES = st.floats(0.0, 1e6)
RECORDS = st.builds(
    mb.Record,
    every=st.integers(1, 10**6),
    quantities=st.lists(st.sampled_from(sorted(QUANTITIES)), unique=True),
    sites=st.none() | st.lists(st.integers(0, 10**6), min_size=1, max_size=4),
    points=st.none() | st.floats(-1e3, 1e3) | st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=4),
    density_at=TIMES | st.lists(TIMES, max_size=4),
    checkpoint_every=POSITIVE,
)
PARTS = {
    "name": TEXTS,
    "effects": st.lists(st.sampled_from(sorted(EFFECTS)), unique=True),
    "solid": TABLES,
    "loads": st.lists(TABLES, max_size=2),
    "supports": st.lists(st.dictionaries(KEYS, VALUES, max_size=3), max_size=2),
    "regions": st.lists(st.dictionaries(KEYS, VALUES, max_size=3), max_size=2),
    "cross_bridges": st.none() | TABLES,
    "activation": st.none() | TABLES | TEXTS,
    "calcium": st.none() | TABLES,
    "sarcomere_density": st.none() | TABLES,
    "record": RECORDS,
}
TIMED = st.builds(
    mb.Scene,
    duration=POSITIVE,
    step=POSITIVE,
    integrator=st.none() | TABLES,
    coupling=st.none() | TABLES,
    **PARTS,
)
STATIC = st.builds(mb.Scene, continuation=TABLES | TEXTS, **PARTS)
SCENES = TIMED | STATIC


@given(SCENES)
def test_round_trip(scene: mb.Scene) -> None:
    written = scene.to_toml()
    again = mb.Scene.from_toml(written)
    assert again == scene
    assert again.to_toml() == written
    for field in attrs.fields(mb.Scene):
        if field.eq:
            assert getattr(again, field.name) == getattr(scene, field.name), field.name


@given(TIMED, POSITIVE)
def test_a_setting_changes_its_key_and_nothing_else(scene: mb.Scene, duration: float) -> None:
    changed = scene.with_settings({"scene.duration": duration})
    assert changed == attrs.evolve(scene, duration=duration)
    assert changed.with_settings({"scene.duration": scene.duration}) == scene


def test_a_scene_is_frozen_through_and_through() -> None:
    scene = mb.Scene(duration=1.0, step=0.1, solid={"plugin": "clamp", "path": {"plugin": "steps", "times": [0, 1]}})
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        scene.duration = 2.0  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(TypeError):
        scene.solid["plugin"] = "spring"  # pyright: ignore[reportIndexIssue]
    with pytest.raises(TypeError):
        scene.solid["path"]["times"][0] = 3
    with pytest.raises(TypeError):
        scene.solid["path"]["plugin"] = "ramp"


def test_what_was_given_may_change_afterwards() -> None:
    given_: dict[str, Any] = {"plugin": "clamp", "path": {"plugin": "steps", "times": [0, 1]}}
    scene = mb.Scene(duration=1.0, step=0.1, solid=given_)
    before = scene.to_toml()
    given_["path"]["times"].append(2)
    assert scene.to_toml() == before


def test_arrays_and_numpy_numbers_become_plain_data() -> None:
    path = {"plugin": "ramp", "initial": np.array([1.0, 1.1]), "slope": np.float64(0.5)}
    scene = mb.Scene(duration=np.float64(1.0), step=0.1, solid={"plugin": "clamp", "path": path, "sites": np.int64(2)})
    assert mb.Scene.from_toml(scene.to_toml()) == scene
    assert scene.solid["path"]["initial"] == (1.0, 1.1)


def test_none_means_not_given() -> None:
    given_ = mb.Scene(duration=1.0, step=0.1, solid={"plugin": "spring", "load": None})
    assert given_ == mb.Scene(duration=1.0, step=0.1, solid={"plugin": "spring"})
    assert "load" not in given_.to_toml()


def test_a_built_plugin_is_no_data() -> None:
    with pytest.raises(mb.ParameterError, match=r"solid\.path: is .*mb\.Simulation"):
        mb.Scene(duration=1.0, step=0.1, solid={"plugin": "clamp", "path": object()})


def test_another_plugin_within_a_section_drops_what_only_the_old_one_knew() -> None:
    """``--set solid.path.plugin=sine``: the ramp's own keys go, the frequency that follows is the sine's."""
    scene = mb.Scene(
        duration=0.1,
        step=1e-3,
        solid={"plugin": "clamp", "path": {"plugin": "ramp", "initial": 1.0, "final": 0.99, "end": 0.1}, "sites": 2},
    )
    changed = scene.with_settings({"solid.path.plugin": "sine", "solid.path.frequency": 5.0})
    assert changed.to_data()["solid"] == {"plugin": "clamp", "path": {"plugin": "sine", "frequency": 5.0}, "sites": 2}
