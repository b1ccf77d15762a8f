"""Large populations are stepped by several threads; the answer does not depend on their number."""

from __future__ import annotations

import numpy as np
import pytest

from myobridge import threads
from myobridge.interfaces import CrossBridgeModel
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.huxley import Huxley

MODELS = (
    Huxley(bins=8, low=-2.0, high=3.0),
    DistributedMoment(),
    DistributedMoment(method="explicit_euler"),
)


def _moved(model: CrossBridgeModel, n_threads: int, monkeypatch: pytest.MonkeyPatch) -> tuple[np.ndarray, np.ndarray]:
    """State and all fluxes of some steps, from the same random numbers."""
    parts: list[int] = []
    shared_out = threads.shared_out

    def counting(count, first, last, loop) -> None:
        shared_out(count, first, last, lambda a, b: (parts.append(a), loop(a, b)))

    monkeypatch.setattr(threads, "available", lambda: n_threads)
    monkeypatch.setattr(threads, "shared_out", counting)
    generator, n = np.random.default_rng(0), 4500
    state, stretch, activation = model.initial_state(n), np.ones(n), generator.uniform(size=n)
    found = []
    for _ in range(2):
        state, held = model.react(state, activation, stretch, 1e-3)
        state = model.slide(state, generator.normal(scale=0.1, size=n))
        state, moved = model.advance(state, activation, stretch, stretch + generator.normal(scale=1e-3, size=n), 1e-3)
        found += [np.stack(held), np.stack(moved)]
    monkeypatch.undo()
    assert (len(set(parts)) > 2 * n_threads) == (n_threads > 1)
    return state, np.stack(found)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_the_answer_does_not_depend_on_threads(model: CrossBridgeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    one, three = _moved(model, 1, monkeypatch), _moved(model, 3, monkeypatch)
    np.testing.assert_array_equal(one[0], three[0])
    np.testing.assert_array_equal(one[1], three[1])
    assert np.abs(one[1]).max() > 1e-3
