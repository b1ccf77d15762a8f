"""Scenes of the complete model in motion: each is asserted on its physics, on a coarse mesh; long ones are slow."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import myobridge as mb

EXAMPLES = Path(__file__).parents[2] / "examples"
P_MAX = 73e3
# One reach of a head is this much stretch.
REACH = 15.6e-9 / 1.1e-6
WITHOUT_CONTROL = {"scene.tolerance": None, "record.fields_at": []}
# Energy is kept as well as the equations are solved.
EXACT = {
    "integrator.plugin": "energy_momentum",
    "integrator.newton.plugin": "simplified",
    "integrator.newton.tolerance": 1e-12,
}


def run(name: str, settings: Mapping[str, Any]) -> mb.Result:
    return mb.run(EXAMPLES / f"{name}.toml", settings=EXACT | dict(settings))


def end(result: mb.Result, state: int = -1) -> np.ndarray:
    """Mean displacement of the right end [m]."""
    assert result.mesh is not None
    right = result.mesh.points[:, 0] > result.mesh.points[:, 0].max() - 1e-9
    return result.fields[state]["displacement"][right].mean(axis=0)


def cell_volumes(result: mb.Result) -> np.ndarray:
    """Of triangles [m^2] or tetrahedra [m^3] with straight edges."""
    assert result.mesh is not None
    corners = result.mesh.cells[:, :3] if result.mesh.kind.startswith("triangle") else result.mesh.cells[:, :4]
    place = result.mesh.points[corners]
    edges = place[:, 1:] - place[:, :1]
    if edges.shape[1] == 2:
        return 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return np.abs(np.linalg.det(edges)) / 6.0


def assert_volume_is_kept(result: mb.Result) -> None:
    """Of the whole body in every kept state, and that it changed its shape."""
    volumes = cell_volumes(result)
    for state in result.fields:
        change = float(volumes @ (state["J"] - 1.0)) / float(volumes.sum())
        assert abs(change) < 1e-9, f"the volume at {state.time} s changed by {change:.1e}"
    assert max(np.abs(state["J"] - 1.0).max() for state in result.fields) > 1e-4, "of single cells: something moved"


def unbooked(result: mb.Result) -> float:
    """Largest imbalance of a step, relative to the largest energy of the run; the series have that so far."""
    stored = result["energy/kinetic"] + result["energy/elastic"] + result["energy/cross_bridge"]
    imbalance = result["energy/residual"] * np.maximum.accumulate(np.abs(stored))
    return float(np.abs(imbalance).max() / np.abs(stored).max())


def assert_energy_comes_from_somewhere(result: mb.Result) -> None:
    """The ledger closes in every step, and the stores grow by no more than attachment and external work give."""
    assert unbooked(result) < 1e-9
    stored = result["energy/kinetic"] + result["energy/elastic"] + result["energy/cross_bridge"]
    given = result["energy/attached"] + result["energy/external"]
    assert np.all(np.diff(stored) <= np.diff(given) + 1e-9 * stored.max())
    assert np.all(np.diff(result["energy/attached"]) >= 0.0)
    assert np.all(np.diff(result["energy/detached"]) >= 0.0)
    assert np.all(np.diff(result["energy/viscous"]) >= 0.0)


def statics_of(name: str, settings: Mapping[str, Any]) -> mb.Result:
    """Equilibrium of the same body under its full isometric tension, without time."""
    scene = mb.Scene.from_toml((EXAMPLES / f"{name}.toml").read_text()).with_settings(settings)
    return mb.run(
        mb.Scene(
            name=f"{name} without time",
            effects=["cross_bridges", "incompressibility"],
            continuation={"plugin": "natural", "of": "tension", "to": 1.0, "step": 0.25, "report": [1.0]},
            solid=scene.solid,
            supports=scene.supports,
            regions=scene.regions,
            cross_bridges={"plugin": "huxley"},
        )
    )


# ------------------------------------------------------------------ contraction (thesis, Figures 12 and 13)


COARSE = {"solid.mesh.cells": 5, "scene.tolerance": 2e-4}


@pytest.fixture(scope="module")
def contraction() -> mb.Result:
    return run("contraction_2d", COARSE)


def assert_equilibrium(result: mb.Result, static: mb.Result) -> None:
    """It moves no longer, pulls everywhere with the isometric tension, and lies where statics has it."""
    kinetic = result["energy/kinetic"]
    assert kinetic.max() > 1e-6
    assert kinetic[-1] < 1e-3 * kinetic.max()
    tension = result.fields[-1]["tension"]
    muscle = ~np.isnan(tension)
    assert tension[muscle] == pytest.approx(P_MAX, rel=0.015)
    way, sought = end(result)[0], end(static)[0]
    assert sought < -0.01
    assert way == pytest.approx(sought, rel=0.01)


def test_the_contraction_comes_to_its_equilibrium(contraction: mb.Result) -> None:
    assert_equilibrium(contraction, statics_of("contraction_2d", COARSE))
    assert_volume_is_kept(contraction)
    assert_energy_comes_from_somewhere(contraction)


def test_the_loose_end_contracts_first(contraction: mb.Result) -> None:
    """Thesis, Figure 12: the free end contracts most; where it is held, heads slide less and pull with more."""
    early, last = contraction.fields[3], contraction.fields[-1]
    assert early.time == pytest.approx(0.096)
    assert contraction.mesh is not None
    along = contraction.mesh.points[contraction.mesh.cells].mean(axis=1)[:, 0]
    free, held = along > 0.08, along < 0.02
    assert 1.0 - early["stretch"][free].mean() > 1.1 * (1.0 - early["stretch"][held].mean())
    assert early["tension"][held].mean() > 1.1 * early["tension"][free].mean()
    assert last["tension"][held].mean() == pytest.approx(last["tension"][free].mean(), rel=0.005)


def test_the_steps_are_long(contraction: mb.Result) -> None:
    """The thesis took 1e-5 s; here milliseconds, and 16 of them towards the equilibrium."""
    steps = np.diff(contraction["time"])
    assert steps.min() > 0.999e-3
    assert steps[-20:].min() > 0.0159
    assert contraction["step_error"].max() <= 2e-4


@pytest.mark.parametrize("model", ["huxley", "distributed_moment", "hill", "prescribed", "liouville", "discrete"])
def test_every_model_contracts_it_by_one_line(model: str) -> None:
    """The ledger closes with each; those with the same tension end in the same place."""
    short = {"scene.duration": 0.03, "scene.step": 1e-3, "solid.mesh.cells": 4, **WITHOUT_CONTROL}
    result = run("contraction_2d", {"cross_bridges.plugin": model, **short})
    if model in ("hill", "prescribed"):  # their tension derives from no stored energy
        assert unbooked(result) < 1e-9
        assert result["energy/active_work"][-1] > 1e-3
    else:
        assert_energy_comes_from_somewhere(result)
    assert_volume_is_kept(result)
    # Frozen heads give way by less than a reach; all others shorten the muscle by much more.
    shortening = -end(result)[0] / 0.1
    if model in ("liouville", "discrete"):
        assert 1e-4 < shortening < REACH
    else:
        assert shortening > REACH


@pytest.mark.parametrize("scheme", ["corrected", "monolithic"])
def test_other_couplings_come_to_the_same_motion(scheme: str) -> None:
    """They conserve no energy; the displacement they find is that of splitting."""
    short = {"scene.duration": 0.03, "scene.step": 1e-3, "solid.mesh.cells": 4, **WITHOUT_CONTROL}
    default = run("contraction_2d", short)
    other = run("contraction_2d", {"coupling.plugin": scheme, **short})
    assert end(other)[0] == pytest.approx(end(default)[0], rel=0.01)
    assert unbooked(default) < 1e-9
    assert unbooked(other) > 1e-6


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_staggered_coupling_invents_energy(step: float) -> None:
    """Heads twenty times stiffer than tissue, a tension that comes a step late: the smaller step fails as well."""
    short = {"scene.duration": 0.02, "scene.step": step, "solid.mesh.cells": 4, **WITHOUT_CONTROL}
    default = run("contraction_2d", {**short, "scene.step": 1e-3})
    result = run("contraction_2d", {"coupling.plugin": "staggered", **short})
    assert result["energy/kinetic"].max() > 100.0 * default["energy/kinetic"].max()
    assert np.abs(result["energy/drift"]).max() > 0.1


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"integrator.plugin": "half_explicit", "coupling.plugin": "monolithic"}, "needs an implicit integrator"),
        ({"integrator.plugin": "quasi_static"}, "leaves inertia out"),
    ],
)
def test_what_does_not_go_together_is_refused(settings: Mapping[str, Any], says: str) -> None:
    with pytest.raises(mb.MyobridgeError, match=says):
        mb.run(EXAMPLES / "contraction_2d.toml", settings={**COARSE, **settings})


def test_the_muscle_in_space_contracts() -> None:
    """The first 60 ms: tendons without cross-bridges, a belly that becomes thicker, volume and energy kept."""
    result = run("contraction", {"solid.mesh.cells": 3, "scene.duration": 0.06, "record.fields_at": [0.016]})
    assert_volume_is_kept(result)
    assert_energy_comes_from_somewhere(result)
    assert end(result)[0] < -2e-3
    tension = result.fields[-1]["tension"]
    assert 0.05 < np.isnan(tension).mean() < 0.6
    assert result.mesh is not None
    belly = np.abs(result.mesh.points[:, 0] - 0.05) < 0.02
    rim = belly & (np.linalg.norm(result.mesh.points[:, 1:], axis=1) > 0.008)
    place, moved = result.mesh.points[rim, 1:], result.fields[-1]["displacement"][rim, 1:]
    assert np.sum(place * moved, axis=1).min() > 0.0, "its rim moves outwards"


# ------------------------------------------------------------------ release (thesis, Figure 10)


def test_the_release_loses_only_what_viscosity_takes() -> None:
    settings = {"solid.mesh.cells": [8, 2], "scene.duration": 0.06, "record.fields_at": [], "record.fields_every": 1}
    result = run("release", settings)
    assert end(result, 0)[0] == pytest.approx(0.03, rel=0.03)
    way = np.array([end(result, state)[0] for state in range(len(result.fields))])
    assert np.sum(np.diff(np.sign(way - 2e-3)) != 0.0) >= 6, "it swings"
    assert way.min() < -0.01
    assert_volume_is_kept(result)
    stored = result["energy/kinetic"] + result["energy/elastic"]
    assert np.all(np.diff(stored) < 0.0)
    lost = stored[0] - stored[-1]
    assert lost > 0.1 * stored[0]
    assert lost == pytest.approx(result["energy/viscous"][-1], rel=1e-9)


def test_the_release_without_viscosity_loses_nothing() -> None:
    result = run("release", {"solid.mesh.cells": [8, 2], "scene.duration": 0.06, "solid.viscosity": 0.0})
    stored = result["energy/kinetic"] + result["energy/elastic"]
    assert result["energy/kinetic"].max() > 0.3 * stored[0]
    assert np.abs(stored / stored[0] - 1.0).max() < 1e-9


# ------------------------------------------------------------------ quick release, twitch


def test_tension_falls_with_the_release_and_comes_back() -> None:
    result = run("quick_release_3d", {"solid.mesh.cells": 2, "scene.duration": 0.16})
    time, tension, force = result["time"], result["mean/tension"], result["reaction/right"][:, 0]
    held = time <= 0.0161
    assert tension[held] == pytest.approx(P_MAX, rel=1e-6), "it starts in equilibrium"
    assert result["energy/kinetic"][held].max() < 1e-6 * result["energy/kinetic"].max()
    falling = (time > 0.016) & (time <= 0.0361)
    assert tension[falling].min() < 0.1 * P_MAX, "T1"
    assert force[falling].min() < 0.1 * force[0]
    half = time[(time > 0.036) & (tension > 0.5 * P_MAX)][0]
    # Heads attach with f1 + g1 = 53 / s at most: they need some ten milliseconds.
    assert 0.04 < half < 0.08
    assert tension[-1] > 0.9 * P_MAX
    late = tension[time > 0.04]
    assert np.all(np.diff(late) > -0.02 * P_MAX), "it redevelops"
    assert_volume_is_kept(result)
    assert_energy_comes_from_somewhere(result)
    assert result["energy/external"][-1] < 0.0, "the muscle works on what lets it shorten"


def test_the_twitch_rises_and_falls() -> None:
    result = run("twitch_3d", {"solid.mesh.cells": 2, **WITHOUT_CONTROL, "scene.step": 8e-3, "record.fields_every": 3})
    time, tension = result["time"], result["mean/tension"]
    peak = int(np.argmax(tension))
    assert tension[0] == 0.0
    assert tension[peak] > 0.1 * P_MAX
    assert 0.05 < time[peak] < 0.3
    assert tension[-1] < 0.1 * tension[peak]
    activation = result["mean/activation"]
    assert time[int(np.argmax(activation))] == pytest.approx(0.03, abs=8e-3), "calcium follows the stimulus at once"
    way = np.array([end(result, state)[0] for state in range(len(result.fields))])
    assert way.min() < -2e-3
    assert abs(way[-1]) < 0.1 * abs(way.min()), "passive tissue brings it back"
    assert_volume_is_kept(result)
    assert_energy_comes_from_somewhere(result)


@pytest.mark.slow
def test_the_muscle_in_space_comes_to_its_equilibrium() -> None:
    settings = {"solid.mesh.cells": 6}
    result = run("contraction", settings)
    assert_equilibrium(result, statics_of("contraction", settings))
    assert_volume_is_kept(result)
    assert_energy_comes_from_somewhere(result)
