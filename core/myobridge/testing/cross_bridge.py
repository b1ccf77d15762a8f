"""Contract checks of a cross-bridge model, chosen by what the model promises."""

from __future__ import annotations

import functools
from collections.abc import Callable

from myobridge.interfaces import CrossBridgeModel
from myobridge.testing.cross_bridge_energy import (
    check_exact_slide,
    check_fluxes_of_advance,
    check_fluxes_of_react,
    check_gain_of_slide,
    check_law_potential,
)
from myobridge.testing.cross_bridge_form import (
    check_batch_is_single,
    check_declaration,
    check_frozen_and_pickles,
    check_inputs_unchanged,
    check_out,
    check_shapes,
    check_site_order,
)
from myobridge.testing.cross_bridge_law import (
    check_law_derivatives,
    check_law_scales,
    check_statics_refused,
    check_steady_law,
)
from myobridge.testing.cross_bridge_promises import (
    check_bounds,
    check_conserves_heads,
    check_no_step,
    check_order,
    check_realizable,
    check_zero_activation,
)

__all__ = ["cross_bridge_checks"]

Check = Callable[[CrossBridgeModel], None]


def cross_bridge_checks(model: CrossBridgeModel) -> list[Callable[[], None]]:
    """Checks that hold `model` to its contract and to each of its promises; call each, or parametrise a test by them.

    A check raises AssertionError with what was found and what is expected. Every check carries its name in
    ``__name__`` and what it holds the model to in ``__doc__``.
    """
    promises = model.promises
    wanted: list[tuple[Check, bool]] = [
        (check_declaration, True),
        (check_frozen_and_pickles, True),
        (check_shapes, True),
        (check_inputs_unchanged, True),
        (check_out, True),
        (check_batch_is_single, True),
        (check_site_order, True),
        (check_no_step, True),
        (check_law_derivatives, True),
        (check_law_scales, True),
        (check_steady_law, model.has_statics),
        (check_statics_refused, not model.has_statics),
        (check_law_potential, model.has_energy),
        (check_exact_slide, model.has_energy and promises.exact_slide),
        (check_gain_of_slide, model.has_energy),
        (check_fluxes_of_react, True),
        (check_fluxes_of_advance, True),
        (check_zero_activation, True),
        (check_bounds, promises.bounds),
        (check_conserves_heads, promises.conserves_heads),
        (check_realizable, promises.realizable),
        (check_order, promises.order > 0),
    ]
    return [_bound(check, model) for check, applies in wanted if applies]


def _bound(check: Check, model: CrossBridgeModel) -> Callable[[], None]:
    bound = functools.partial(check, model)
    return functools.update_wrapper(bound, check)
