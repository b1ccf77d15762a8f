"""Checks of form: declarations, shapes, purity, batches."""

from __future__ import annotations

import pickle

import attrs
import numpy as np

from myobridge.interfaces import Array, CrossBridgeModel, Fluxes
from myobridge.parameters import declared
from myobridge.testing.cross_bridge_samples import sample

__all__ = [
    "check_batch_is_single",
    "check_declaration",
    "check_frozen_and_pickles",
    "check_inputs_unchanged",
    "check_out",
    "check_shapes",
    "check_site_order",
]


def check_declaration(model: CrossBridgeModel) -> None:
    """The class says in a line what it is, declares every public parameter, and has a positive tension and gear."""
    cls = type(model)
    assert cls.summary, f"{cls.__name__} has no summary"
    assert model.p_max > 0.0, f"p_max is {model.p_max}; expected a positive tension [Pa]"
    assert model.gear > 0.0, f"gear is {model.gear}; expected a positive ratio [-]"
    known = declared(cls)
    for field in attrs.fields(cls):
        if field.init and not field.name.startswith("_"):
            assert field.name in known, f"parameter '{field.name}' is not declared (myobridge.parameters)"
            assert known[field.name].doc, f"parameter '{field.name}' has no doc"


def check_frozen_and_pickles(model: CrossBridgeModel) -> None:
    """Parameters cannot be changed, and a copy through pickle is equal and behaves the same."""
    name = next(iter(declared(type(model))))
    try:
        setattr(model, name, getattr(model, name))
    except attrs.exceptions.FrozenInstanceError:
        pass
    else:
        raise AssertionError(f"'{name}' can be set; use attrs.frozen")
    model.initial_state(1)  # fills caches, which must not stand in the way
    copy = pickle.loads(pickle.dumps(model))
    assert copy == model
    assert np.array_equal(copy.initial_state(3), model.initial_state(3))


def check_shapes(model: CrossBridgeModel) -> None:
    """Everything is float64 of the shape the contract names."""
    for n_sites in (1, 4):
        start = model.initial_state(n_sites)
        _is(start, (n_sites, start.shape[1]), "initial_state")
        assert start.flags.c_contiguous, "initial_state is not C-contiguous"
        state, activation, stretch, displacement, dt = sample(model, n_sites)
        for name, (new, fluxes) in {
            "react": model.react(state, activation, stretch, dt),
            "advance": model.advance(state, activation, stretch, stretch + displacement / model.gear, dt),
        }.items():
            _is(new, start.shape, name)
            for part, flux in zip(Fluxes._fields, fluxes, strict=True):
                _is(flux, (n_sites,), f"{name}: {part}")
        _is(model.slide(state, displacement), start.shape, "slide")
        _is(model.moments(state), (n_sites, 3), "moments")
        _is(model.energy(state), (n_sites,), "energy")
        law = model.active_law(state, activation, stretch)
        value = law.evaluate(stretch, np.zeros(n_sites))
        _is(value.tension, (n_sites,), "tension")
        _is(value.stiffness, (n_sites,), "stiffness")
        if value.rate_sensitivity is not None:
            _is(value.rate_sensitivity, (n_sites,), "rate_sensitivity")
        if law.inertance is not None:
            _is(law.inertance, (n_sites,), "inertance")
        picture = model.density(state)
        if picture is not None:
            assert picture[0].shape == picture[1].shape
            assert picture[0].shape[0] == n_sites


def check_inputs_unchanged(model: CrossBridgeModel) -> None:
    """No method writes to what it is given."""
    state, activation, stretch, displacement, dt = sample(model, 3)
    given = (state, activation, stretch, displacement)
    copies = [item.copy() for item in given]
    model.react(state, activation, stretch, dt)
    model.slide(state, displacement)
    model.advance(state, activation, stretch, stretch + displacement / model.gear, dt)
    model.active_law(state, activation, stretch).scaled(stretch).evaluate(stretch, displacement)
    model.moments(state)[...] = 0.0
    model.energy(state)
    model.density(state)
    for name, item, copy in zip(("state", "activation", "stretch", "displacement"), given, copies, strict=True):
        assert np.array_equal(item, copy), f"{name} was changed"


