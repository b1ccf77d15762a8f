"""Large populations are stepped by several threads; the answer does not depend on their number."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge_plugins.cross_bridge import huxley_exact
from myobridge_plugins.cross_bridge.huxley import Huxley


def _moved(threads: int, monkeypatch: pytest.MonkeyPatch) -> tuple[np.ndarray, np.ndarray]:
    """State and all fluxes of some steps, from the same random numbers."""
    parts: list[int] = []
    shared_out = huxley_exact.shared_out

    def counting(count, first, last, loop) -> None:
        shared_out(count, first, last, lambda a, b: (parts.append(a), loop(a, b)))

    monkeypatch.setattr(huxley_exact, "available", lambda: threads)
    monkeypatch.setattr(huxley_exact, "shared_out", counting)
    model, generator, n = Huxley(bins=8, low=-2.0, high=3.0), np.random.default_rng(0), 4500
    state, stretch, activation = model.initial_state(n), np.ones(n), generator.uniform(size=n)
    found = []
    for _ in range(2):
        state, held = model.react(state, activation, stretch, 1e-3)
        state = model.slide(state, generator.normal(scale=0.1, size=n))
        state, moved = model.advance(state, activation, stretch, stretch + generator.normal(scale=1e-3, size=n), 1e-3)
        found += [np.stack(held), np.stack(moved)]
    monkeypatch.undo()
    assert len(set(parts)) == threads
    return state, np.stack(found)


def test_the_answer_does_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    one, three = _moved(1, monkeypatch), _moved(3, monkeypatch)
    np.testing.assert_array_equal(one[0], three[0])
    np.testing.assert_array_equal(one[1], three[1])
    assert np.abs(one[1]).max() > 1e-3
