"""CPU seconds of what a first run compiles: stretch, residual and tangent of one body of one material.

Prints the seconds of importing numba and of the kernels; the numbers themselves take next to none.
"""

from __future__ import annotations

from time import process_time

import numpy as np

from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.macro_solid.finite_element.supports import Support
from myobridge_plugins.material.mooney_rivlin import MooneyRivlin
from myobridge_plugins.mesh.block import Block


def main() -> None:
    solid = FiniteElement(
        mesh=Block(size=(1.0, 1.0, 1.0), cells=(2, 2, 2), shape="tetrahedron"),
        material=MooneyRivlin(),
        support=(Support(boundary="left"),),
        bulk_modulus=np.inf,
        threads=1,
    )
    motion = solid.rest_motion()
    started = process_time()
    import numba

    numba.njit(lambda x: x)
    imported = process_time()
    solid.stretch(motion.displacement, 0.0)
    solid.balance(motion, None, 0.0)
    solid.balance(motion, None, 0.0, tangent=True)
    print(imported - started, process_time() - imported)


if __name__ == "__main__":
    main()
