"""The public API: a scene from a file, from Python, or no scene at all."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import myobridge as mb


def build(family: str, name: str, **parameters: object) -> object:
    """A plugin, composed by hand."""
    return mb.registry().find(family, name).cls(**parameters)


def test_everything_promised_is_there() -> None:
    assert len(mb.__all__) == len(set(mb.__all__)) > 30
    for name in mb.__all__:
        assert getattr(mb, name) is not None
    assert mb.__version__.count(".") == 2


def test_the_version_is_that_of_the_package() -> None:
    from importlib.metadata import version

    assert version("myobridge") == mb.__version__


def test_from_a_file(write, scenes, tmp_path) -> None:
    path = write(scenes["clamp"])
    result = mb.run(path, tmp_path / "result.h5", {"scene.duration": 0.01})
    assert result["time"][-1] == pytest.approx(0.01, abs=1e-15)
    assert mb.Result.load(tmp_path / "result.h5")["tension"].shape == (11, 2)
    assert mb.Scene.load(path).cross_bridges == {"plugin": "distributed_moment"}
    assert mb.Scene.load(str(path), {"solid.sites": 5}).solid["sites"] == 5


def test_a_scene_in_python_is_the_scene_in_the_file(scenes) -> None:
    path = {"plugin": "ramp", "initial": 1.0, "final": 0.98, "start": 0.005, "end": 0.015}
    scene = mb.Scene(
        name="clamp",
        effects=["cross_bridges"],
        duration=0.02,
        step=1e-3,
        solid={"plugin": "clamp", "sites": 2, "path": path},
        cross_bridges="distributed_moment",  # pyright: ignore[reportArgumentType]
    )
    assert scene == mb.Scene.from_toml(scenes["clamp"])


@pytest.mark.parametrize("name", ["spring", "chain"])
def test_composition_without_any_file_is_the_same_simulation(name: str, scenes) -> None:
    expected = mb.run(mb.Scene.from_toml(scenes[name]))
    if name == "spring":
        simulation = mb.Simulation(
            solid=build("macro_solid", "spring", mass=0.1, stiffness=500.0, velocity=0.05),  # pyright: ignore
            cross_bridges=build("cross_bridge", "liouville"),  # pyright: ignore
            integrator=build("time_integrator", "energy_momentum"),  # pyright: ignore
            coupling=build("coupling", "splitting"),  # pyright: ignore
            dt=1e-3,
        )
    else:
        simulation = mb.Simulation(
            solid=build("macro_solid", "chain", springs=4, length=0.1),  # pyright: ignore
            cross_bridges=build("cross_bridge", "distributed_moment"),  # pyright: ignore
            integrator=build("time_integrator", "quasi_static"),  # pyright: ignore
            activation=build("signal", "ramp", initial=0.2, final=1.0, end=0.01),  # pyright: ignore
            dt=1e-3,
        )
    result = mb.Run(simulation, mb.Record()).to(0.02)
    for series, rows in expected.series.items():
        np.testing.assert_array_equal(result.series[series], rows, err_msg=series)


def test_a_simulation_steps_by_hand(scenes) -> None:
    simulation = mb.Plan.of(mb.Scene.from_toml(scenes["passive"])).simulation()
    report = simulation.step()
    assert report.converged
    assert simulation.time == pytest.approx(1e-3)
    assert simulation.run(0.01).steps == 10
    assert abs(simulation.ledger.drift) < 1e-12


def test_parts_that_do_not_go_together_are_told() -> None:
    spring, midpoint = build("macro_solid", "spring"), build("time_integrator", "midpoint")
    constant = build("signal", "constant", level=0.5)
    with pytest.raises(mb.SceneError, match="activation: acts on cross-bridges, and there are none"):
        mb.Simulation(solid=spring, integrator=midpoint, activation=constant)  # pyright: ignore
    with pytest.raises(mb.SceneError, match=r"step: is 0\.0"):
        mb.Simulation(solid=spring, integrator=midpoint, dt=0.0)  # pyright: ignore
    clamp = build("macro_solid", "clamp", path=build("signal", "constant", level=1.0))
    with pytest.raises(mb.SceneError, match="integrator: Midpoint integrates inertia, and Clamp has no mass"):
        mb.Simulation(solid=clamp, integrator=midpoint)  # pyright: ignore


def test_importing_is_light() -> None:
    """What takes long to import is loaded by whoever needs it."""
    program = "import sys, myobridge; print(' '.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert "myobridge.simulation" in loaded
    assert not {"matplotlib", "numba", "h5py", "rich", "skfem", "scipy.sparse"} & set(loaded)
