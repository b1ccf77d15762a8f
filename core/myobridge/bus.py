r"""Coupling bus: stretch and its rate go down, tension, stiffness and rate sensitivity come up.

.. math:: x = s\,\Delta\lambda, \qquad T = p\,\rho_{sc}\,\tau, \qquad
          K = p\,\rho_{sc}\,\partial\tau/\partial\lambda, \qquad E = \sum_i V_i\,p\,\rho_{sc,i}\,e_i

`s` is the gear, `p` the isometric tension, :math:`\rho_{sc}` the sarcomere density, `V` the site volumes; tau and e are
what the model states in units of its isometric tension. The same factor scales tension and energy, so the power that
leaves the solid is the power that enters the population.

The bus owns the micro state and works on a trial copy: a step that fails changes nothing.
"""

from __future__ import annotations

from time import perf_counter

import attrs
import numpy as np

from myobridge.cache_lines import rows_on_lines
from myobridge.interfaces import ActivationKinetics, ActiveLaw, Array, CrossBridgeModel, Fluxes, Signal
from myobridge.stimulation import Stimulation
from myobridge.work import count

__all__ = ["BusState", "CouplingBus", "FluxTotals"]


@attrs.frozen(eq=False)
class BusState:
    """What a checkpoint keeps of the bus: population, stretch and activation state."""

    population: Array
    stretch: Array
    activation: Array
    last_activation: Array
    tension: Array
    stretch_rate: Array


@attrs.define(eq=False)
class FluxTotals:
    """Energy [J] that the population of all sites gained and lost during a step."""

    attached: float = 0.0
    detached: float = 0.0
    work: float = 0.0
    numerical: float = 0.0


