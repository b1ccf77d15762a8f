"""Studies as data and in this process: variants, norms, references, rows, what is kept."""

from __future__ import annotations

import errno
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge.study import Quantity, Reference
from myobridge.study.norms import relative_error
from myobridge.study.reference import estimated_error
from myobridge.study.refinement import of_scene, refined
from myobridge.study.variants import crossed
from myobridge.testing.fitted_order import fitted_order

# Heads attach to an empty population at fixed length: every position on its own, so there is a closed form.
ISOMETRIC = """
[scene]
name = "attach"
effects = ["cross_bridges"]
duration = 0.1
step = 0.01
[solid]
plugin = "clamp"
path = { plugin = "constant", level = 1.0 }
[cross_bridges]
plugin = "huxley"
start = "empty"
bins = 8
"""
STUDY = """
[study]
scene = "scene.toml"
quantities = ["tension"]
tolerance = 1e-2
repeats = 1
[vary]
"scene.step" = [4e-3, 2e-3]
"""


def attaching(times: np.ndarray) -> dict[str, np.ndarray]:
    r"""Tension of ISOMETRIC [Pa]: :math:`\int q\,\rho_\infty (1 - e^{-(f+g) t})` with linear rates, by quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    q, w = 0.5 * (nodes + 1.0), 0.5 * weights
    rho = 43.3 / 53.3 * (1.0 - np.exp(-53.3 * np.outer(times, q)))
    return {"tension": 73e3 * (rho @ (w * q)) / (43.3 / 53.3 / 2.0)}


def isometric(**said) -> mb.Study:
    """Study of ISOMETRIC."""
    given = {"vary": {"cross_bridges.bins": [8, 16, 32]}, "repeats": 1, "quantities": ["tension"], **said}
    return mb.Study(scene=mb.Scene.from_toml(ISOMETRIC), **given)


# ---------------------------------------------------------------------- variants


def test_axes_are_crossed_and_blocks_added_up() -> None:
    exact = {"cross_bridges.bins": [8, 16], "scene.step": [1e-3, 2e-3, 4e-3]}
    named = {
        "cross_bridges": {"plugin": "distributed_moment"},
        "way": {"plain": {}, "second": {"cross_bridges.method": "extrapolated"}},
    }
    variants = crossed([exact, named])
    assert len(variants) == 2 * 3 + 2
    assert {variant.family for variant in variants[:6]} == {""}
    assert [variant.family for variant in variants[6:]] == ["plain", "second"]
    assert {variant.model for variant in variants[:6]} == {""}, "bins and steps make no other model"
    assert {variant.model for variant in variants[6:]} == {"cross_bridges.plugin=distributed_moment"}
    assert variants[7].settings == {
        "cross_bridges.plugin": "distributed_moment",
        "cross_bridges.method": "extrapolated",
    }
    assert len(crossed([exact, exact])) == 6, "the same variant twice is one"


def test_a_recommendation_can_be_pasted() -> None:
    (variant,) = crossed([{"solid.mesh.cells": [[4, 2]], "cross_bridges.discretisation": "upwind"}])
    assert variant.command == "--set 'solid.mesh.cells=[4, 2]' --set 'cross_bridges.discretisation=\"upwind\"'"
    assert variant.label == "cells 4x2"


@given(levels=st.integers(-2, 4))
def test_finer_is_finer_by_powers_of_two(levels: int) -> None:
    values = {"scene.step": 1e-3, "scene.tolerance": 1e-5, "cross_bridges.bins": 32, "solid.mesh.cells": [16, 4]}
    finer = refined(values, levels)
    assert finer["scene.step"] == pytest.approx(1e-3 * 2.0**-levels)
    assert finer["scene.tolerance"] == pytest.approx(1e-5 * 4.0**-levels)
    assert finer["cross_bridges.bins"] == 32 * 2**levels
    assert finer["solid.mesh.cells"] == [16 * 2**levels, 4 * 2**levels]
    assert refined(values, levels, ["scene.step"])["cross_bridges.bins"] == 32


def test_what_a_scene_can_refine(scenes) -> None:
    assert of_scene(mb.Scene.from_toml(ISOMETRIC)) == {"scene.step": 0.01, "cross_bridges.bins": 8}
    assert of_scene(mb.Scene.from_toml(scenes["rope"])) == {"scene.step": 1e-3, "solid.elements": 2}
    body = {"plugin": "finite_element", "mesh": {"plugin": "block", "size": [0.1, 0.02], "cells": [4, 2]}}
    block = mb.Scene(solid=body | {"material": "neo_hooke"}, duration=1.0, step=0.1)
    assert of_scene(block) == {"scene.step": 0.1, "solid.mesh.cells": [4, 2]}


# ---------------------------------------------------------------------- errors


def test_norms_of_a_known_difference() -> None:
    fine = np.linspace(0.0, 1.0, 4001)
    reference = np.stack([3.0 * np.ones_like(fine), 4.0 * np.ones_like(fine)], axis=1)
    times = np.linspace(0.0, 1.0, 401)
    off = np.stack([3.0 + 0.5 * times, 4.0 * np.ones_like(times)], axis=1)
    assert relative_error(times, off, fine, reference, "max") == pytest.approx(0.1)
    assert relative_error(times, off, fine, reference, "rms") == pytest.approx(0.1 / math.sqrt(3.0), rel=1e-5)
    assert relative_error(times, off[::-1], fine, reference, "end") == 0.0
    zero = np.zeros_like(reference)
    assert relative_error(times, np.zeros_like(off), fine, zero, "max") == 0.0
    assert relative_error(times, off, fine, zero, "max") == pytest.approx(1.0)


@given(order=st.floats(0.5, 4.0), error=st.floats(1e-9, 1e-1))
def test_the_estimate_bounds_the_error_of_a_convergent_sequence(order: float, error: float) -> None:
    values = [error * 2.0 ** (-order * level) for level in range(3)]
    estimate = estimated_error([values[0] - values[1], values[1] - values[2]])
    assert estimate >= values[2] * (1.0 - 1e-6), "no reference may be credited with less than it is off"
    if order <= 2.0:
        assert estimate == pytest.approx(values[2], rel=1e-6)


def test_what_does_not_converge_is_not_credited() -> None:
    assert estimated_error([1e-3, 2e-3]) == 2e-3
    assert estimated_error([1e-3, 0.95e-3]) == 1e-3
    assert estimated_error([0.0, 0.0]) == 0.0


def test_against_a_closed_form_the_order_is_that_of_the_bins() -> None:
    result = isometric(reference=Reference(closed_form=attaching)).run(workers=0)
    bins = [row.variant.settings["cross_bridges.bins"] for row in result.rows]
    errors = [row.error for row in result.rows]
    observed = fitted_order(1.0 / np.array(bins), np.array(errors))
    print(f"observed order in the bins: {observed:.2f}")
    assert observed == pytest.approx(2.0, abs=0.15)
    assert result.standards == {}, "a closed form needs no fine run"


def test_a_fine_reference_is_as_good_as_it_says() -> None:
    result = isometric(vary={"cross_bridges.bins": [8]}).run(workers=0)
    standard = result.standards[""]
    truth = attaching(standard.course.times)["tension"]
    off = float(np.abs(standard.course.values["tension"][:, 0] - truth).max() / truth.max())
    assert standard.converged
    assert 0.0 < off <= 1.05 * standard.error
    assert standard.error < 0.1 * result.rows[0].error


def test_nobody_is_credited_with_less_than_the_reference_is_off() -> None:
    # The variant is finer than all levels of the reference.
    said = {"cross_bridges.bins": 8}
    result = isometric(vary={"cross_bridges.bins": [256]}, reference={"settings": said}).run(workers=0)
    assert result.rows[0].error == result.standards[""].error > 5e-5


def test_model_and_discretisation_are_told_apart(scenes) -> None:
    models = {"huxley": {"cross_bridges.plugin": "huxley"}, "moments": {}, "hill": {"cross_bridges.plugin": "hill"}}
    study = mb.Study(
        scene=mb.Scene.from_toml(scenes["clamp"]),
        vary={"model of heads": models, "scene.step": [2e-3, 1e-3]},
        quantities=["tension"],
        reference={"model": "cross_bridges.plugin=huxley"},
        repeats=1,
    )
    result = study.run(workers=0)
    assert len(result.standards) == 3
    for row in result.rows:
        if row.variant.family == "huxley":
            assert row.model_error == 0.0
            assert row.error == row.discretisation_error
        else:
            assert row.model_error > 0.01, "another model is another model"
            assert row.error <= row.model_error + row.discretisation_error
            assert row.error >= 0.9 * row.model_error
    coarse, fine = (row for row in result.rows if row.variant.family == "moments")
    assert fine.discretisation_error < 0.6 * coarse.discretisation_error


# ---------------------------------------------------------------------- rows


def test_a_variant_that_fails_is_a_row() -> None:
    result = isometric(vary={"cross_bridges.bins": [16, 1, 8]}).run(workers=0)
    good, bad, other = result.rows
    assert good.measured
    assert other.measured
    assert not bad.measured
    assert "cross_bridges.bins: is 1; expected a whole number in [8, 4096]" in bad.reason
    assert bad not in result.pareto()


def test_work_is_counted_the_same_each_time(scenes) -> None:
    study = mb.Study(scene=mb.Scene.from_toml(scenes["rope"]), vary={"scene.step": [2e-3, 1e-3]}, repeats=1)
    first, again = study.run(workers=0), study.run(workers=0)
    for row, other in zip(first.rows, again.rows, strict=True):
        assert row.work == other.work
        assert row.work["newton_iterations"] >= row.steps
        assert row.work["factorisations"] > 0
        assert row.work["bin_steps"] == 0, "Hill has no state"
    upwind = isometric(vary={"cross_bridges.discretisation": ["upwind"]}).run(workers=0).rows[0]
    cells = 20 * 8
    assert upwind.work["bin_steps"] == cells * upwind.steps, "no sub-steps without sliding"


def test_front_recommendation_and_table() -> None:
    result = isometric(tolerance=5e-3, repeats=2).run(workers=0)
    front = result.pareto()
    assert [row.error for row in front] == sorted((row.error for row in front), reverse=True)
    assert [row.cpu for row in front] == sorted(row.cpu for row in front)
    best = result.recommend()
    assert best is not None
    assert best.error <= 5e-3
    assert all(row.cpu >= best.cpu for row in result.rows if row.error <= 5e-3)
    assert result.recommend(1e-12) is None
    assert len({tuple(line) for line in result.table()}) == 1, "a tidy table has the same columns everywhere"
    assert best.runs == 2
    assert best.ratio(best) == 1.0
    with pytest.raises(mb.MyobridgeError, match="tolerance: is not given"):
        isometric(vary={"cross_bridges.bins": [8]}).run(workers=0).recommend()


def test_own_quantities(scenes) -> None:
    study = mb.Study(
        scene=mb.Scene.from_toml(scenes["spring"]),
        vary={"scene.step": [2e-3, 1e-3]},
        quantities=[Quantity("kinetic by hand", lambda now: 0.5 * 0.1 * now.motion.velocity**2), "energy/kinetic"],
        repeats=1,
    )
    result = study.run(workers=0)
    course = result.standards[""].course
    np.testing.assert_allclose(course.values["kinetic by hand"], course.values["energy/kinetic"], rtol=1e-12)
    assert np.ptp(course.values["energy/kinetic"]) > 1e-6


# ---------------------------------------------------------------------- what is kept


def test_what_is_finished_is_kept(tmp_path) -> None:
    first = isometric(vary={"cross_bridges.bins": [8, 16]}).run(tmp_path, workers=0)
    again = isometric(vary={"cross_bridges.bins": [8, 16]}).run(tmp_path, workers=0)
    assert (first.kept, first.computed) == (0, 5)
    assert (again.kept, again.computed) == (5, 0)
    assert [row.error for row in again.rows] == [row.error for row in first.rows]
    assert [row.cpu for row in again.rows] == [row.cpu for row in first.rows]
    # The reference of the extended study starts at 64 bins instead of 32.
    longer = isometric(vary={"cross_bridges.bins": [8, 16, 32]}).run(tmp_path, workers=0)
    assert (longer.kept, longer.computed) == (3, 3), "32 bins were the first level of the reference"
    other = isometric(vary={"cross_bridges.bins": [8, 16]}, settings={"cross_bridges.f1": 40.0})
    assert other.run(tmp_path, workers=0).kept == 0, "another scene"


def test_a_damaged_run_is_run_again(tmp_path) -> None:
    isometric().run(tmp_path, workers=0)
    damaged, emptied, *_ = sorted((tmp_path / "runs").glob("*.npz"))
    damaged.write_bytes(damaged.read_bytes()[:100])
    emptied.write_bytes(b"")
    again = isometric().run(tmp_path, workers=0)
    assert again.computed == 2
    assert all(row.measured for row in again.rows)


def test_a_full_disk_loses_nothing(tmp_path, monkeypatch) -> None:
    whole, calls = np.savez, []

    def filling(file, **arrays):
        calls.append(1)
        if len(calls) > 3:
            file.write(b"half a file")
            raise OSError(errno.ENOSPC, "No space left on device")
        whole(file, **arrays)

    monkeypatch.setattr(np, "savez", filling)
    with pytest.raises(mb.MyobridgeError, match=r"No space left on device\); 3 finished runs are kept"):
        isometric().run(tmp_path, workers=0)
    assert not list((tmp_path / "runs").glob("*.part"))
    monkeypatch.undo()
    assert isometric().run(tmp_path, workers=0).kept == 3


def test_a_file_that_a_scene_names_is_part_of_it(tmp_path) -> None:
    table = "plugin = 'clamp'\npath = { plugin = 'table', file = 'path.csv' }"
    text = ISOMETRIC.replace('plugin = "clamp"\npath = { plugin = "constant", level = 1.0 }', table)
    scene = tmp_path / "scene.toml"
    scene.write_text(text, encoding="utf-8")
    counts = []
    for level in (0.99, 0.99, 0.98):
        (tmp_path / "path.csv").write_text(f"time,value\n0.0,1.0\n0.1,{level}\n", encoding="utf-8")
        study = mb.Study(scene=scene, vary={"cross_bridges.bins": [8]}, repeats=1)
        counts.append(study.run(tmp_path / "kept", workers=0).computed)
    assert counts == [4, 0, 4]


# ---------------------------------------------------------------------- mistakes


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('quantites = ["tension"]', r"study.toml:\d+: study.quantites: is unknown. .* Did you mean 'quantities'\?"),
        ('norm = "maximum"', r"study.toml:\d+: study.norm: is 'maximum'. Allowed: end, max, rms. Did you mean 'max'"),
        ("repeats = 0", r"study.repeats: is 0; expected a whole number in \[1, inf\)"),
        ("tolerance = -1.0", r"study.tolerance: is -1.0; expected a number in \(0, inf\)"),
        ('quantities = ["tensoin"]', r"study.quantities: the scene has no 'tensoin'. .* Did you mean 'tension'\?"),
        ('quantities = ["tip"]', r"study.quantities: the scene has no 'tip'. Allowed: energy, "),
        ("at = [0.5]", r"study.at\[0\]: is 0.5; expected a time in \(0, 0.1\] \[s\]"),
        ('[vary]\n"scene.stp" = [1e-3]', r"study.toml:\d+: vary: scene.stp: is unknown. .* Did you mean 'step'\?"),
        ('[vary]\n"cross_bridges.binz" = [8]', r"vary: cross_bridges.binz: is unknown to 'huxley'. .*'bins'\?"),
        ('[vary]\n"scene.step" = []', r"vary.scene.step: is an empty list, so the cross product has no variant"),
        ("[vary]", r"vary: is empty, so there is nothing to compare"),
        ("[varry]\na = 1", r"varry: is no section of a study. .* Did you mean 'vary'\?"),
        ("[vary]\nways = { plain = 3 }", r"vary.ways.plain: is 3; expected a table of scene keys"),
        ("[reference]\nclosd_form = 'a:b'", r"reference.closd_form: is unknown. .* Did you mean 'closed_form'\?"),
        ("[reference.settings]\ncross_bridges.binz = 8", r"reference.settings: cross_bridges.binz: is unknown"),
        ("[reference]\nmodel = 'hill'", r"reference.model: is 'hill'; the variants have: "),
    ],
)
def test_mistakes_are_told_before_anything_is_run(line: str, said: str, write) -> None:
    write(ISOMETRIC)
    head, table = STUDY.split("[vary]")
    key = line.split("=")[0].strip()
    if line.startswith("["):
        text = head + ("" if "vary]" in line else "[vary]" + table) + line
    else:
        kept = [row for row in head.splitlines() if row.split("=")[0].strip() != key]
        text = "\n".join([*kept, line, "[vary]" + table])
    if line.startswith("[varry]"):
        text = STUDY + line
    with pytest.raises(mb.MyobridgeError, match=said):
        mb.Study.load(write(text, "study.toml"))


def test_a_study_in_a_file_is_the_study_in_python(write) -> None:
    scene = write(ISOMETRIC)
    said = {"vary": {"scene.step": [4e-3, 2e-3]}, "quantities": ["tension"], "tolerance": 1e-2, "repeats": 1}
    assert mb.Study.load(write(STUDY, "study.toml")) == mb.Study(scene=scene, **said)


def test_a_scene_without_time_is_refused() -> None:
    static = ISOMETRIC.replace("duration = 0.1\nstep = 0.01", "") + '[continuation]\nplugin = "natural"\nto = 1.0\n'
    with pytest.raises(mb.MyobridgeError, match="continuation: the scene is without time, and a study compares runs"):
        mb.Study(scene=mb.Scene.from_toml(static), vary={"cross_bridges.bins": [8]})


def test_what_the_reference_may_be_off_counts_against_a_recommendation() -> None:
    found = mb.Study(
        scene=mb.Scene.from_toml(ISOMETRIC), vary={"cross_bridges.bins": [8, 16]}, repeats=1, quantities=["tension"]
    ).run(workers=0)
    least = min(row.error for row in found.measured)
    assert found.doubt > 0.0
    assert found.recommend(least + 0.5 * found.doubt) is None
    assert found.recommend(least + 1.5 * found.doubt) is not None


def test_a_quantity_that_changes_its_shape_is_told() -> None:
    growing = Quantity("growing", lambda now: np.zeros(now.steps))
    found = isometric(quantities=[growing], vary={"cross_bridges.bins": [8]}).run(workers=0)
    assert "'growing' changes its shape during the run" in found.rows[0].reason
