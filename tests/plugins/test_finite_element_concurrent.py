"""Two bodies in two Python threads, which share the pool of threads that assemble."""

from __future__ import annotations

import threading

import numpy as np

from myobridge.interfaces import Motion
from myobridge_plugins.macro_solid.finite_element.finite_element import FiniteElement
from myobridge_plugins.material.neo_hooke import NeoHooke
from myobridge_plugins.mesh.block import Block


def test_bodies_in_two_threads_answer_as_alone() -> None:
    mesh = Block(size=(1.0, 1.0, 1.0), cells=(6, 6, 5), shape="tetrahedron")  # large enough for several threads
    bodies = [FiniteElement(mesh=mesh, material=NeoHooke(), bulk_modulus=np.inf, threads=2) for _ in range(2)]
    rest = bodies[0].rest_motion()
    displacement = 1e-3 * np.random.default_rng(0).standard_normal(rest.displacement.size)
    motion = Motion(displacement, rest.velocity, rest.multiplier)
    alone = bodies[0].balance(motion, None, 0.0, tangent=True)
    found: dict[int, list[bool]] = {0: [], 1: []}

    def work(number: int) -> None:
        for _ in range(5):
            here = bodies[number].balance(motion, None, 0.0, tangent=True)
            same = np.array_equal(here.force, alone.force)
            assert here.stiffness is not None
            assert alone.stiffness is not None
            found[number].append(same and np.array_equal(here.stiffness.data, alone.stiffness.data))

    threads = [threading.Thread(target=work, args=(number,)) for number in found]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {0: [True] * 5, 1: [True] * 5}
