r"""Order of convergence, fitted.

.. math:: e(h) \approx C h^p
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["fitted_order"]


def fitted_order(steps: Sequence[float], errors: Sequence[float]) -> float:
    """Exponent p of the least-squares line through log error against log step."""
    return float(np.polyfit(np.log(np.asarray(steps)), np.log(np.asarray(errors)), 1)[0])
