"""Every registered cross-bridge model, in every variant, against the contract that plugin authors test with."""

from __future__ import annotations

import pytest

from myobridge.registry import registry
from myobridge.testing import cross_bridge_checks, variants

MODELS = {
    key: model for name in registry().names("cross_bridge") for key, model in variants("cross_bridge", name).items()
}
CHECKS = [
    pytest.param(check, id=f"{key}-{check.__name__.removeprefix('check_')}")
    for key, model in MODELS.items()
    for check in cross_bridge_checks(model)
]


@pytest.mark.parametrize("check", CHECKS)
def test_contract(check):
    check()


def test_something_is_registered():
    assert {"prescribed", "hill", "distributed_moment", "liouville", "discrete"} <= set(
        registry().names("cross_bridge")
    )
