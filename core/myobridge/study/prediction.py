r"""Prediction: time and memory of a run before it is begun, from unit costs of this machine.

.. math:: t_{step} = t_{mechanics} \frac{c(n)}{c(n_0)} + t_{micro}\,\frac{a + b V}{a + b V_0} + t_{rest}

with `n` the unknowns, `V` the values of the micro state, and `c` what the linear solver says of a system of that size
plus the assembly, which grows with the unknowns.
"""

from __future__ import annotations

import attrs

from myobridge.errors import MyobridgeError
from myobridge.interfaces import SystemSize
from myobridge.plan import Plan
from myobridge.study.stopwatch import Stopwatch
from myobridge.study.unit_costs import UnitCosts, keep, kept, measured_costs, peak_memory, shares, size_of_plan

__all__ = ["Prediction", "learn", "predicted"]

# Seconds an iteration: of Python around the numbers, and of assembly for each unknown. Only their ratio counts.
_ALWAYS, _ASSEMBLY = 2e-4, 3e-6
# Seconds of the micro step: of Python around it, and for each value.
_AROUND, _VALUE = 3e-5, 1e-9


@attrs.frozen
class Prediction:
    """What a run will take.

    Attributes
    ----------
    seconds : float
        In all, by the clock of a machine that is otherwise idle.
    a_step : float
        Of one step; of the whole path without time.
    steps : int
    memory : float
        Most memory that the process will have [bytes].
    """

    seconds: float
    a_step: float
    steps: int
    memory: float

    def words(self) -> str:
        """Time and memory in a few words."""
        each = f", {self.a_step:.2g} s a step" if self.steps > 1 else ""
        return f"about {_duration(self.seconds)}{each}; about {self.memory / 1e9:.2g} GB in all"


def predicted(plan: Plan, *, measure: bool = True) -> Prediction | None:
    """Prediction for a plan; None where no costs are known and none may be, or can be, measured."""
    costs = kept(plan)
    if costs is None and measure:
        try:
            costs = measured_costs(plan)
        except (MyobridgeError, ArithmeticError, ValueError):  # it fails coarse; it may not as it is
            return None
        keep(plan, costs)
    return None if costs is None else _scaled(plan, costs)


def learn(plan: Plan, watch: Stopwatch) -> None:
    """Keep the unit costs of a run that has been made: they are better than those of a coarse scene."""
    if watch.steps < 3:
        return
    unknowns, values = size_of_plan(plan)
    a_step, wall, cpu = watch.phases()
    known = kept(plan)
    keep(
        plan,
        UnitCosts(
            unknowns=unknowns,
            values=values,
            **shares(a_step, wall, cpu, watch.steps),
            setup=known.setup if known else watch.first,
            steps=watch.steps,
            memory=known.memory if known else 0.0,
        ),
    )


def _scaled(plan: Plan, costs: UnitCosts) -> Prediction:
    unknowns, values = size_of_plan(plan)
    larger = _solve(plan, unknowns) / _solve(plan, costs.unknowns)
    denser = (_AROUND + _VALUE * values) / (_AROUND + _VALUE * costs.values)
    a_step = costs.mechanics * larger + costs.micro * denser + costs.rest
    steps = 1 if plan.scene.static else max(round(plan.scene.duration / plan.scene.step), 1)
    # Factors grow faster than the unknowns; the population and the tables are counted as they are.
    grown = costs.memory * (max(unknowns, 1) / max(costs.unknowns, 1)) ** (4.0 / 3.0)
    memory = peak_memory() + (grown if unknowns > costs.unknowns else 0.0)
    memory += float(plan.sizes().get("population bytes", 0))
    return Prediction(costs.setup + steps * a_step, a_step, steps, memory)


def _solve(plan: Plan, unknowns: int) -> float:
    """Rough cost of an iteration with that many unknowns."""
    from myobridge.solvers.choice import choose

    cost = _ALWAYS + _ASSEMBLY * unknowns
    if unknowns > 120:
        motions = plan.parts["solid"].rigid_motions()
        space = 3 if motions is not None and motions.shape[1] > 3 else 2
        choice = choose(SystemSize(unknowns, space, structured=motions is not None))
        if choice.solver is not None:
            cost += choice.solver.seconds(SystemSize(unknowns, space, structured=motions is not None)) or 0.0
    return cost


def _duration(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
