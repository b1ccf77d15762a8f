"""Every example scene runs, and each is asserted on one number that its protocol is known for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import myobridge as mb
from myobridge_plugins.cross_bridge.rates import Rates

EXAMPLES = Path(__file__).parents[2] / "examples"
RATES = Rates()
GEAR = 1.1e-6 / 15.6e-9
P_MAX = 73e3


def isometric(result: mb.Result) -> None:
    """A population that starts empty reaches its steady tension."""
    assert result["tension"][-1, 0] == pytest.approx(P_MAX, rel=0.02)
    assert result["tension"][0, 0] == 0.0


def isotonic(result: mb.Result) -> None:
    """It shortens at the speed at which Huxley's curve gives half the isometric force, less what the spring takes."""
    late = result["time"] > 0.07
    speed = np.polyfit(result["time"][late], result["stretch"][late, 0], 1)[0] * GEAR
    force = result["tension"][late, 0].mean() / P_MAX
    assert speed < -5.0
    assert RATES.steady_moments(speed)[1] / RATES.isometric_moments()[1] == pytest.approx(force, rel=0.02)


def ramp(result: mb.Result) -> None:
    """Lengthening at 14.1 reaches a second: at the end of the ramp, the tension of the exact solution."""
    from myobridge_plugins.cross_bridge.exact_solution import exact_moments

    times = np.array([0.05, 0.15])
    exact = exact_moments(RATES, times, np.array([0.0, 0.02 * GEAR]))[-1, 1]
    at = np.argmin(np.abs(result["time"] - 0.15))
    assert result["Q1"][at, 0] == pytest.approx(exact, rel=2e-3)


def quick_release(result: mb.Result) -> None:
    """The tension falls by stiffness times release: s p_max Q0/Q1 times 0.6 %, a little less in the course of 1 ms."""
    drop = (result["tension"][0, 0] - result["tension"].min()) / P_MAX
    assert drop == pytest.approx(2.0 * GEAR * 0.006, rel=0.1)
    assert result["tension"][-1, 0] > 0.95 * P_MAX


def force_velocity(result: mb.Result) -> None:
    """Every fibre ends on Huxley's curve; averaged over the last 20 ms, within 1e-3 of the isometric force."""
    last = result["time"] > 0.18
    slopes = (result["stretch"][-1] - result["stretch"][0]) / result["time"][-1]
    steady = np.array([RATES.steady_moments(GEAR * slope)[1] for slope in slopes]) / RATES.isometric_moments()[1]
    found = result["tension"][last].mean(axis=0) / P_MAX
    shortening = slopes <= 0.0
    assert np.abs(found - steady)[shortening].max() <= 1e-3
    # Lengthening is slower to settle: heads are dragged along for 0.2 s and more.
    assert np.abs(found - steady)[~shortening].max() <= 0.02 * steady.max()


def length_tension(result: mb.Result) -> None:
    """The plateau of Gordon, Huxley and Julian between 2.0 and 2.25 um, and zero beyond 3.65 um (stretch 1.66)."""
    stretch, tension = result["stretch"][-1], result["tension"][-1] / P_MAX
    plateau = (stretch >= 2.0 / 2.2) & (stretch <= 2.25 / 2.2)
    assert tension[plateau] == pytest.approx(1.0, abs=0.02)
    assert tension[stretch > 3.65 / 2.2] == pytest.approx(0.0, abs=1e-12)
    half = np.interp(0.5, tension[stretch > 1.1][::-1], stretch[stretch > 1.1][::-1])
    assert half * 2.2 == pytest.approx(2.25 + 0.5 * (3.65 - 2.25), rel=0.01)


def twitch(result: mb.Result) -> None:
    """Activation peaks at the end of the 10 ms stimulus, tension long after; both come back."""
    time = result["time"]
    activation_peak = time[np.argmax(result["activation"][:, 0])]
    tension_peak = time[np.argmax(result["tension"][:, 0])]
    assert activation_peak == pytest.approx(0.03, abs=1.1e-3)
    assert 0.06 < tension_peak < 0.14
    assert 0.2 * P_MAX < result["tension"].max() < 0.6 * P_MAX
    assert result["tension"][-1, 0] < 0.3 * result["tension"].max()


CHECKS: dict[str, Callable[[mb.Result], None]] = {
    check.__name__: check
    for check in (isometric, isotonic, ramp, quick_release, force_velocity, length_tension, twitch)
}


def test_every_example_is_asserted():
    """Protocols here, muscles with a shape and the thesis' scenes in tests of their own."""
    scenes = {path.stem for path in EXAMPLES.glob("*.toml")}
    muscles = {name for name in scenes if "finite_element" in (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")}
    assert {name for name in scenes - muscles if not name.startswith("thesis_")} == set(CHECKS)
    here = Path(__file__).parent
    run_there = "".join((here / f"test_{name}.py").read_text(encoding="utf-8") for name in ("muscles", "motion"))
    assert {name for name in muscles if f'run("{name}"' not in run_there} == set()


@pytest.mark.parametrize("name", CHECKS)
def test_protocol(name):
    result = mb.run(EXAMPLES / f"{name}.toml")
    CHECKS[name](result)
    assert np.abs(result["energy/residual"]).max() <= 1e-12