def check_out(model: CrossBridgeModel) -> None:
    """With `out` the result is written there, and it may be the state itself."""
    state, activation, stretch, displacement, dt = sample(model, 3)
    end = stretch + displacement / model.gear

    def react(item: Array, out: Array | None) -> Array:
        return model.react(item, activation, stretch, dt, out)[0]

    def slide(item: Array, out: Array | None) -> Array:
        return model.slide(item, displacement, out)

    def advance(item: Array, out: Array | None) -> Array:
        return model.advance(item, activation, stretch, end, dt, out)[0]

    for name, method in {"react": react, "slide": slide, "advance": advance}.items():
        expected = method(state, None)
        out = np.full_like(state, np.nan)
        assert method(state, out) is out, f"{name} does not return out"
        assert np.array_equal(out, expected), f"{name} with out differs"
        own = state.copy()
        assert method(own, own) is own, f"{name} does not return out"
        assert np.array_equal(own, expected), f"{name} in place differs"


def check_batch_is_single(model: CrossBridgeModel) -> None:
    """A site does in a batch what it does alone."""
    state, activation, stretch, displacement, dt = sample(model, 5)
    together = _everything(model, state, activation, stretch, displacement, dt)
    for i in range(5):
        one = slice(i, i + 1)
        alone = _everything(
            model, np.ascontiguousarray(state[one]), activation[one], stretch[one], displacement[one], dt
        )
        for name, batch in together.items():
            _close(alone[name], batch[one], f"{name} of site {i}, alone and in the batch")


def check_site_order(model: CrossBridgeModel) -> None:
    """Sites do not see each other: reordering them reorders the answers."""
    state, activation, stretch, displacement, dt = sample(model, 6)
    order = np.array([3, 0, 5, 1, 4, 2])
    straight = _everything(model, state, activation, stretch, displacement, dt)
    mixed = _everything(model, state[order], activation[order], stretch[order], displacement[order], dt)
    for name, values in straight.items():
        _close(mixed[name], values[order], f"{name} after reordering the sites")


def _everything(
    model: CrossBridgeModel, state: Array, activation: Array, stretch: Array, displacement: Array, dt: float
) -> dict[str, Array]:
    end = stretch + displacement / model.gear
    reacted, fluxes = model.react(state, activation, stretch, dt)
    moved, along = model.advance(state, activation, stretch, end, dt)
    value = model.active_law(state, activation, stretch).evaluate(end, displacement)
    found = {"react": reacted, "slide": model.slide(state, displacement), "advance": moved}
    found |= {f"react: {name}": item for name, item in zip(Fluxes._fields, fluxes, strict=True)}
    found |= {f"advance: {name}": item for name, item in zip(Fluxes._fields, along, strict=True)}
    return found | {"tension": value.tension, "stiffness": value.stiffness, "moments": model.moments(state)}


def _is(item: Array, shape: tuple[int, ...], name: str) -> None:
    assert isinstance(item, np.ndarray), f"{name} is a {type(item).__name__}; expected an ndarray"
    assert item.dtype == np.float64, f"{name} has dtype {item.dtype}; expected float64"
    assert item.shape == shape, f"{name} has shape {item.shape}; expected {shape}"
    assert np.all(np.isfinite(item)), f"{name} is not finite"


def _close(found: Array, expected: Array, what: str) -> None:
    # Vector and scalar code may round differently; more than that is a site that sees its neighbour.
    error = float(np.max(np.abs(found - expected), initial=0.0))
    scale = 1.0 + float(np.max(np.abs(expected), initial=0.0))
    assert error <= 1e-12 * scale, f"{what} differ by {error}"