class CouplingBus:
    """Joins one cross-bridge model to the sites of one solid.

    Parameters
    ----------
    model : CrossBridgeModel
    site_volumes : ndarray, shape (n_sites,)
        Reference volume of each site [m^3].
    stretch : ndarray, shape (n_sites,)
        Stretch at the start [-].
    activation : Signal, optional
        Stimulation in [0, 1]; full activation without.
    kinetics : ActivationKinetics, optional
        Stage between stimulation and activation (calcium).
    density : ndarray, shape (n_sites,), optional
        Sarcomere density [-]; 1 without.
    population : ndarray, shape (n_sites, m), optional
        Micro state at the start; the model's own without.
    """

    def __init__(
        self,
        model: CrossBridgeModel,
        site_volumes: Array,
        stretch: Array,
        *,
        activation: Signal | None = None,
        kinetics: ActivationKinetics | None = None,
        density: Array | None = None,
        population: Array | None = None,
    ) -> None:
        n_sites = site_volumes.size
        self.model = model
        self.n_sites = n_sites
        self.scale = np.full(n_sites, model.p_max) if density is None else model.p_max * density
        self._density = density
        self._volumes = site_volumes
        self._energy_scale = site_volumes * self.scale
        self._stimulation = Stimulation(n_sites, activation, kinetics)
        self._population = model.initial_state(n_sites) if population is None else population
        self._stretch = np.array(stretch, dtype=float)
        self._activation_state = self._stimulation.initial_state()
        self._r = self._stimulation.initial()
        self._spare = rows_on_lines(self._population.shape)
        self.stretch_rate = np.zeros(n_sites)
        self.inertance = self.active_law_at_rest().inertance
        self.seconds = 0.0
        self.tension = self.active_law_at_rest().evaluate(self._stretch, np.zeros(n_sites)).tension
        self.discard()

    # ------------------------------------------------------------------ step: begin, verbs, commit or discard

    def begin(self, time: float, dt: float) -> None:
        """Open a trial step from the committed state; nothing else touches that state before `commit`."""
        self._time = time
        self._dt = dt
        self.restart()

    def restart(self) -> None:
        """Back to the committed state, within the same step (a corrector's second pass)."""
        self._clock = self._time
        self._trial = self._population
        self._trial_stretch = self._stretch
        self._trial_activation = self._activation_state
        self.totals = FluxTotals()

    def react(self, dt: float) -> None:
        """Attach and detach for `dt` seconds, filaments held; the clock of the activation moves on."""
        started = perf_counter()
        r = self._mean_activation(dt)
        count("bin_steps", self._trial.size)
        self._trial, fluxes = self.model.react(self._trial, r, self._trial_stretch, dt, self._spare)
        self._book(fluxes)
        self.seconds += perf_counter() - started

    def active_law(self, elapsed: float) -> ActiveLaw:
        """Law of the frozen trial population [Pa], with the activation `elapsed` seconds after the step's beginning.

        A population carries its activation in its state; a model without state needs that of the time asked for.
        """
        law = self.model.active_law(self._trial, self._activation_after(elapsed), self._trial_stretch)
        return law.scaled(self.scale)

    def slide(self, stretch: Array, law: ActiveLaw | None = None) -> None:
        """Carry the population to `stretch`; what the scheme itself adds to the energy is booked as numerical.

        `law` is the law under which the solid moved, when it is at hand: its potential is the work done on the heads.
        """
        started = perf_counter()
        model = self.model
        displacement = model.gear * (stretch - self._trial_stretch)
        if model.has_energy:
            if law is None:
                law = self.active_law(self._clock - self._time)
            potential = law.potential(stretch)
            self._trial, gained = model.slide_and_gain(self._trial, displacement, self._spare)
            if potential is not None:
                work = float(np.dot(self._volumes, potential))
                self.totals.work += work
                self.totals.numerical += float(np.dot(self._energy_scale, gained)) - work
        else:
            self._trial = model.slide(self._trial, displacement, self._spare)
        self._trial_stretch = stretch
        self.seconds += perf_counter() - started

    def advance(self, stretch: Array, dt: float) -> None:
        """Carry and react along the whole path to `stretch` in `dt` seconds, from the trial state."""
        started = perf_counter()
        r = self._mean_activation(dt)
        count("bin_steps", self._trial.size)
        self._trial, fluxes = self.model.advance(self._trial, r, self._trial_stretch, stretch, dt, self._spare)
        self._book(fluxes)
        self._trial_stretch = stretch
        self.seconds += perf_counter() - started

    def law_after(self, stretch: Array, dt: float) -> ActiveLaw:
        """Law [Pa] of the population that `advance` to `stretch` would give, leaving the trial as it is."""
        started = perf_counter()
        r, _ = self._stimulation.mean(self._trial_activation, self._clock, self._clock + dt)
        count("bin_steps", self._trial.size)
        state, _ = self.model.advance(self._trial, r, self._trial_stretch, stretch, dt)
        law = self.model.active_law(state, self._activation_after(dt), stretch).scaled(self.scale)
        self.seconds += perf_counter() - started
        return law

    def record(self, law: ActiveLaw, stretch: Array, stretch_rate: Array, stretch_acceleration: Array | None) -> None:
        """Keep the tension of the mechanics stage [Pa]: it is the one in balance with the solid."""
        self.tension = law.evaluate(stretch, stretch_rate).tension
        if law.inertance is not None and stretch_acceleration is not None:
            self.tension = self.tension + law.inertance * stretch_acceleration
        self.stretch_rate = stretch_rate
        self.inertance = law.inertance

    def commit(self) -> None:
        """Make the trial the state."""
        if self._trial is self._spare:
            self._spare = self._population
        self._population = self._trial
        self._stretch = self._trial_stretch
        self._activation_state = self._trial_activation
        self._r = self._stimulation.reached(self._activation_state, self._time + self._dt, self._dt)

    def discard(self) -> None:
        """Forget the trial."""
        self._time = self._clock = 0.0
        self._dt = 0.0
        self._trial = self._population
        self._trial_stretch = self._stretch
        self._trial_activation = self._activation_state
        self.totals = FluxTotals()

    # ------------------------------------------------------------------ what can be asked

    @property
    def stretch(self) -> Array:
        """Committed stretch [-], shape (n_sites,)."""
        return self._stretch

    @property
    def trial_stretch(self) -> Array:
        """Stretch to which the trial population has been carried [-]."""
        return self._trial_stretch

    @property
    def population(self) -> Array:
        """Committed micro state, shape (n_sites, m); read only."""
        view = self._population.view()
        view.flags.writeable = False
        return view

    @property
    def activation(self) -> Array:
        """Activation r that last acted [-], shape (n_sites,)."""
        return self._r

    def fields(self) -> dict[str, Array]:
        """Tension [Pa], and activation and sarcomere density where the scene has them; each (n_sites,)."""
        found = {"tension": self.tension}
        if not self._stimulation.constant:
            found["activation"] = self._r
        return found if self._density is None else found | {"sarcomere_density": self._density}

    def moments(self) -> Array:
        """Moments Q0, Q1, Q2 of the committed population, shape (n_sites, 3)."""
        return self.model.moments(self._population)

    def energy(self) -> float:
        """Energy stored in the committed population [J]."""
        return float(np.dot(self._energy_scale, self.model.energy(self._population))) if self.model.has_energy else 0.0

    def active_law_at_rest(self) -> ActiveLaw:
        """Law of the committed population [Pa]."""
        return self.model.active_law(self._population, self._r, self._stretch).scaled(self.scale)

    def state(self) -> BusState:
        """Copy of all that a checkpoint needs."""
        return BusState(
            self._population.copy(),
            self._stretch.copy(),
            self._activation_state.copy(),
            self._r.copy(),
            self.tension.copy(),
            self.stretch_rate.copy(),
        )

    def restore(self, state: BusState) -> None:
        """Continue from a checkpoint."""
        self._population = rows_on_lines(state.population.shape)
        self._population[...] = state.population
        self._stretch = np.array(state.stretch)
        self._activation_state = np.array(state.activation)
        self._r = np.array(state.last_activation)
        self.tension = np.array(state.tension)
        self.stretch_rate = np.array(state.stretch_rate)
        self._spare = rows_on_lines(self._population.shape)
        self.inertance = self.active_law_at_rest().inertance
        self.discard()

    # ------------------------------------------------------------------ inside

    def _mean_activation(self, dt: float) -> Array:
        """Mean activation over the next `dt` seconds of the clock, which moves on."""
        end = self._clock + dt
        mean, self._trial_activation = self._stimulation.mean(self._trial_activation, self._clock, end)
        self._clock = end
        return mean

    def _activation_after(self, elapsed: float) -> Array:
        """Activation `elapsed` seconds after the beginning of the step."""
        return self._stimulation.at(self._activation_state, self._time, self._time + elapsed)

    def _book(self, fluxes: Fluxes) -> None:
        scale, totals = self._energy_scale, self.totals
        totals.attached += float(np.dot(scale, fluxes.attached))
        totals.detached += float(np.dot(scale, fluxes.detached))
        totals.work += float(np.dot(scale, fluxes.work))
        totals.numerical += float(np.dot(scale, fluxes.numerical))
