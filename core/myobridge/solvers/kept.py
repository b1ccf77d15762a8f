"""Tangents that outlive the step that factored them: arrays in a memory, their factors beside it.

A memory is a mapping from names to arrays, so that a checkpoint holds the matrix itself; factors are worked out from
it. Who goes on after a checkpoint factors the very same matrix, and so takes the very same steps as a run that was not
interrupted.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from typing import Any

import numpy as np

from myobridge.interfaces import Array, Factorisation, KeptTangent, LinearSystem, MacroSolid, Matrix, Memory

__all__ = ["recalled", "remembered"]

_PREFIX = "kept/"
_PARTS = ("stiffness", "transposed_gradient", "gradient", "compliance")
# Factors of the matrices that are in some memory, by the identity of the array that stands for each.
_FACTORS: dict[int, tuple[weakref.ref[Any], Factorisation]] = {}


def remembered(memory: Memory, kept: KeptTangent | None) -> Memory:
    """The memory with this tangent in place of an earlier one; without any where it is None."""
    rest = {name: array for name, array in memory.items() if not name.startswith(_PREFIX)}
    if kept is None:
        return rest
    if kept.arrays is None:
        arrays = _arrays(kept.system)
        kept = KeptTangent(kept.system, kept.factorisation, kept.work, arrays)
    assert kept.arrays is not None
    if kept.factorisation is not None:
        _keep(kept.arrays[_PREFIX + "mark"], kept.factorisation)
    return rest | dict(kept.arrays) | {_PREFIX + "work": kept.work}


def recalled(memory: Memory, solid: MacroSolid) -> KeptTangent | None:
    """The tangent that a memory holds; its factorisation is None where it has to be worked out anew."""
    mark = memory.get(_PREFIX + "mark")
    if mark is None:
        return None
    arrays = {name: array for name, array in memory.items() if name.startswith(_PREFIX) and name != _PREFIX + "work"}
    parts = {name: _matrix(arrays, name) for name in _PARTS}
    if parts["gradient"] is None:  # the same, kept once
        parts["gradient"] = parts["transposed_gradient"]
    system = LinearSystem(**parts, rigid_motions=solid.rigid_motions(), symmetric=bool(mark[0]))
    known = _FACTORS.get(id(mark))
    factors = known[1] if known is not None and known[0]() is mark else None
    return KeptTangent(system, factors, memory[_PREFIX + "work"], arrays)


def _keep(mark: Array, factors: Factorisation) -> None:
    key = id(mark)
    if key not in _FACTORS or _FACTORS[key][0]() is not mark:
        _FACTORS[key] = (weakref.ref(mark, lambda _: _FACTORS.pop(key, None)), factors)


def _arrays(system: LinearSystem) -> Mapping[str, Array]:
    """Matrices of a system as arrays; `mark` says whether it is symmetric, and stands for them all."""
    import scipy.sparse as sparse

    found: dict[str, Any] = {_PREFIX + "mark": np.array([float(system.symmetric)])}
    for name in _PARTS:
        matrix = getattr(system, name)
        if name == "gradient" and matrix is system.transposed_gradient:
            continue
        if isinstance(matrix, np.ndarray):
            found[f"{_PREFIX}{name}/dense"] = matrix
        elif matrix is not None:
            rows = sparse.csr_array(matrix)
            found[f"{_PREFIX}{name}/data"] = rows.data
            found[f"{_PREFIX}{name}/indices"] = rows.indices
            found[f"{_PREFIX}{name}/indptr"] = rows.indptr
            found[f"{_PREFIX}{name}/shape"] = np.array(rows.shape)
    return found


def _matrix(arrays: Mapping[str, Any], name: str) -> Matrix | None:
    import scipy.sparse as sparse

    dense = arrays.get(f"{_PREFIX}{name}/dense")
    if dense is not None:
        return dense
    data = arrays.get(f"{_PREFIX}{name}/data")
    if data is None:
        return None
    rows = (data, arrays[f"{_PREFIX}{name}/indices"], arrays[f"{_PREFIX}{name}/indptr"])
    return sparse.csr_array(rows, shape=tuple(int(size) for size in arrays[f"{_PREFIX}{name}/shape"]))
