r"""Motion as it is reported: its multiplier belongs to the instant, not to a step.

.. math:: M a + f(u, v, t) + B^T p = 0, \qquad B a + \gamma = 0

What an integrator calls the multiplier acts over a whole step, and rings from one to the next where the constraint is
stiff. The reported one is that with which forces and accelerations are in balance at the instant. A constraint that
yields little counts as one that does not.
"""

from __future__ import annotations

import attrs

from myobridge.instant import just_before
from myobridge.interfaces import Motion
from myobridge.simulation import Simulation
from myobridge.solvers import SingularMatrix, UnsolvedSystem, accelerated

__all__ = ["reported_motion"]


def reported_motion(simulation: Simulation) -> Motion:
    """Motion with the multiplier of the instant, for solids with inertia and a stiff constraint; else as it is.

    It is as it is too where the constraint has not full rank, so that there is none of the instant. At t = 0 a jump of
    the loads has happened, later it is still to come.
    """
    solid, motion, time = simulation.solid, simulation.motion, simulation.time
    if not motion.multiplier.size or not simulation.integrator.inertia or not solid.stiff_constraint:
        return motion
    law, dt = None if simulation.bus is None else simulation.bus.active_law_at_rest(), simulation.control.dt
    at = time if simulation.steps == 0 else just_before(time, dt)
    try:
        return attrs.evolve(motion, multiplier=accelerated(solid, law, motion, at, strict=True, dt=dt).multiplier)
    except (SingularMatrix, UnsolvedSystem):
        return motion
