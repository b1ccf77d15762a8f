"""What a population at every quadrature point costs: its share of a macro step of 25 000 tetrahedra.

The share is that of the run's own table: seconds of the bus against all seconds of steps. Factors of the tangent are
kept over the whole run, so that the mechanics is as cheap as it gets. ``pytest -m benchmark -s`` prints the figures.
"""

from __future__ import annotations

import logging

import pytest

import myobridge as mb

STEPS = 4
SETTINGS = {
    "huxley": {"bins": 16, "low": -2.0, "high": 2.0, "start": "empty"},  # 64 cells a site
    "distributed_moment": {"start": "empty"},
    "prescribed": {},
}


def _scene(model: str, linear: str) -> mb.Scene:
    return mb.Scene(
        name=model,
        effects=["inertia", "cross_bridges", "incompressibility"],
        duration=1.0,
        step=1e-3,
        solid={
            "plugin": "finite_element",
            "mesh": {"plugin": "block", "size": [0.1, 0.025, 0.025], "cells": [41, 10, 10]},
            "material": {"plugin": "mooney_rivlin", "parameters": "thesis"},
            "support": [{"boundary": "left"}],
        },
        cross_bridges={"plugin": model, **SETTINGS[model]},
        integrator={
            "plugin": "energy_momentum",
            "newton": {"plugin": "simplified", "tolerance": 1e-8, "linear": linear},
        },
    )


def _share(model: str, linear: str) -> tuple[float, float, float]:
    """Share of the bus in the steps after the first, which compiles and factors; seconds a step of both."""
    simulation = mb.Plan.of(_scene(model, linear)).simulation()
    simulation.step()
    before = dict(simulation.seconds)
    for _ in range(STEPS):
        simulation.step()
    spent = {name: (value - before[name]) / STEPS for name, value in simulation.seconds.items()}
    assert simulation.control.halvings == 0
    assert simulation.bus is not None
    assert simulation.bus.tension.mean() > 0.0 or model == "prescribed"
    micro, mechanics = spent["cross_bridges"], spent["mechanics"]
    return micro / (micro + mechanics), micro, mechanics


@pytest.mark.benchmark
@pytest.mark.parametrize("linear", ["amg_gmres", "pardiso"])
def test_share_of_the_population(linear: str) -> None:
    """At most a fiftieth with the solver that is always there."""
    if linear == "pardiso":
        pytest.importorskip("pypardiso", reason="pypardiso is not installed")
    logging.getLogger("myobridge").setLevel(logging.WARNING)
    found = {model: _share(model, linear) for model in SETTINGS}
    for model, (share, micro, mechanics) in found.items():
        print(f"{linear}, {model}: {micro:.3f} s of {micro + mechanics:.2f} s a step, {100 * share:.2f} %")
    saved = sum(found["huxley"][1:]) / sum(found["distributed_moment"][1:])
    print(f"{linear}: distributed moments are {saved:.2f} times as fast as the full population")
    if linear == "amg_gmres":
        assert found["huxley"][0] <= 0.02
