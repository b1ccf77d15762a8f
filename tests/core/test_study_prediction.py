"""What `myobridge explain` expects of a run: unit costs of the machine, kept, and scaled to the scene."""

from __future__ import annotations

import json
import math

import attrs
import pytest

import myobridge as mb
from myobridge.study.prediction import predicted
from myobridge.study.unit_costs import UnitCosts, cache_file, keep, kept, measured_costs, shares, size_of_plan


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path


COSTS = UnitCosts(unknowns=1, values=1000, mechanics=2e-4, micro=1e-4, rest=1e-5, setup=0.5, steps=10)


def plan(scenes, **settings) -> mb.Plan:
    """Plan of the small spring."""
    said = {key.replace("__", "."): value for key, value in settings.items()}
    return mb.Plan.of(mb.Scene.from_toml(scenes["spring"]).with_settings(said))


def test_costs_are_kept_by_kind(scenes, own_cache) -> None:
    assert kept(plan(scenes)) is None
    assert predicted(plan(scenes), measure=False) is None
    keep(plan(scenes), COSTS)
    assert cache_file().is_relative_to(own_cache)
    assert kept(plan(scenes)) == COSTS
    assert kept(plan(scenes, solid__mass=0.2)) == COSTS, "another number is the same code"
    assert kept(plan(scenes, cross_bridges__plugin="huxley")) is None
    cache_file().write_text("no JSON", encoding="utf-8")
    assert kept(plan(scenes)) is None


def test_a_prediction_is_the_sum_of_its_steps(scenes) -> None:
    keep(plan(scenes), attrs.evolve(COSTS, values=size_of_plan(plan(scenes))[1]))
    expected = predicted(plan(scenes))
    assert expected is not None
    assert expected.steps == 20
    assert expected.a_step == pytest.approx(3.1e-4)
    assert expected.seconds == pytest.approx(0.5 + 20 * 3.1e-4)
    half = predicted(plan(scenes, scene__step=5e-4))
    assert half is not None
    assert half.seconds - 0.5 == pytest.approx(2 * (expected.seconds - 0.5))


def test_more_values_cost_more(scenes) -> None:
    fine = mb.Scene.from_toml(scenes["spring"]).with_settings({"cross_bridges.plugin": "huxley"})
    coarse = fine.with_settings({"cross_bridges.bins": 8})
    keep(mb.Plan.of(coarse), attrs.evolve(COSTS, values=size_of_plan(mb.Plan.of(coarse))[1]))
    small, large = (
        predicted(mb.Plan.of(coarse)),
        predicted(mb.Plan.of(fine.with_settings({"cross_bridges.bins": 4096}))),
    )
    assert small is not None
    assert large is not None
    assert large.a_step > 1.5 * small.a_step


def test_the_load_of_the_machine_is_taken_out() -> None:
    found = shares({"mechanics": 0.3, "cross_bridges": 0.1}, wall=10.0, cpu=5.0, steps=20)
    assert found == pytest.approx({"mechanics": 0.15, "micro": 0.05, "rest": 0.05})
    alone = shares({"mechanics": 0.3, "cross_bridges": 0.1}, wall=10.0, cpu=19.0, steps=20)
    assert sum(alone.values()) == pytest.approx(0.5)


@pytest.mark.parametrize("name", ["clamp", "spring", "rope"])
def test_costs_are_measured(name: str, scenes) -> None:
    one = mb.Plan.of(mb.Scene.from_toml(scenes[name]))
    costs = measured_costs(one)
    assert (costs.unknowns, costs.values) == size_of_plan(one)
    assert costs.steps == 18
    assert 1e-6 < costs.mechanics + costs.micro + costs.rest < 1.0
    json.dumps(attrs.asdict(costs))


def test_explain_and_run_say_it(cli, write, scenes) -> None:
    path = write(scenes["spring"])
    assert "expected a step" not in cli("run", path).out, "nothing is measured to delay a run"
    explained = cli("explain", path).out
    assert "expected" in explained
    assert "s a step; about" in explained
    ran = cli("run", path).out
    assert "expected a step" in ran
    assert math.isfinite(float(ran.split("expected a step")[1].split()[1]))
