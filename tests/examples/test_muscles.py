"""The scenes with a body: each is asserted on what it shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import myobridge as mb
from myobridge.errors import MyobridgeError

EXAMPLES = Path(__file__).parents[2] / "examples"
WEIGHT = 2.0 * 9.81


def run(name: str, **settings: object) -> mb.Result:
    return mb.run(
        EXAMPLES / f"{name}.toml", settings={key.replace("__", "."): value for key, value in settings.items()}
    )


def end(result: mb.Result, state: int) -> np.ndarray:
    """Mean displacement of the right end [m]."""
    assert result.mesh is not None
    right = result.mesh.points[:, 0] > result.mesh.points[:, 0].max() - 1e-9
    return result.fields[state]["displacement"][right].mean(axis=0)


def middle(result: mb.Result) -> np.ndarray:
    """Which cells lie in the middle third."""
    assert result.mesh is not None
    centres = result.mesh.points[result.mesh.cells].mean(axis=1)[:, 0]
    return np.abs(centres / centres.max() - 0.5) < 1.0 / 6.0


@pytest.fixture(scope="module")
def lifting() -> mb.Result:
    return run("lifting")


def test_the_weight_is_lifted(lifting: mb.Result) -> None:
    """Thesis, Figure 3: four states, each stable; the support carries the weight; the tissue keeps its volume."""
    assert [state.time for state in lifting.fields] == [0.0, 0.4, 0.8, 1.2]
    places = [end(lifting, state)[0] for state in range(4)]
    assert places == sorted(places, reverse=True), "more tension, higher weight"
    assert places[0] > 5e-3
    assert places[3] < -5e-3
    assert np.all(lifting["negative_eigenvalues"] == 0)
    assert lifting["reaction/left"][:, 0] == pytest.approx(-WEIGHT, rel=1e-9)
    assert np.abs(lifting["reaction/left"][:, 1]).max() < 1e-9 * WEIGHT
    assert np.abs(lifting.fields[3]["J"] - 1.0).max() < 0.01, (
        "of single cells; P2-P1 keeps the volume around each corner"
    )
    assert lifting.fields[3]["J"].mean() == pytest.approx(1.0, abs=1e-5)
    tension = lifting.fields[3]["tension"]
    assert tension == pytest.approx(1.2 * 73e3, rel=1e-12)


@pytest.mark.parametrize("model", ["hill", "huxley", "distributed_moment"])
def test_every_model_lifts_it_by_one_line(lifting: mb.Result, model: str) -> None:
    """In statics each pulls with its isometric tension: the same states, as far as p_max is the same."""
    result = run("lifting", cross_bridges__plugin=model)
    places = np.array([end(result, state)[0] for state in range(4)])
    expected = np.array([end(lifting, state)[0] for state in range(4)])
    assert places == pytest.approx(expected, abs=2e-6)
    assert np.all(result["negative_eigenvalues"] == 0)


@pytest.mark.parametrize("model", ["liouville", "discrete"])
def test_models_without_a_steady_state_say_so(model: str) -> None:
    with pytest.raises(MyobridgeError, match="isometric steady state"):
        run("lifting", cross_bridges__plugin=model)


def test_fewer_sarcomeres_at_the_ends(lifting: mb.Result) -> None:
    """Thesis, Figures 4 and 5: the middle contracts as before, the ends less; the weight is lifted less."""
    result = run("lifting_density")
    ends = ~middle(result)
    assert result.fields[3]["tension"].min() < 0.5 * result.fields[3]["tension"].max()
    here, uniform = result.fields[3]["stretch"], lifting.fields[3]["stretch"]
    assert here[ends].mean() > uniform[ends].mean() + 0.02
    assert abs(here[~ends].mean() - uniform[~ends].mean()) < 0.01
    assert end(lifting, 3)[0] < end(result, 3)[0] < 0.0


def test_the_weight_is_lifted_in_time(lifting: mb.Result) -> None:
    """Cross-bridges attach as activation rises; the weight comes towards where statics has it, and not beyond."""
    result = run("lifting_ramp")
    assert np.all(result["tension"][0] == 0.0)
    assert 0.5 * 73e3 < result["tension"][-1].mean() < 73e3, "it still shortens, so it pulls with less"
    late = result["time"] > 0.1
    assert np.all(np.diff(result["stretch"][late].mean(axis=1)) < 0.0)
    static = np.interp(1.0, [0.8, 1.2], [end(lifting, 2)[0], end(lifting, 3)[0]])
    assert static < end(result, -1)[0] < 0.0
    finer = run("lifting_ramp", scene__step=0.005)
    ratio = finer["energy/drift"][-1] / result["energy/drift"][-1]
    assert 0.4 < ratio < 0.6, (
        f"equilibria at the ends of steps book energy to order 1, and half the step left {ratio:.2f}"
    )
    assert result["energy/attached"][-1] > 0.1


def test_the_muscle_in_space() -> None:
    """Tendon has no cross-bridges and hardly stretches; fibres run along the surface; the weight is carried."""
    result = run("lifting_3d")
    tension = result.fields[-1]["tension"]
    tendon = np.isnan(tension)
    assert 0.05 < tendon.mean() < 0.5
    assert tension[~tendon] == pytest.approx(73e3, rel=1e-12)
    stretch = result.fields[0]["stretch"]
    assert stretch[tendon].mean() - 1.0 < 0.2 * (stretch[~tendon].max() - 1.0)
    assert result["reaction/left"][:, 0] == pytest.approx(-9.81, rel=1e-9)
    assert end(result, -1)[0] < end(result, 0)[0] - 2e-3
    assert np.all(result["negative_eigenvalues"] == 0)
    fibre = result.fields[0]["fibre"]
    assert np.linalg.norm(fibre, axis=1) == pytest.approx(1.0)
    assert fibre[:, 0].min() > 0.7
    assert np.abs(fibre[:, 1:]).max() > 0.2


def test_newton_does_not_see_the_mesh() -> None:
    """Thesis, Figure 2: on three meshes the iterations stay equal within 2 (asymptotic mesh independence)."""
    counts, places = [], []
    for refinements in range(3):
        result = run("mesh_refinement", solid__mesh__refinements=refinements)
        counts.append(result["iterations"].tolist())
        places.append(end(result, -1)[0])
    print("iterations:", counts, "place of the weight [mm]:", [round(1e3 * place, 4) for place in places])
    assert np.ptp(np.array(counts), axis=0).max() <= 2
    assert abs(places[2] - places[1]) < 0.5 * abs(places[1] - places[0])


def test_the_column_buckles() -> None:
    """At twice its critical load: the elastica's deflection within 3 %, and stable throughout."""
    result = run("buckling_column")
    modulus = brentq(lambda k: ellipk(k * k) - 0.5 * np.pi * np.sqrt(2.0), 0.1, 0.999)
    elastica = 2.0 * modulus / ellipk(modulus**2)  # deflection of the free end over the length, .797
    assert abs(end(result, -1)[1]) / 0.1 == pytest.approx(elastica, rel=0.03)
    assert np.all(result["negative_eigenvalues"] == 0)


def test_a_straight_column_is_reported_as_unstable() -> None:
    with pytest.warns(UserWarning, match="unstable"):
        result = run("buckling_column", solid__mesh__bow=0.0, continuation__plugin="natural")
    assert abs(end(result, -1)[1]) < 1e-9
    assert result["negative_eigenvalues"][0] == 0
    assert result["negative_eigenvalues"][-1] > 0


def test_the_arch_snaps_through() -> None:
    """The load rises to the first limit point, falls to the second, rises again; in between the arch is unstable."""
    with pytest.warns(UserWarning, match="unstable"):
        result = run("shallow_arch")
    turns = np.diff(np.sign(np.diff(result["scale"]))) != 0.0
    assert np.sum(turns) == 2
    falling = np.diff(result["scale"], append=2.0) < 0.0
    unstable = result["negative_eigenvalues"] > 0
    assert np.sum(unstable ^ falling) <= 2, "unstable where the load falls, but for the limit points themselves"
    assert result["negative_eigenvalues"][-1] == 0
