"""Power that leaves the solid is power that enters the population, for every model that stores energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import myobridge as mb
from myobridge.bus import CouplingBus
from myobridge_plugins.cross_bridge.discrete import Discrete
from myobridge_plugins.cross_bridge.distributed_moment import DistributedMoment
from myobridge_plugins.cross_bridge.huxley import Huxley
from myobridge_plugins.cross_bridge.liouville import Liouville
from myobridge_plugins.signal.constant import Constant

MODELS = {
    "huxley": Huxley(),
    "huxley upwind": Huxley(discretisation="upwind"),
    "huxley euler": Huxley(discretisation="moving_frame_euler"),
    "distributed_moment": DistributedMoment(),
    "distributed_moment euler": DistributedMoment(method="explicit_euler"),
    "liouville": Liouville(),
    "discrete": Discrete(),
}


def test_every_registered_model_with_energy_is_here():
    with_energy = {item.name for item in mb.registry() if item.family == "cross_bridge" and item.cls.has_energy}
    assert with_energy <= {name.split()[0] for name in MODELS}


@pytest.mark.parametrize("name", MODELS)
@given(
    p_max=st.floats(1e3, 1e6),
    density=st.floats(0.01, 1.0),
    volume=st.floats(1e-9, 1e-3),
    activation=st.floats(0.0, 1.0),
    react=st.floats(0.0, 4e-3),
    changes=st.lists(st.floats(-0.01, 0.01), min_size=3, max_size=3),
)
def test_power_through_the_bus_is_balanced(name, p_max, density, volume, activation, react, changes):
    import attrs

    model = attrs.evolve(MODELS[name], p_max=p_max)
    n_sites = len(changes)
    stretch = np.linspace(0.95, 1.05, n_sites)
    bus = CouplingBus(
        model,
        np.full(n_sites, volume),
        stretch,
        activation=Constant(level=activation),
        density=np.full(n_sites, density),
    )
    bus.begin(0.0, 1e-3)
    bus.react(react)
    bus.commit()
    before = bus.energy()
    tension = bus.active_law_at_rest().evaluate(stretch, np.zeros(n_sites))

    bus.begin(react, 1e-3)
    moved = stretch + np.array(changes)
    bus.slide(moved)
    bus.commit()

    # Work of the affine law, from its tension and stiffness alone.
    work = float(np.sum(volume * (tension.tension + 0.5 * tension.stiffness * changes) * changes))
    gained = bus.energy() - before - bus.totals.numerical
    scale = max(abs(before), abs(bus.energy()), np.sum(volume * np.abs(tension.tension * changes)), 1e-300)
    assert abs(gained - work) <= 1e-12 * scale
    if model.promises.exact_slide:
        assert abs(bus.totals.numerical) <= 1e-12 * scale


@pytest.mark.parametrize("name", MODELS)
def test_stiffness_is_the_derivative_of_tension(name):
    """Closed form against a difference, through gear, isometric scale and density."""
    model = MODELS[name]
    stretch = np.array([1.0])
    bus = CouplingBus(model, np.array([1e-6]), stretch, density=np.array([0.3]))
    law = bus.active_law_at_rest()
    zero = np.zeros(1)
    step = 1e-4 if name == "huxley upwind" else 1e-6
    tensions = []
    for change in (-step, step):
        bus.begin(0.0, 1e-3)
        bus.slide(stretch + change)
        bus.commit()
        tensions.append(bus.active_law_at_rest().evaluate(stretch + change, zero).tension[0])
        bus.begin(0.0, 1e-3)
        bus.slide(stretch)
        bus.commit()
    slope = (tensions[1] - tensions[0]) / (2.0 * step)
    assert slope == pytest.approx(law.evaluate(stretch, zero).stiffness[0], rel=1e-6)


def test_isometric_tension_is_p_max_times_density():
    """Each model's own isometric state at r = 1 pulls with p_max."""
    for name in ("huxley", "distributed_moment", "liouville", "discrete"):
        bus = CouplingBus(MODELS[name], np.array([1e-6]), np.ones(1), density=np.array([0.5]))
        assert bus.tension[0] == pytest.approx(0.5 * MODELS[name].p_max, rel=2e-3), name
