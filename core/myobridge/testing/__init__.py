"""Contract checks for plugin authors: the same ones that the built-in plugins must pass.

One parametrised test holds a model to everything it promises::

    import pytest
    from myobridge.testing import cross_bridge_checks

    @pytest.mark.parametrize("check", cross_bridge_checks(MyModel()), ids=lambda check: check.__name__)
    def test_contract(check):
        check()

Hypothesis strategies are in `myobridge.testing.strategies`; nothing else here needs Hypothesis.
"""

from myobridge.testing.cross_bridge import cross_bridge_checks
from myobridge.testing.fitted_order import fitted_order
from myobridge.testing.material import material_checks
from myobridge.testing.mesh import fibre_checks, mesh_checks
from myobridge.testing.signal import signal_checks
from myobridge.testing.variants import variants

__all__ = [
    "cross_bridge_checks",
    "fibre_checks",
    "fitted_order",
    "material_checks",
    "mesh_checks",
    "signal_checks",
    "variants",
]
