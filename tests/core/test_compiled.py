"""Compiled functions of a material: cached on disk, compiled late, called through a pointer."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from myobridge.material_points import MaterialPoints
from myobridge.registry import registry

MATERIALS = ("mooney_rivlin", "transversely_isotropic", "guccione", "holzapfel_ogden")


def test_the_second_process_compiles_nothing() -> None:
    gradient = np.diag([1.1, 0.95, 1.0])[None]
    for name in MATERIALS:
        points = MaterialPoints(registry().find("material", name).cls())
        points.energy(gradient), points.stress(gradient), points.tangent(gradient)
    program = """
import sys
from numba.core.ccallback import CFunc
made = []
compile_one = CFunc.compile
def watched(self):
    compile_one(self)
    made.append(self)
CFunc.compile = watched
from myobridge.registry import registry
for name in sys.argv[1:]:
    for function in registry().find("material", name).cls().functions():
        function.pointer
print(len(made), sum(one.cache_hits for one in made))
"""
    command = [sys.executable, "-c", program, *MATERIALS]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ended.stdout.split() == ["12", "12"]


@pytest.mark.parametrize("family", ["material", "load"])
def test_plugins_are_listed_without_loading_their_kernels(family: str) -> None:
    program = f"""
import sys
from myobridge.registry import registry
assert registry().names({family!r})
print([name for name in sys.modules if name.endswith("_kernels") and ".{family}." in name or "lane_" in name])
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
