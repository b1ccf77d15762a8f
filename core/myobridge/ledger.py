r"""Ledger: what energy went in, what came out, what is stored, and what does not add up.

.. math:: \Delta(E_{kin} + E_{el} + E_{xb}) =
          E_{attached} - E_{detached} + W_{active} + W_{external} - W_{viscous} + E_{numerical} + \text{residual}

Everything in joule. `active_work` is the work of tension that derives from no stored energy; `numerical` is what the
discretisation of the population adds by itself. The residual is not booked but found: it measures the method.
"""

from __future__ import annotations

import attrs

__all__ = ["FLOWS", "STORED", "Ledger"]

STORED = ("kinetic", "elastic", "cross_bridge")
FLOWS = ("attached", "detached", "active_work", "external", "viscous", "numerical")


@attrs.define(eq=False)
class Ledger:
    """Running energy balance of a simulation.

    Attributes
    ----------
    kinetic, elastic, cross_bridge : float
        Energy stored now [J].
    attached, detached, active_work, external, viscous, numerical : float
        Sums since the start [J], each positive in the sense of its name.
    residual : float
        Imbalance of the last step relative to the largest energy so far [-].
    drift : float
        Imbalance since the start, in the same measure [-].
    largest : float
        Largest energy so far [J]: the stores together, or, where nothing is stored, the largest flow of a step.
    """

    kinetic: float
    elastic: float
    cross_bridge: float
    attached: float = 0.0
    detached: float = 0.0
    active_work: float = 0.0
    external: float = 0.0
    viscous: float = 0.0
    numerical: float = 0.0
    residual: float = 0.0
    drift: float = 0.0
    largest: float = 0.0
    largest_flow: float = 0.0
    imbalance: float = 0.0

    def __attrs_post_init__(self) -> None:
        self.largest = max(self.largest, abs(self.total))

    @property
    def total(self) -> float:
        """Energy stored now [J]."""
        return self.kinetic + self.elastic + self.cross_bridge

    def close(
        self,
        *,
        kinetic: float,
        elastic: float,
        cross_bridge: float,
        attached: float = 0.0,
        detached: float = 0.0,
        active_work: float = 0.0,
        external: float = 0.0,
        viscous: float = 0.0,
        numerical: float = 0.0,
    ) -> None:
        """Book one step: the stores at its end and the flows during it [J]; finds the residual."""
        before = self.total
        self.kinetic, self.elastic, self.cross_bridge = kinetic, elastic, cross_bridge
        self.attached += attached
        self.detached += detached
        self.active_work += active_work
        self.external += external
        self.viscous += viscous
        self.numerical += numerical
        now = self.total
        self.largest = max(self.largest, abs(now))
        if self.largest == 0.0:  # nothing is stored: measure by what flows
            flows = (attached, detached, active_work, external, viscous, numerical)
            self.largest_flow = max(self.largest_flow, *(abs(amount) for amount in flows))
        step = now - before - (attached - detached + active_work + external - viscous + numerical)
        self.imbalance += step
        scale = self.largest or self.largest_flow or 1.0
        self.residual = step / scale
        self.drift = self.imbalance / scale

    def entries(self) -> dict[str, float]:
        """All entries by name, stores first."""
        return {name: getattr(self, name) for name in (*STORED, *FLOWS, "residual", "drift")}

    def as_dict(self) -> dict[str, float]:
        """Everything that a checkpoint needs."""
        return attrs.asdict(self)
