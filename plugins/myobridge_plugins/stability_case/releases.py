"""Releases from a static stretch: what shakes out a method that only looks stable."""

from __future__ import annotations

from typing import ClassVar, final

from myobridge.hookspecs import hookimpl
from myobridge.interfaces import Expectation, Limit, StabilityCase
from myobridge_plugins.stability_case.scenes import FURTHER_INTEGRATORS, RELEASE, TRACTION_50


@final
class Release30(StabilityCase):
    """Strictly incompressible, damped."""

    summary = "30 % release of a strictly incompressible block, eta = 10 Pa s, 200 steps of 1 ms"
    scene = RELEASE
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-10))
    vary = ("integrator",)
    methods = FURTHER_INTEGRATORS
    expected: ClassVar = {
        "half_explicit*": Expectation("fails", "explicit, and the step is 15 times beyond its limit"),
    }


@final
class ReleaseStiffVolume(StabilityCase):
    """Nearly incompressible, without damping: the pressure rings where its mean over the step acts."""

    summary = "30 % release at kappa = 1e9 Pa without viscosity, 0.1 s"
    scene = RELEASE.replace(', "viscosity"', "").replace("duration = 0.2", "duration = 0.1")
    variants: ClassVar = {"": {"solid.bulk_modulus": 1e9}}
    limits = (
        Limit("halvings", 2),
        Limit("energy_growth", 1e-6),
        Limit("energy_loss", 1e-2),
        Limit("pressure_noise", 1e4),
    )
    vary = ("integrator",)
    methods: ClassVar = {
        **FURTHER_INTEGRATORS,
        "energy_momentum averaged": {
            "integrator.plugin": "energy_momentum",
            "integrator.multiplier": "averaged",
        },
    }
    expected: ClassVar = {
        "energy_momentum averaged": Expectation("fails", "the mean of a stiff pressure rings"),
        "backward_euler": Expectation("fails", "order 1, loses energy"),
        "generalised_alpha 0.8": Expectation("fails", "too little damping for a constraint"),
        "half_explicit*": Expectation("fails", "explicit, and far beyond its limit"),
    }


@final
class Release50(StabilityCase):
    """A violent release, at every step."""

    summary = "50 % release of a strictly incompressible block, eta = 30 Pa s, steps from 4 ms to 0.25 ms"
    scene = RELEASE.replace("duration = 0.2", "duration = 0.1")
    variants: ClassVar = {
        f"{dt:g}": {
            "scene.step": dt,
            "load[0].traction": [TRACTION_50, 0.0],
            "solid.viscosity": 30.0,
        }
        for dt in (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
    }
    limits = (Limit("halvings", 2), Limit("constraint_error", 1e-10))
    vary = ("integrator",)
    methods = FURTHER_INTEGRATORS
    default_only = ("0.004", "0.0005", "0.00025")
    bisect = False


@final
class BulkModulus(StabilityCase):
    """One formulation for every bulk modulus."""

    summary = "20 % release at bulk moduli from 1e4 to 1e12 Pa, eta = 10 Pa s, 50 steps of 1 ms"
    scene = RELEASE.replace("duration = 0.2", "duration = 0.05")
    variants: ClassVar = {
        f"1e{n}": {
            "solid.bulk_modulus": 10.0**n,
            "solid.mesh.cells": [8, 2],
            "load[0].traction": [8.3e4, 0.0],
        }
        for n in (4, 5, 6, 7, 8, 10, 12)
    }
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-9))
    vary = ("integrator",)
    default_only = ("1e4", "1e5", "1e7", "1e8", "1e12")
    bisect = False


@final
class FinerMesh(StabilityCase):
    """The step does not care about the mesh."""

    summary = "30 % release on meshes of which each is twice as fine, at the same step of 1 ms, 20 steps"
    scene = RELEASE.replace("duration = 0.2", "duration = 0.02")
    variants: ClassVar = {f"{n}x{n // 4}": {"solid.mesh.cells": [n, n // 4]} for n in (8, 16, 32, 64)}
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-10))
    vary = ("integrator",)
    only_full = ("64x16",)
    default_only = ("8x2", "16x4")
    bisect = False


@final
class Slivers(StabilityCase):
    """Cells of aspect 50."""

    summary = "30 % release of a mesh of slivers, each 50 times longer than high, 50 steps of 1 ms"
    scene = RELEASE.replace("duration = 0.2", "duration = 0.05")
    variants: ClassVar = {
        "along": {"solid.mesh.cells": [2, 25]},
        "across": {"solid.mesh.size": [0.1, 0.1], "solid.mesh.cells": [50, 1]},
    }
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-9))
    vary = ("integrator",)
    bisect = False


@final
class LightBody(StabilityCase):
    """As the density vanishes a step becomes one of statics."""

    summary = "30 % release as the density goes to 0, eta = 10 Pa s, 50 steps of 1 ms"
    scene = RELEASE.replace("duration = 0.2", "duration = 0.05")
    variants: ClassVar = {
        f"{density:g}": {"solid.density": density, "solid.mesh.cells": [8, 2]} for density in (1.1e1, 1.1e-3, 1.1e-9)
    }
    limits = (Limit("halvings", 2), Limit("energy_growth", 1e-6), Limit("constraint_error", 1e-10))
    vary = ("integrator",)
    default_only = ("11", "0.0011")
    bisect = False


@hookimpl
def myobridge_stability_cases() -> dict[str, type[StabilityCase]]:
    return {
        "release_30": Release30,
        "release_stiff_volume": ReleaseStiffVolume,
        "release_50": Release50,
        "bulk_modulus": BulkModulus,
        "finer_mesh": FinerMesh,
        "slivers": Slivers,
        "light_body": LightBody,
    }
