"""Signals: closed forms and the errors they raise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from myobridge.errors import ParameterError
from myobridge_plugins.signal.ramp import Ramp
from myobridge_plugins.signal.sine import Sine
from myobridge_plugins.signal.square import Square
from myobridge_plugins.signal.steps import Steps
from myobridge_plugins.signal.table import Table
from myobridge_plugins.signal.twitch import Twitch


def test_ramp_reaches_its_end_exactly_and_has_the_mean_of_a_trapezium():
    ramp = Ramp(initial=0.1, final=(0.3, 0.7), start=0.2, end=0.5)
    assert ramp.value(0.5).tolist() == [0.3, 0.7]
    assert ramp.jumps() == (0.2, 0.5)
    # Half of [0, 0.4] at 0.1, then up to two thirds of the way: mean of the second half 0.1 + (1/3) (final - 0.1).
    assert ramp.mean(0.0, 0.4) == pytest.approx([0.1 + 0.2 / 6.0, 0.1 + 0.6 / 6.0], rel=1e-14)


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({}, "final"),
        ({"final": 1.0, "slope": 1.0}, "final"),
        ({"final": 1.0}, "end"),
        ({"slope": 1.0, "end": 0.0}, "end"),
    ],
)
def test_ramp_says_what_is_missing(given, key):
    with pytest.raises(ParameterError) as caught:
        Ramp(**given)
    assert caught.value.key == key


def test_square_has_its_value_after_each_jump():
    square = Square(frequency=10.0, duty=0.25, pulses=2, start=1.0, low=-1.0, high=2.0)
    assert square.jumps() == pytest.approx((1.0, 1.025, 1.1, 1.125), abs=1e-15)
    assert [float(square.value(time)) for time in square.jumps()] == [2.0, -1.0, 2.0, -1.0]
    assert square.mean(1.0, 1.1) == pytest.approx(0.25 * 2.0 - 0.75, rel=1e-12)


def test_sine_averages_to_its_offset_over_whole_periods():
    sine = Sine(offset=1.0, amplitude=0.05, frequency=5.0, phase=0.3)
    assert sine.mean(0.07, 0.67) == pytest.approx(1.0, abs=1e-15)
    assert sine.mean(0.0, 0.1) == pytest.approx(1.0 + 0.05 * 2.0 * math.cos(0.3) / math.pi, rel=1e-14)


def test_twitch_peaks_at_its_amplitude_and_integrates_to_e_tau():
    twitch = Twitch(amplitude=0.8, time_to_peak=0.05, start=0.1)
    assert twitch.value(0.15) == pytest.approx(0.8, rel=1e-15)
    assert twitch.rate(0.15) == pytest.approx(0.0, abs=1e-12)
    assert 5.0 * twitch.mean(0.0, 5.0) == pytest.approx(0.8 * math.e * 0.05, rel=1e-13)
    assert twitch.mean(0.1, 0.1 + 1e-9) == pytest.approx(0.8 * math.e * 0.5e-9 / 0.05, rel=1e-6)


def test_steps_hold_or_join():
    times, values = (0.0, 1.0, 2.0), (0.0, 2.0, 4.0)
    assert Steps(times=times, values=values).value(1.5) == 3.0
    assert Steps(times=times, values=values, interpolation="hold").value(1.5) == 2.0
    assert Steps(times=times, values=values, interpolation="hold").mean(0.5, 2.0) == pytest.approx(2.0 / 1.5)


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"times": [0.0, 0.0], "values": [1.0, 2.0]}, "times[1]"),
        ({"times": [0.0, 1.0], "values": [1.0]}, "values"),
        ({"times": 0.0, "values": [1.0]}, "times"),
    ],
)
def test_steps_refuse_what_is_no_function(given, key):
    with pytest.raises(ParameterError) as caught:
        Steps(**given)
    assert caught.value.key == key


def test_table_reads_columns_as_sites(tmp_path):
    (tmp_path / "a.csv").write_text("time,left,right\n0,0,1\n2,1,3\n")
    table = Table(file=str(tmp_path / "a.csv"))
    assert np.array_equal(table.value(0.5), [0.25, 1.5])
    assert np.array_equal(table.value(9.0), [1.0, 3.0])
    assert np.allclose(table.mean(1.0, 3.0), [0.875, 2.75], rtol=1e-15)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("t,r\n0,0\n1,full\n", ["line 3", "column 2", "'full'"]),
        ("# made by hand\n\n0,0\n1,0.5\n1,0.7\n", ["line 5", "times must increase"]),
        ("0,0\n1,0.5,0.7\n", ["line 2", "expected 2"]),
        ("0\n1\n", ["line 1", "at least one value"]),
        ("t,r\n", ["no line of numbers"]),
        ("0,nan\n", ["line 1", "column 2"]),
    ],
)
def test_table_names_the_line_that_is_wrong(tmp_path, content, words):
    path = tmp_path / "broken.csv"
    path.write_text(content)
    with pytest.raises(ParameterError) as caught:
        Table(file=str(path))
    for word in words:
        assert word in str(caught.value)


def test_missing_table_names_what_lies_beside(tmp_path):
    (tmp_path / "twitch.csv").write_text("0,0\n1,1\n")
    with pytest.raises(ParameterError, match=r"'.*twich\.csv' does not exist\. Beside it: twitch\.csv"):
        Table(file=str(tmp_path / "twich.csv"))
