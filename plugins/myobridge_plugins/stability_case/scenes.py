"""Scenes that several cases share: the reference block of the thesis' tissue, held on the left."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["BLOCK", "FURTHER_INTEGRATORS", "RELEASE", "TRACTION_30", "TRACTION_50"]

# Nominal traction [Pa] that stretches the strictly incompressible block by 30 and by 50 %, mu (s - 1/s^3).
TRACTION_30, TRACTION_50 = 1.1345e5, 1.6166e5

BLOCK = """
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025], cells = [16, 4] }
material = { plugin = "mooney_rivlin", parameters = "thesis" }
"""

# In equilibrium under the traction until t = 0, free afterwards.
RELEASE = f"""
[scene]
name = "release"
effects = ["inertia", "incompressibility", "viscosity"]
duration = 0.2
step = 1e-3
start = "equilibrium"
{BLOCK}
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [{TRACTION_30}, 0.0]
scale = {{ plugin = "steps", times = [-1.0, 0.0], values = [1.0, 0.0], interpolation = "hold" }}
"""

FURTHER_INTEGRATORS: Mapping[str, Mapping[str, Any]] = {
    "generalised_alpha 0.8": {"integrator.plugin": "generalised_alpha", "integrator.rho_inf": 0.8},
    "half_explicit symplectic": {"integrator.plugin": "half_explicit", "integrator.sequence": "symplectic"},
}
"""Integrators with other parameters than their defaults."""
