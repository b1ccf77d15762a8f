"""An effect that a scene does not call for allocates nothing and calls nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

import myobridge as mb
from myobridge.effects import EFFECTS
from myobridge.plan import Plan


@pytest.fixture
def count(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Counter[str]]:
    """Count the calls of every method and property, and of the constructor, of registered classes."""

    def watch(*plugins: tuple[str, str]) -> Counter[str]:
        calls: Counter[str] = Counter()
        for family, name in plugins:
            cls = mb.registry().find(family, name).cls
            for owner in cls.__mro__:
                if not owner.__module__.startswith("myobridge"):
                    continue
                for attribute, real in list(vars(owner).items()):
                    if attribute == "__getattr__":
                        _count_cached(monkeypatch, owner, real, calls)
                    elif attribute == "__init__" or not attribute.startswith("_"):
                        _wrap(monkeypatch, owner, attribute, real, calls)
        return calls

    return watch


def _wrap(monkeypatch: pytest.MonkeyPatch, owner: type, attribute: str, real: object, calls: Counter[str]) -> None:
    if isinstance(real, property) and real.fget is not None:
        getter = real.fget

        def fetched(self: object) -> object:
            calls[attribute] += 1
            return getter(self)

        monkeypatch.setattr(owner, attribute, property(fetched))
    elif callable(real) and not isinstance(real, type):
        function = real

        def called(self: object, *arguments: object, **keywords: object) -> object:
            calls[attribute] += 1
            return function(self, *arguments, **keywords)

        monkeypatch.setattr(owner, attribute, called)


def _count_cached(
    monkeypatch: pytest.MonkeyPatch, owner: type, real: Callable[[object, str], object], calls: Counter[str]
) -> None:
    """A class with slots computes its cached properties where it looks for what is not there yet."""

    def looked_for(self: object, name: str) -> object:
        calls[name] += 1
        return real(self, name)

    monkeypatch.setattr(owner, "__getattr__", looked_for)


def every(family: str) -> list[tuple[str, str]]:
    """All plugins of a family."""
    return [(family, name) for name in mb.registry().names(family)]


def bus(simulation: mb.Simulation) -> mb.CouplingBus:
    """The bus, which must be there."""
    assert simulation.bus is not None
    return simulation.bus


def arrays_of(simulation: mb.Simulation) -> dict[str, np.ndarray]:
    """Every array that a simulation and its bus hold."""
    found: dict[str, np.ndarray] = {}
    for owner in (simulation, simulation.bus):
        for name, value in vars(owner).items() if owner is not None else ():
            if isinstance(value, np.ndarray) and value.size:
                found[f"{type(owner).__name__}.{name}"] = value
    return found


def test_without_cross_bridges_there_is_no_bus_no_model_and_no_coupling(count, scenes) -> None:
    calls = count(*every("cross_bridge"), *every("overlap"), *every("signal"), *every("calcium"))
    schemes = count(*every("coupling"))
    plan = Plan.of(mb.Scene.from_toml(scenes["passive"]))
    assert set(plan.parts) == {"solid", "integrator"}
    simulation = plan.simulation().run(0.02)
    assert simulation.steps == 20
    assert simulation.bus is None
    assert calls == {}
    assert schemes["step"] == 0
    assert arrays_of(simulation) == {}
    assert np.ptp(mb.run(plan.scene)["stretch"]) > 1e-3


def test_with_cross_bridges_the_counters_do_count(count, scenes) -> None:
    calls = count(*every("cross_bridge"), *every("coupling"))
    mb.run(mb.Scene.from_toml(scenes["spring"]))
    assert calls["react"] == 40
    assert calls["slide"] == 20
    assert calls["step"] == 20
    assert calls["advance"] == 0, "splitting never asks for the whole path"


def test_without_activation_no_signal_is_asked(count, scenes) -> None:
    signals = count(*every("signal"))
    scene = mb.Scene.from_toml(scenes["spring"])
    simulation = Plan.of(scene).simulation()
    first = bus(simulation).activation
    simulation.run(0.02)
    assert signals == {}
    assert bus(simulation).activation is first, "the same array from start to end: none is made for a step"
    assert np.all(first == 1.0)


def test_with_activation_each_sub_interval_asks_once(count, scenes) -> None:
    scene = mb.Scene.from_toml(scenes["chain"]).with_settings({"coupling.plugin": "splitting"})
    simulation = Plan.of(scene).simulation()
    signals = count(("signal", "ramp"))
    simulation.run(0.02)
    assert signals["mean"] == 2 * simulation.steps == 40
    assert signals["rate"] == 0


def test_without_calcium_no_kinetics_and_no_state_for_it(count, scenes) -> None:
    calls = count(*every("calcium"))
    without = Plan.of(mb.Scene.from_toml(scenes["chain"])).simulation().run(0.02)
    assert calls == {}
    assert bus(without).state().activation.size == 0
    text = scenes["chain"].replace('"activation"]', '"activation", "calcium"]') + '[calcium]\nplugin = "first_order"\n'
    with_it = Plan.of(mb.Scene.from_toml(text)).simulation().run(0.02)
    assert calls["advance"] > 0
    assert bus(with_it).state().activation.size == 4
    assert set(arrays_of(with_it)) - set(arrays_of(without)) == {
        "CouplingBus._activation_state",
        "CouplingBus._trial_activation",
    }


@pytest.mark.parametrize("solid", ["spring", "chain", "rope"])
def test_without_inertia_the_mass_matrix_is_never_asked_for(solid: str, count) -> None:
    scene = mb.Scene(
        duration=0.005,
        step=1e-3,
        effects=["cross_bridges"],
        solid={"plugin": solid, "length": 0.1} | ({"stiffness": 1e3} if solid == "spring" else {"modulus": 1e6}),
        cross_bridges={"plugin": "distributed_moment"},
    )
    calls = count(("macro_solid", solid))
    assert mb.run(scene).checkpoint.scalars["steps"] == 5
    assert calls["balance"] > 0
    assert calls["mass_matrix"] == 0
    assert calls["added_mass"] == 0
    mb.run(attrs_with(scene, effects=["cross_bridges", "inertia"]))
    assert calls["mass_matrix"] > 0


def attrs_with(scene: mb.Scene, effects: list[str]) -> mb.Scene:
    """The scene with other effects."""
    return scene.with_settings({"scene.effects": effects})


def test_without_sarcomere_density_none_is_built_and_the_scale_is_that_of_the_model(count, scenes) -> None:
    calls = count(*every("sarcomere_density"))
    simulation = Plan.of(mb.Scene.from_toml(scenes["chain"])).simulation().run(0.02)
    assert calls == {}
    assert bus(simulation).scale.tolist() == 4 * [bus(simulation).model.p_max]
    text = scenes["chain"].replace('"activation"]', '"activation", "sarcomere_density"]')
    text += '[sarcomere_density]\nplugin = "table"\nvalues = [0, 0.5, 1, 2]\n'
    local = Plan.of(mb.Scene.from_toml(text)).simulation().run(0.02)
    assert calls["at"] == 1, "once at the start, not once a step"
    assert bus(local).scale.tolist() == [factor * bus(local).model.p_max for factor in (0.0, 0.5, 1.0, 2.0)]


OVERLAPPING = [item.name for item in mb.registry() if "length_dependence" in item.optional_effects]


def test_some_models_know_length_dependence() -> None:
    assert {"hill", "distributed_moment", "huxley"} <= set(OVERLAPPING)


@pytest.mark.parametrize("model", OVERLAPPING)
def test_without_length_dependence_no_overlap_is_built_or_called(model: str, count, scenes) -> None:
    calls = count(*every("overlap"))
    scene = mb.Scene.from_toml(scenes["clamp"]).with_settings({"cross_bridges.plugin": model})
    mb.run(scene)
    assert calls == {}
    mb.run(attrs_with(scene, effects=["cross_bridges", "length_dependence"]))
    assert calls["fraction"] > 0


def test_without_gravity_there_is_no_weight(scenes) -> None:
    text = scenes["chain"].replace("length = 0.1", "length = 0.1\nmass = 0.05")
    without = mb.run(mb.Scene.from_toml(text))
    massless = mb.run(mb.Scene.from_toml(scenes["chain"]))
    np.testing.assert_array_equal(without["stretch"], massless["stretch"])
    heavy = mb.run(mb.Scene.from_toml(text.replace('"activation"]', '"activation", "gravity"]')))
    assert np.abs(heavy["stretch"] - without["stretch"]).max() > 1e-3


def test_without_cross_bridge_mass_heads_add_no_inertia(count, scenes) -> None:
    calls = count(("macro_solid", "spring"))
    scene = mb.Scene.from_toml(scenes["spring"]).with_settings({"cross_bridges.plugin": "discrete"})
    light = mb.run(scene)
    assert calls["added_mass"] == 0
    heavy = mb.run(attrs_with(scene, effects=["cross_bridges", "inertia", "cross_bridge_mass"]))
    assert calls["added_mass"] > 0
    assert np.any(heavy["stretch"] != light["stretch"])


@pytest.mark.parametrize("section", ["activation", "calcium", "sarcomere_density", "cross_bridges", "coupling"])
def test_a_part_that_is_not_called_for_is_not_in_the_plan(section: str, scenes) -> None:
    assert section not in Plan.of(mb.Scene.from_toml(scenes["passive"])).parts


def test_the_plan_says_of_every_effect_whether_and_why(scenes) -> None:
    rows = {effect: (state, why) for effect, state, why in Plan.of(mb.Scene.from_toml(scenes["rope"])).effects()}
    assert list(rows) == list(EFFECTS)
    assert rows["inertia"] == ("on", "integrator 'energy_momentum'")
    assert rows["cross_bridges"] == ("on", "cross_bridges 'hill'")
    # The model could take an activation, but there is none: it is fully active.
    for effect in ("activation", "gravity", "force_velocity", "calcium", "length_dependence", "incompressibility"):
        assert rows[effect] == ("off", f"not called for: {EFFECTS[effect]}")


def test_the_plan_lists_effects_that_a_stranger_adds(scenes, monkeypatch: pytest.MonkeyPatch) -> None:
    hill = mb.registry().find("cross_bridge", "hill").cls
    monkeypatch.setattr(hill, "inherent_effects", hill.inherent_effects | {"fatigue"})
    scene = mb.Scene.from_toml(scenes["rope"])
    assert ("fatigue", "inherent", "always there in cross_bridges 'hill'") in Plan.of(scene).effects()
    called = scene.with_settings({"scene.effects": [*scene.effects, "fatigue"]})
    assert ("fatigue", "on", "cross_bridges 'hill'") in Plan.of(called).effects()


@pytest.mark.parametrize("model", mb.registry().names("cross_bridge"))
@pytest.mark.parametrize("name", ["clamp", "spring", "chain", "rope"])
def test_another_model_by_one_line_runs(name: str, model: str, scenes) -> None:
    scene = mb.Scene.from_toml(scenes[name])
    result = mb.run(scene, settings={"cross_bridges.plugin": model, "scene.duration": 2e-3})
    assert np.all(np.isfinite(result["tension"]))
    assert result.checkpoint.scalars["steps"] == 2


def test_heads_with_mass_need_inertia_or_a_clamp() -> None:
    from myobridge_plugins.cross_bridge.discrete import Discrete
    from myobridge_plugins.macro_solid.spring import Spring
    from myobridge_plugins.time_integrator.midpoint import Midpoint
    from myobridge_plugins.time_integrator.quasi_static import QuasiStatic

    heads = Discrete(head_mass=1e-9)
    with pytest.raises(mb.SceneError, match="heads with mass need inertia"):
        mb.Simulation(solid=Spring(), cross_bridges=heads, integrator=QuasiStatic())
    moving = mb.Simulation(solid=Spring(velocity=0.1), cross_bridges=heads, integrator=Midpoint())
    moving.step()
    assert moving.ledger.kinetic != 0.0
