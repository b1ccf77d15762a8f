"""Every registered signal against the contract, and with random parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from myobridge.build import build
from myobridge.registry import registry
from myobridge.testing import signal_checks

EXAMPLES = {
    "constant": {"level": [0.2, 0.7]},
    "ramp": {"initial": 0.1, "final": [0.4, -1.0, 0.1], "start": 0.2, "end": 0.65},
    "ramp-for-ever": {"initial": 1.0, "slope": -0.5, "start": 0.3},
    "square": {"low": 0.1, "high": 0.9, "frequency": 7.0, "duty": 0.3, "start": 0.05, "pulses": 5},
    "square-long": {"frequency": 5.0, "duty": 1.0, "start": 0.1, "pulses": 3},
    "sine": {"offset": [1.0, 0.9], "amplitude": 0.05, "frequency": 5.0, "phase": 0.4},
    "twitch": {"amplitude": [1.0, 0.5], "time_to_peak": 0.06, "start": 0.1},
    "steps": {"times": [0.1, 0.3, 0.35], "values": [0.0, 1.0, 0.4]},
    "steps-hold": {"times": [0.1, 0.3, 0.35], "values": [0.0, 1.0, 0.4], "interpolation": "hold"},
    "table": {},
    "spatial": {"signal": {"plugin": "square", "frequency": 7.0, "duty": 0.3, "pulses": 5}, "end": 0.05, "edge": 0.02},
    "spatial-late": {"signal": {"plugin": "ramp", "final": 0.8, "end": 0.3}, "start": 0.02, "speed": 0.4, "delays": 3},
}
SITES = np.linspace(0.0, 0.1, 7)[:, None]


def signal(key: str, folder):
    table = {"plugin": key.split("-")[0], **EXAMPLES[key]}
    if key == "table":
        (folder / "measured.csv").write_text("t, left, right\n0.1,0,1\n# pause\n0.4,1,0.5\n\n0.7,0.25,0.5\n")
        table["file"] = "measured.csv"
    return build(registry(), "signal", table, folder=folder)


@pytest.mark.parametrize("key", EXAMPLES)
def test_contract(key, tmp_path):
    for check in signal_checks(signal(key, tmp_path).located(SITES)):
        check()


def test_every_registered_signal_has_an_example():
    ours = {item.name for item in registry() if item.family == "signal" and item.package == "myobridge"}
    assert {key.split("-")[0] for key in EXAMPLES} == ours


@settings(max_examples=60, deadline=None)
@given(
    frequency=st.floats(0.5, 40.0),
    duty=st.floats(0.01, 1.0),
    start=st.floats(-0.3, 0.5),
    pulses=st.integers(1, 20),
    interval=st.lists(st.floats(-0.5, 1.5), min_size=2, max_size=2, unique=True),
)
def test_mean_of_a_square_wave_is_the_share_of_its_pulses(frequency, duty, start, pulses, interval):
    square = build(
        registry(),
        "signal",
        {"plugin": "square", "frequency": frequency, "duty": duty, "start": start, "pulses": pulses},
    )
    a, b = sorted(interval)
    begins = start + np.arange(pulses) / frequency
    inside = np.clip(np.minimum(b, begins + duty / frequency) - np.maximum(a, begins), 0.0, None)
    assert square.mean(a, b) == pytest.approx(inside.sum() / (b - a), abs=1e-11 / (b - a) + 1e-11)


@settings(max_examples=100, deadline=None)
@given(
    times=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=8, unique=True).map(sorted),
    interpolation=st.sampled_from(["linear", "hold"]),
    cuts=st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3, unique=True).map(sorted),
    data=st.data(),
)
def test_means_add_up(times, interpolation, cuts, data):
    """The mean over a whole is the weighted mean over its parts."""
    values = data.draw(st.lists(st.floats(-2.0, 2.0), min_size=len(times), max_size=len(times)))
    steps = build(
        registry(), "signal", {"plugin": "steps", "times": times, "values": values, "interpolation": interpolation}
    )
    a, b, c = cuts
    parts = (b - a) * steps.mean(a, b) + (c - b) * steps.mean(b, c)
    assert (c - a) * steps.mean(a, c) == pytest.approx(parts, abs=1e-12)
    assert min(values) - 1e-12 <= steps.mean(a, c) <= max(values) + 1e-12
