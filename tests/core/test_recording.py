"""Recording: the rows, sites and quantities asked for, and no work for what nobody asked for."""

from __future__ import annotations

import numpy as np
import pytest

import myobridge as mb
from myobridge.recording import QUANTITIES


def sample(text: str, **record: object) -> mb.Result:
    """Result of a scene with a record."""
    return mb.run(mb.Scene.from_toml(text), settings={f"record.{key}": value for key, value in record.items()})


@pytest.mark.parametrize(("every", "rows"), [(1, 21), (4, 6), (7, 4), (20, 2), (1000, 2)])
def test_every_keeps_the_first_each_nth_and_the_last(every: int, rows: int, scenes) -> None:
    all_rows, some = sample(scenes["chain"]), sample(scenes["chain"], every=every)
    kept = sorted({*range(0, 21, every), 20})
    assert len(kept) == rows
    for name, data in some.series.items():
        np.testing.assert_array_equal(data, all_rows.series[name][kept], err_msg=name)


def test_sites_are_kept_in_the_order_asked_for(scenes) -> None:
    whole, some = sample(scenes["chain"]), sample(scenes["chain"], sites=[3, 0])
    np.testing.assert_array_equal(some.sites, [3, 0])
    for name in ("stretch", "tension", "stretch_rate", "activation", "Q0", "Q1", "Q2"):
        np.testing.assert_array_equal(some[name], whole[name][:, [3, 0]], err_msg=name)


def test_points_find_the_nearest_site(scenes) -> None:
    # Four segments of 25 mm: their middles lie at 12.5, 37.5, 62.5 and 87.5 mm.
    assert sample(scenes["chain"], points=[0.0, 0.049, 0.051, 0.1]).sites.tolist() == [0, 1, 2, 3]
    assert sample(scenes["chain"], points=0.07).sites.tolist() == [2]


@pytest.mark.parametrize("point", [-0.02, 0.13])
def test_a_point_outside_is_an_error(point: float, scenes) -> None:
    with pytest.raises(mb.SceneError, match=r"record\.points: names .* outside the solid"):
        sample(scenes["chain"], points=point)


def test_only_the_quantities_asked_for(scenes) -> None:
    found = sample(scenes["rope"], quantities=["tension", "momentum"]).series
    assert set(found) == {"time", "tension", "momentum", "angular_momentum"}
    assert set(sample(scenes["rope"], quantities=[]).series) == {"time"}


def test_every_quantity_has_rows(scenes) -> None:
    found = sample(scenes["rope"], quantities=sorted(QUANTITIES)).series
    firsts = {"moments": "Q1", "energy": "energy/elastic", "reactions": "reaction/left", "summary": "mean/tension"}
    for quantity in QUANTITIES:
        assert len(found[firsts.get(quantity, quantity)]) == 21, quantity


@pytest.mark.parametrize(
    ("quantity", "owner", "method"),
    [
        ("moments", "CouplingBus", "moments"),
        ("reactions", "spring", "reactions"),
        ("momentum", "spring", "momentum"),
        ("energy", "Ledger", "entries"),
    ],
)
def test_what_is_not_recorded_is_not_computed(
    quantity: str, owner: str, method: str, scenes, monkeypatch: pytest.MonkeyPatch
) -> None:
    cls = {"CouplingBus": mb.CouplingBus, "Ledger": mb.Ledger}.get(owner)
    cls = cls or mb.registry().find("macro_solid", owner).cls
    real, calls = getattr(cls, method), []

    def counted(self: object, *arguments: object, **keywords: object) -> object:
        calls.append(method)
        return real(self, *arguments, **keywords)

    monkeypatch.setattr(cls, method, counted)
    sample(scenes["spring"], quantities=[name for name in QUANTITIES if name != quantity])
    assert calls == []
    sample(scenes["spring"], quantities=[quantity])
    assert len(calls) == 21


def test_density_is_asked_for_at_its_times_only(scenes, monkeypatch: pytest.MonkeyPatch) -> None:
    text = scenes["clamp"].replace("distributed_moment", "huxley")
    cls = mb.registry().find("cross_bridge", "huxley").cls
    real, calls = cls.density, []

    def counted(self: object, state: np.ndarray) -> object:
        calls.append(state.shape[0])
        return real(self, state)

    monkeypatch.setattr(cls, "density", counted)
    assert sample(text).densities == ()
    assert calls == []
    found = sample(text, density_at=[0.0, 0.0123], sites=[1])
    assert [item.time for item in found.densities] == pytest.approx([0.0, 0.0123], abs=1e-15)
    assert calls == [1, 1], "one site is recorded, so one site's density is asked for"
    assert 0.0123 in found["time"].round(12), "a step ends there"


def test_recording_changes_nothing(scenes) -> None:
    plain = sample(scenes["rope"])
    richly = sample(scenes["rope"], quantities=sorted(QUANTITIES), every=3)
    for name, array in plain.checkpoint.arrays.items():
        np.testing.assert_array_equal(array, richly.checkpoint.arrays[name], err_msg=name)


def test_a_passive_solid_has_no_rows_of_cross_bridges(scenes) -> None:
    found = sample(scenes["passive"], quantities=sorted(QUANTITIES)).series
    assert not {"tension", "activation", "Q0", "Q1", "Q2"} & set(found)
    assert np.ptp(found["stretch"]) > 1e-3
