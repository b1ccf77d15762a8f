"""Contract checks of a signal."""

from __future__ import annotations

import functools
import pickle
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from myobridge.interfaces import Signal

__all__ = ["signal_checks"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)


def signal_checks(signal: Signal, horizon: float = 1.0) -> list[Callable[[], None]]:
    """Checks that hold `signal` to its contract on ``0 <= t <= horizon`` [s]; call each."""
    checks = (
        check_shapes,
        check_jumps,
        check_mean_is_the_integral,
        check_mean_of_no_time,
        check_rate,
        check_pickles,
    )
    named = []
    for check in checks:
        bound = functools.partial(check, signal, horizon)
        functools.update_wrapper(bound, check)
        named.append(bound)
    return named


def _cuts(signal: Signal, start: float, end: float, pieces: int = 40) -> list[float]:
    inner = [time for time in signal.jumps() if start < time < end]
    return sorted({*np.linspace(start, end, pieces + 1).tolist(), *inner})


def check_shapes(signal: Signal, horizon: float) -> None:
    """value, mean and rate have one shape, () or (n_sites,), at all times."""
    shape = np.shape(signal.value(0.0))
    assert len(shape) <= 1, f"value has shape {shape}; expected () or (n_sites,)"
    for time in np.linspace(-0.1 * horizon, horizon, 37):
        for what in (signal.value(time), signal.mean(time, time + 0.1 * horizon), signal.rate(time)):
            assert np.shape(what) == shape, f"shape {np.shape(what)} at t = {time}, but {shape} at t = 0"
            assert np.all(np.isfinite(what)), f"not finite at t = {time}"


def check_jumps(signal: Signal, horizon: float) -> None:
    """The jumps increase, and the value at a jump is the one after it."""
    jumps = signal.jumps()
    assert list(jumps) == sorted(set(jumps)), f"jumps do not increase: {jumps}"
    scale = 1.0 + np.max(np.abs(signal.value(0.5 * horizon)))
    for time in jumps:
        after = signal.value(np.nextafter(time, np.inf))
        assert np.allclose(signal.value(time), after, rtol=0, atol=1e-9 * scale), (
            f"value at {time} is not the one after"
        )


def check_mean_is_the_integral(signal: Signal, horizon: float) -> None:
    """The mean over an interval is the quadrature of the value over it, cut at the jumps."""
    generator = np.random.default_rng(0)
    for start, end in np.sort(generator.uniform(-0.2 * horizon, 1.2 * horizon, (25, 2)), axis=1):
        total, size = 0.0, 0.0
        cuts = _cuts(signal, start, end)
        for left, right in pairwise(cuts):
            for node, weight in zip(_NODES, _WEIGHTS, strict=True):
                value = signal.value(0.5 * (left + right) + 0.5 * (right - left) * node)
                total = total + 0.5 * (right - left) * weight * value
                size = max(size, float(np.max(np.abs(value))))
        error = np.max(np.abs(signal.mean(start, end) - total / (end - start)))
        assert error <= 1e-11 * (1.0 + size), f"mean over [{start}, {end}] is off by {error}"


def check_mean_of_no_time(signal: Signal, horizon: float) -> None:
    """The mean over no time, and over next to none, is the value."""
    jumps = np.array([*signal.jumps(), np.inf])
    for time in np.linspace(0.0, horizon, 23):
        value = signal.value(time)
        assert np.array_equal(signal.mean(time, time), value)
        gap = 1e-12 * horizon
        if np.min(np.abs(jumps - time)) > gap:
            assert np.allclose(signal.mean(time, time + gap), value, rtol=1e-8, atol=1e-8), f"t = {time}"


def check_rate(signal: Signal, horizon: float) -> None:
    """The rate is the derivative of the value, away from the jumps."""
    jumps = np.array([*signal.jumps(), np.inf])
    for time in np.random.default_rng(1).uniform(0.0, horizon, 40):
        step = 1e-4 * horizon
        if np.min(np.abs(jumps - time)) < 2.0 * step:
            continue
        errors = []
        for h in (step, 0.1 * step, 0.01 * step):
            difference = (signal.value(time + h) - signal.value(time - h)) / (2.0 * h)
            errors.append(float(np.max(np.abs(difference - signal.rate(time)))))
        scale = 1.0 + float(np.max(np.abs(signal.rate(time))))
        assert min(errors) <= 1e-5 * scale, f"rate at {time} is off by {min(errors)}"


def check_pickles(signal: Signal, horizon: float) -> None:
    """A copy through pickle gives the same values."""
    copy = pickle.loads(pickle.dumps(signal))
    assert np.array_equal(copy.value(0.3 * horizon), signal.value(0.3 * horizon))
    assert copy == signal
