"""Statics: full tension in one step, buckling, snap-through, every bulk modulus."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase

_BLOCK = """
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025, 0.025], cells = [6, 2, 2] }
material = { plugin = "mooney_rivlin", parameters = "thesis" }
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [0.0, 0.0, -1e4]
[cross_bridges]
plugin = "prescribed"
p_max = 87.6e3
"""


@final
class FullTension(StabilityCase):
    """Tension of 1.2 and a load across, at once, in a step without inertia."""

    summary = "tension 1.2 p_max and 10 kPa across the end of a strictly incompressible block, in one step of statics"
    scene = f"""
[scene]
name = "full_tension"
effects = ["incompressibility", "cross_bridges"]
duration = 1e-3
step = 1e-3
{_BLOCK}
"""
    limits = (Limit("halvings", 0), Limit("iterations", 15), Limit("constraint_error", 1e-10))
    vary = ("coupling", "solid.material.form")
    expected: ClassVar = {"printed": Expectation("fails", "the printed law has no equilibrium beyond a tension of .93")}
    bisect = False


@final
class FullTensionPath(StabilityCase):
    """The same as a path of equilibria, whose stability is counted."""

    summary = "the same along a path of one step, whose equilibria must be stable"
    scene = f"""
[scene]
name = "full_tension_path"
effects = ["incompressibility", "cross_bridges"]
[continuation]
plugin = "natural"
of = "tension_and_load"
step = 1.0
{_BLOCK}
"""
    limits = (Limit("negative_eigenvalues", 0),)
    vary = ("continuation", "solid.material.form", "cross_bridges")
    expected: ClassVar = {"printed": Expectation("fails", "the printed law has no equilibrium beyond a tension of .93")}


@final
class StaticBulkModulus(StabilityCase):
    """One formulation for every bulk modulus, without time."""

    summary = "half tension and 2 kPa across the end, at bulk moduli from 1e4 Pa to infinity"
    scene = """
[scene]
name = "static_bulk_modulus"
effects = ["incompressibility", "cross_bridges"]
[continuation]
plugin = "natural"
of = "tension_and_load"
step = 1.0
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [0.1, 0.025], cells = [16, 4] }
material = { plugin = "mooney_rivlin", parameters = "thesis" }
[[support]]
boundary = "left"
[[load]]
plugin = "traction"
boundary = "right"
traction = [0.0, -2000.0]
[cross_bridges]
plugin = "prescribed"
p_max = 36.5e3
"""
    variants: ClassVar = {
        name: {"solid.bulk_modulus": float(name)} for name in ("1e4", "1e5", "1e6", "1e8", "1e10", "1e12", "inf")
    }
    limits = (Limit("negative_eigenvalues", 0),)
    vary = ("continuation", "solid.material.form")
    default_only = ("1e5", "1e8", "1e1?")


@final
class Column(StabilityCase):
    """A slender column under twice its critical load."""

    summary = "a column of L/H = 10 under twice its critical load, bowed by a thousandth of its length"
    scene = """
[scene]
name = "column"
effects = ["incompressibility"]
[continuation]
plugin = "arclength"
of = "load"
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [1.0, 0.1], cells = [10, 1], bow = 1e-3, shape = "quadrilateral" }
material = { plugin = "neo_hooke", shear_modulus = 1e4 }
[[support]]
boundary = "left"
[[load]]
plugin = "force"
boundary = "right"
# Euler, clamped and free: pi^2 E' I / (4 L^2) with E' = 4 mu in plane strain, twice.
force = [-16.449340668482262, 0.0]
"""
    limits = (Limit("negative_eigenvalues", 0),)
    vary = ("continuation",)
    expected: ClassVar = {
        "natural": Expectation("fails", "steps over the bend lead on along the straight branch, which is unstable"),
        "two_parameter": Expectation("fails", "as natural"),
    }


@final
class ShallowArch(StabilityCase):
    """Snap-through."""

    summary = (
        "a shallow arch (span 1, thickness 0.04, rise 0.08), loaded on top: both limit points, converged in the mesh"
    )
    scene = """
[scene]
name = "shallow_arch"
effects = ["incompressibility"]
[continuation]
plugin = "arclength"
of = "load"
largest = 0.08
[solid]
plugin = "finite_element"
mesh = { plugin = "block", size = [1.0, 0.04], cells = [16, 1], bow = 0.08, shape = "quadrilateral" }
material = { plugin = "neo_hooke", shear_modulus = 1e4 }
[[support]]
boundary = "left"
[[support]]
boundary = "right"
[[load]]
plugin = "traction"
boundary = "top"
traction = [0.0, -10.0]
"""
    reference: ClassVar = {"solid.mesh.cells": [32, 2]}
    limits = (Limit("limit_points", at_least=2, at_most=2), Limit("limit_level_error", 0.02))
    vary = ("continuation",)
    expected: ClassVar = {
        "natural": Expectation("fails", "there is no equilibrium at a higher load beyond the limit point"),
        "two_parameter": Expectation("fails", "as natural"),
    }


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {
        "full_tension": FullTension,
        "full_tension_path": FullTensionPath,
        "static_bulk_modulus": StaticBulkModulus,
        "column": Column,
        "shallow_arch": ShallowArch,
    }
