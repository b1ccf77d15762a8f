"""Price list of effects: scenes with one effect less or more, what they cost and change."""

from __future__ import annotations

import math

import pytest

import myobridge as mb
from myobridge.study.effects import price_effects
from myobridge.study.without import added, missing, removed

MUSCLE = """
[scene]
name = "muscle"
effects = ["inertia", "cross_bridges", "activation", "calcium", "viscosity", "length_dependence"]
duration = 0.02
step = 1e-3
[solid]
plugin = "spring"
mass = 0.1
stiffness = 500.0
viscosity = 20.0
[cross_bridges]
plugin = "huxley"
bins = 8
overlap = { plugin = "gaussian" }
[activation]
plugin = "constant"
level = 0.5
[calcium]
plugin = "first_order"
[integrator]
plugin = "midpoint"
[coupling]
plugin = "corrected"
"""


def muscle() -> mb.Scene:
    """Scene with many effects."""
    return mb.Scene.from_toml(MUSCLE)


@pytest.mark.parametrize(
    "effect", ["inertia", "cross_bridges", "activation", "calcium", "viscosity", "length_dependence"]
)
def test_an_effect_goes_with_all_that_belongs_to_it(effect: str) -> None:
    scene = removed(muscle(), effect)
    assert effect not in scene.effects
    plan = mb.Plan.of(scene)
    plan.simulation()
    assert [state for name, state, _ in plan.effects() if name == effect] != ["on"]
    rest = set(muscle().effects) - {effect}
    assert set(scene.effects) == (rest - {"activation", "calcium"} if effect == "cross_bridges" else rest) - (
        {"length_dependence"} if effect == "cross_bridges" else set()
    )


def test_an_effect_comes_with_its_defaults() -> None:
    plain = removed(removed(muscle(), "viscosity"), "length_dependence")
    assert "viscosity" in missing(plain)
    for effect in ("viscosity", "length_dependence", "sarcomere_density"):
        scene, by = added(plain, effect)
        assert effect in scene.effects
        assert by
    with pytest.raises(mb.MyobridgeError, match="'gravity' is supplied by none"):
        added(plain, "gravity")


def test_prices_are_differences_of_runs() -> None:
    found = {price.effect: price for price in price_effects(muscle(), repeats=1, workers=0).prices}
    assert found["viscosity"].state == "on"
    assert found["viscosity"].change > 1e-4, "it damps"
    assert found["cross_bridges"].work["bin_steps"] > 0
    assert found["cross_bridges"].change >= 1.0, "all of the tension"
    assert found["calcium"].change > 0.1
    assert found["gravity"].state == "off"
    assert math.isnan(found["gravity"].seconds)
    assert "supplied by macro_solid 'chain'" in found["gravity"].said
    assert found["sarcomere_density"].state == "off"
    assert found["sarcomere_density"].change > 0.0


def test_the_command_prints_one_table(cli, write) -> None:
    outcome = cli("cost", "--effects", write(MUSCLE), "--workers", "0", "--repeats", "1")
    assert outcome.code == 0, outcome.err
    assert "price list of 'muscle'" in outcome.out
    assert "gravity: not with the plugins of this scene" in outcome.out
    study = write('[study]\nscene = "scene.toml"\n[vary]\n"scene.step" = [1e-3]\n', "study.toml")
    assert "is a study; --effects asks for a scene" in cli("cost", "--effects", study).err
