"""Settings that all tests share, and the blocks of code in the documentation."""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from myobridge.interfaces import LinearSystem

# Deadlines are timings, and timings are benchmarks. Compiled kernels make the first example slow.
settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# The same examples each time: a change is judged by what it changes. New ones are looked for by hand, and found then.
settings.register_profile("ci", settings.get_profile("default"), derandomize=True, database=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

DOCS = Path(__file__).parents[1] / "docs"


class Block(NamedTuple):
    """A fenced block of a page: its language, text, the comment above it, and the file that its first line names."""

    language: str
    text: str
    comment: str
    line: int

    @property
    def file(self) -> str:
        """``# scene.toml`` as the first line makes the block the content of that file; empty without."""
        first = self.text.partition("\n")[0]
        named = re.fullmatch(r"# ([\w./-]+\.(?:toml|py|csv))", first)
        return named[1] if named else ""


def _blocks(page: Path) -> list[Block]:
    found: list[Block] = []
    comment, above, fence = "", "", ""
    inside: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        if fence:
            if line == "```":
                found.append(Block(fence, "\n".join(inside) + "\n", comment, number - len(inside)))
                fence, above = "", ""
            else:
                inside.append(line)
        elif line.startswith("```"):
            fence, inside = line[3:].strip() or "plain", []
            said = re.fullmatch(r"<!-- (.*) -->", above)
            comment = said[1] if said else ""
        elif line:
            above = line
    assert not fence, f"{page}: a block is not closed"
    return found


@pytest.fixture(scope="session", autouse=True)
def cache_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What runs cost on this machine is not learnt from tests; matplotlib keeps its list of fonts where it was."""
    with pytest.MonkeyPatch.context() as patch:
        fonts = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
        patch.setenv("MPLCONFIGDIR", os.environ.get("MPLCONFIGDIR") or str(fonts))
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def blocks() -> Callable[[str], list[Block]]:
    """Fenced blocks of a page of the documentation, named relative to ``docs``."""
    return lambda page: _blocks(DOCS / page)


def _elastic_block(
    dimension: int, cells: int, *, modulus: float = 1e4, bulk_modulus: float = np.inf, fibre: float = 0.0
) -> LinearSystem:
    """P2-P1 block of sides 75 x 25 (x 25) mm, x = 0 held: linear elasticity with fibres along x, incompressible.

    `modulus` is the shear modulus [Pa], `fibre` the modulus along x [Pa]; the pressure is in units of modulus / cell.
    """
    import scipy.sparse as sparse
    import skfem
    from skfem.helpers import ddot, div, sym_grad

    side = np.linspace(0.0, 0.025, cells + 1)
    axes = [np.linspace(0.0, 0.075, 3 * cells + 1), *[side] * (dimension - 1)]
    if dimension == 2:
        mesh, quadratic, linear = skfem.MeshTri.init_tensor(*axes), skfem.ElementTriP2(), skfem.ElementTriP1()
    else:
        mesh, quadratic, linear = skfem.MeshTet.init_tensor(*axes), skfem.ElementTetP2(), skfem.ElementTetP1()
    basis = skfem.Basis(mesh, skfem.ElementVector(quadratic), intorder=3)
    pressures = basis.with_element(linear)
    stiffness = skfem.BilinearForm(
        lambda u, v, w: 2.0 * modulus * ddot(sym_grad(u), sym_grad(v)) + fibre * u.grad[0, 0] * v.grad[0, 0]
    ).assemble(basis)
    gradient = skfem.BilinearForm(lambda u, q, w: div(u) * q).assemble(basis, pressures)
    volumes = skfem.BilinearForm(lambda p, q, w: p * q).assemble(pressures)
    free = np.setdiff1d(np.arange(basis.N), basis.get_dofs(lambda x: x[0] < 1e-12).all())
    component = np.empty(basis.N, dtype=int)
    for numbers in (basis.nodal_dofs, basis.edge_dofs if dimension == 3 else basis.facet_dofs):
        component[numbers] = np.arange(dimension)[:, None]
    component, places = component[free], basis.doflocs[:, free]
    motions = [(component == axis).astype(float) for axis in range(dimension)]
    for i, j in [(0, 1), (1, 2), (2, 0)][: 1 if dimension == 2 else 3]:
        motions.append(np.where(component == i, -places[j], 0.0) + np.where(component == j, places[i], 0.0))
    unit = modulus * cells / 0.025
    coupling = sparse.csr_array(unit * gradient[:, free])
    return LinearSystem(
        sparse.csr_array(stiffness[free][:, free]),
        coupling,
        coupling,
        None if np.isinf(bulk_modulus) else sparse.csr_array(unit**2 / bulk_modulus * volumes),
        np.column_stack(motions),
    )


@pytest.fixture(scope="session")
def elastic_block() -> Callable[..., LinearSystem]:
    """Tangent of an incompressible block: dimension, cells along its short sides, moduli."""
    return functools.cache(_elastic_block)
