"""Bodies in motion with heads at every point: interrupted anywhere and resumed is never interrupted, to the last bit.

Each integrator has its own memory (differences of steps, accelerations, a stability limit), Newton's methods keep
factors, the step control counts halvings and estimates errors: all of it is in the checkpoint, or made anew from it.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import myobridge as mb
from myobridge.plan import Plan
from myobridge.run import start

DT = 1e-3
STEPS = 8
INTEGRATORS = {item.name: item.cls for item in mb.registry() if item.family == "time_integrator"}
# Explicit methods that know no constraint; the others get the strictly incompressible body.
COMPRESSIBLE = ("symplectic_euler", "stoermer_verlet")

BODY = """
[scene]
name = "body in motion"
effects = [{effects}]
duration = {duration}
step = {step}
{tolerance}
[solid]
plugin = "finite_element"
mesh = {{ plugin = "block", size = [0.04, 0.02], cells = {cells} }}
material = {{ plugin = "mooney_rivlin", parameters = "thesis" }}
fibres = {{ plugin = "constant", direction = [1.0, 0.3] }}
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [2e3, -4e3]
scale = {{ plugin = "sine", amplitude = 1.0, frequency = 40.0 }}
[cross_bridges]
plugin = "huxley"
bins = 8
low = -4.0
high = 8.0
[activation]
plugin = "ramp"
initial = 0.2
final = 1.0
end = 0.006
[calcium]
plugin = "first_order"
[coupling]
plugin = "{coupling}"
[integrator]
plugin = "{integrator}"
{options}
[record]
quantities = ["stretch", "tension", "energy", "displacement", "reactions"]
fields = ["displacement", "tension"]
fields_every = 3
every = 2
"""


def body(
    integrator: str = "energy_momentum",
    options: str = "",
    *,
    step: float = DT,
    tolerance: float | None = None,
    coupling: str = "splitting",
    cells: Sequence[int] = (2, 1),
) -> mb.Scene:
    """Scene of a few steps; viscosity is on where there is inertia."""
    effects = [
        "cross_bridges",
        "activation",
        "calcium",
        *(["inertia", "viscosity"] if INTEGRATORS[integrator].inertia else []),
    ]
    if integrator not in COMPRESSIBLE:
        effects.append("incompressibility")
    text = BODY.format(
        effects=", ".join(f'"{name}"' for name in effects),
        duration=STEPS * step,
        step=step,
        tolerance="" if tolerance is None else f"tolerance = {tolerance}",
        coupling=coupling,
        cells=list(cells),
        integrator=integrator,
        options=options,
    )
    return mb.Scene.from_toml(text)


def assert_identical(one: mb.Result, other: mb.Result) -> None:
    """Same series, fields and checkpoint, bit by bit."""
    assert set(one.series) == set(other.series)
    for name, rows in one.series.items():
        np.testing.assert_array_equal(rows, other.series[name], err_msg=name, strict=True)
    assert [item.time for item in one.fields] == [item.time for item in other.fields]
    for left, right in zip(one.fields, other.fields, strict=True):
        for name in ("displacement", "tension"):
            np.testing.assert_array_equal(left[name], right[name], err_msg=name)
    assert dict(one.checkpoint.scalars) == dict(other.checkpoint.scalars)
    assert set(one.checkpoint.arrays) == set(other.checkpoint.arrays)
    for name, array in one.checkpoint.arrays.items():
        np.testing.assert_array_equal(array, other.checkpoint.arrays[name], err_msg=name, strict=True)


def in_parts(scene: mb.Scene, shares: Sequence[float], path: Path) -> mb.Result:
    """Run to each share of the duration in turn, and let the file be all that is left there."""
    under_way = start(Plan.of(scene), path)
    for share in shares:
        under_way.to(scene.duration, until=share * scene.duration)
        under_way, again = mb.resume(path)
        assert again == scene
    return under_way.to(scene.duration)


def check(scene: mb.Scene, path: Path, shares: Sequence[float] = (0.2, 0.7)) -> mb.Result:
    """A run without a stop against one with several; what the former left."""
    whole = mb.run(scene)
    assert np.ptp(whole["stretch"]) > 1e-5, "something must have moved"
    assert whole["energy/detached"][-1] > 1e-4 * whole["energy/cross_bridge"][0]
    assert_identical(in_parts(scene, shares, path / "parts.h5"), whole)
    return whole


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_every_integrator_resumes(name: str, tmp_path: Path) -> None:
    whole = check(body(name, step=2e-5 if INTEGRATORS[name].explicit else DT), tmp_path)
    remembered = {"bdf2": "displacement", "generalised_alpha": "acceleration", "rattle": "rattle/limit"}
    if name in remembered:
        assert f"memory/{remembered[name]}" in whole.checkpoint.arrays


@settings(max_examples=5)
@given(shares=st.lists(st.floats(0.0, 0.99), min_size=1, max_size=3).map(sorted))
def test_wherever_it_is_interrupted(shares: list[float]) -> None:
    """With every memory at once: differences of steps, kept factors, estimated errors, halved steps."""
    scene, whole = _with_everything()
    with TemporaryDirectory() as folder:
        assert_identical(in_parts(scene, shares, Path(folder) / "parts.h5"), whole)


@functools.cache
def _with_everything() -> tuple[mb.Scene, mb.Result]:
    scene = body("bdf2", 'newton = { plugin = "simplified" }', step=2e-3, tolerance=2e-4)
    whole = mb.run(scene)
    assert whole.checkpoint.scalars["steps"] > STEPS
    assert {"memory/displacement", "memory/kept/work", "error/velocity"} <= set(whole.checkpoint.arrays)
    return scene, whole


@pytest.mark.parametrize("method", mb.registry().names("newton"))
@pytest.mark.parametrize("name", ["energy_momentum", "bathe"])
def test_every_newton_method_resumes(name: str, method: str, tmp_path: Path) -> None:
    """Factors are not written: after a checkpoint they are made again from the very same matrix, a sparse one here."""
    whole = check(body(name, f'newton = {{ plugin = "{method}" }}', cells=(5, 3)), tmp_path)
    assert whole["displacement"].shape[1] > 120
    assert ("memory/kept/mark" in whole.checkpoint.arrays) == (method != "ordinary")


@pytest.mark.parametrize("coupling", mb.registry().names("coupling"))
def test_every_coupling_resumes(coupling: str, tmp_path: Path) -> None:
    check(body(coupling=coupling, step=1e-4 if coupling == "staggered" else DT), tmp_path)


@pytest.mark.parametrize("name", ["energy_momentum", "bdf2", "generalised_alpha", "bathe"])
def test_steps_controlled_by_their_error_resume(name: str, tmp_path: Path) -> None:
    whole = check(body(name, step=2e-3, tolerance=2e-4), tmp_path)
    assert whole.checkpoint.scalars["steps"] > STEPS, "some step was halved"


@pytest.mark.parametrize("name", ["energy_momentum", "bdf2", "generalised_alpha"])
def test_steps_that_failed_leave_no_trace(name: str, tmp_path: Path) -> None:
    """Newton's method may not take long here: steps fail and are halved, before a stop and after one."""
    whole = check(body(name, 'newton = { plugin = "ordinary", max_iterations = 4 }'), tmp_path)
    assert whole.checkpoint.scalars["steps"] > STEPS


def test_the_stability_limit_of_rattle_resumes(tmp_path: Path) -> None:
    """The limit halves the step, and is looked at again in the course of the run."""
    whole = check(body("rattle", step=2e-4), tmp_path, (0.2, 0.45, 0.7))
    assert whole.checkpoint.scalars["steps"] > 33
