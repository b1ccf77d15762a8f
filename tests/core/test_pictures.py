"""Pictures: the panels that a result has something to say in, with units, and no line that says nothing."""

from __future__ import annotations

from typing import Any

import pytest
from matplotlib.figure import Figure

import myobridge as mb
from myobridge.pictures import draw, draw_density


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch, tmp_path) -> Any:
    """Draw, and return the axes as they were when the picture was written."""

    def axes_of(result: mb.Result) -> dict[str, Any]:
        found: dict[str, Any] = {}

        def keep(figure: Figure, target: object, **_: object) -> None:
            found.update({axis.get_ylabel(): axis for axis in figure.axes})

        monkeypatch.setattr(Figure, "savefig", keep)
        draw(result, tmp_path / "picture.png")
        return found

    return axes_of


def run(text: str, **settings: object) -> mb.Result:
    """Result of a scene with settings (``section__key``)."""
    return mb.run(mb.Scene.from_toml(text), settings={key.replace("__", "."): value for key, value in settings.items()})


def test_panels_of_an_active_chain(drawn, scenes) -> None:
    axes = drawn(run(scenes["chain"]))
    assert list(axes) == [
        "stretch [-]",
        "tension [kPa]",
        "activation [-]",
        "moments, mean over sites [-]",
        "energy [mJ]",
    ]
    assert {axis.get_xlabel() for axis in axes.values()} == {"time [ms]"}
    assert [text.get_text() for text in axes["activation [-]"].get_legend().get_texts()] == ["all sites"]
    assert [line.get_label() for line in axes["moments, mean over sites [-]"].lines] == ["Q0", "Q1", "Q2"]


def test_panels_of_a_passive_spring(drawn, scenes) -> None:
    axes = drawn(run(scenes["passive"]))
    assert list(axes) == ["stretch [-]", "energy [µJ]"]
    assert [line.get_label() for line in axes["energy [µJ]"].lines] == ["kinetic (stored)", "elastic (stored)"]


def test_a_model_without_a_population_has_no_moments(drawn, scenes) -> None:
    assert "moments [-]" not in drawn(run(scenes["clamp"], cross_bridges__plugin="prescribed", solid__sites=1))
    assert "moments [-]" in drawn(run(scenes["clamp"], solid__sites=1))


def test_a_sweep_of_speeds_has_its_own_curve(drawn, scenes) -> None:
    path = {"plugin": "ramp", "initial": 1.0, "slope": [-0.1 * i for i in range(20)]}
    axes = drawn(run(scenes["clamp"], solid__sites=20, solid__path=path))
    curve = axes["tension at the end [kPa]"]
    assert curve.get_xlabel() == "stretch rate [1/s] at the end"
    speeds = curve.lines[0].get_xdata()
    assert list(speeds) == sorted(speeds)
    assert speeds[0] == pytest.approx(-1.9)
    assert len(axes["tension [kPa]"].lines) == 12, "no more lines than the eye can tell apart"
    labels = [text.get_text() for text in axes["tension [kPa]"].get_legend().get_texts()]
    assert labels == ["site 0", "site 19"]


def test_density_is_that_of_the_site_that_moved_most_where_heads_are(scenes) -> None:
    path = {"plugin": "ramp", "initial": 1.0, "slope": [0.0, -0.5]}
    result = run(scenes["clamp"], cross_bridges__plugin="huxley", solid__path=path, record__density_at=[0.0, 0.02])
    axis = Figure().subplots()
    draw_density(axis, result)
    assert [line.get_label() for line in axis.lines] == ["0 ms", "20 ms"]
    assert (axis.lines[1].get_ydata() == result.densities[1].fraction[1]).all()
    assert axis.get_legend().get_title().get_text() == "site 1"
    low, high = axis.get_xlim()
    assert -3.0 < low < 0.0
    assert 1.0 < high < 2.0


def test_nothing_to_draw_is_said(scenes, tmp_path) -> None:
    with pytest.raises(mb.MyobridgeError, match=r"no series to draw; record some"):
        draw(run(scenes["clamp"], record__quantities=[]), tmp_path / "picture.png")


def test_a_summary_is_a_line_in_a_band(drawn, moving) -> None:
    result = moving("quad", {"quantities": ["summary"]}, counts=(5, 3, 0)).to(0.5)
    axes = drawn(result)
    assert list(axes) == ["stretch [-]", "tension [kPa]", "activation [-]"]
    axis = axes["stretch [-]"]
    assert [text.get_text() for text in axis.get_legend().get_texts()] == ["least to largest", "mean"]
    assert (axis.lines[0].get_ydata() == result["mean/stretch"]).all()
    band = axis.collections[0].get_paths()[0].vertices[:, 1]
    assert (band.min(), band.max()) == (result["least/stretch"].min(), result["largest/stretch"].max())
    assert list(drawn(moving("quad", {"quantities": ["summary"]}, ramp=False).to(0.1))) == [
        "stretch [-]",
        "tension [kPa]",
    ]


def test_curves_of_statics_run_along_the_scale(drawn, scenes) -> None:
    text = scenes["chain"].replace("duration = 0.02\nstep = 1e-3\n", "").partition("[activation]")[0]
    text = text.replace('["cross_bridges", "activation"]', '["cross_bridges"]') + '[continuation]\nplugin = "natural"\n'
    axes = drawn(mb.run(mb.Scene.from_toml(text)))
    assert {axis.get_xlabel() for name, axis in axes.items() if "at the end" not in name} == {"scale [-]"}
    assert axes["tension [kPa]"].lines[0].get_xdata()[-1] == 1.0
