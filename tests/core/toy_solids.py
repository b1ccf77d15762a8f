"""Small solids with known equilibria, written against the interface alone."""

from __future__ import annotations

import attrs
import numpy as np

import myobridge as mb
from myobridge.interfaces import Balance


@attrs.frozen(eq=False)
class TwoBars(mb.MacroSolid):
    """Two bars (E A = L = 1) at an angle; the apex, at height z, is pushed down. One site, of volume 2.

    P(z) = 2 z (1 / l - 1) is largest where l = cos^(2/3): P_lim = 2 (1 - cos^(2/3))^(3/2).
    """

    push: float
    angle: float = float(np.radians(20.0))

    @property
    def limit(self):
        return 2.0 * (1.0 - np.cos(self.angle) ** (2.0 / 3.0)) ** 1.5

    n_unknowns = 1
    n_sites = 1
    site_volumes = np.array([2.0])

    def _length(self, displacement):
        height = np.sin(self.angle) + displacement
        return height, np.hypot(height, np.cos(self.angle))

    def rest_motion(self):
        return mb.Motion(np.zeros(1), np.zeros(1))

    def stretch(self, displacement, time):
        return self._length(displacement)[1]

    def stretch_rate(self, displacement, velocity, time):
        height, length = self._length(displacement)
        return height / length * velocity

    def balance(self, motion, law, time, *, rate=True, tangent=False):
        height, length = self._length(motion.displacement)
        stress, slope = length - 1.0, np.ones(1)
        if law is not None:
            answer = law.evaluate(length, np.zeros(1))
            stress, slope = stress + answer.tension, slope + answer.stiffness
        force = 2.0 * stress * height / length + self.push
        across = stress * (1.0 / length - height**2 / length**3)
        stiffness = np.diag(2.0 * (slope * (height / length) ** 2 + across))
        return Balance(force, stiffness if tangent else None, magnitude=1.0)

    def external_force(self, displacement, time):
        return np.array([-self.push])


@attrs.frozen(eq=False)
class Block(mb.MacroSolid):
    """Block (1 + x) by (1 + y) that keeps its area, with a fibre along x and a follower load across.

    c = (1 + x)(1 + y) - 1 - p / kappa = 0; energy (k_x x^2 + k_y y^2) / 2; the load on y is F (1 + x): it presses on
    the length. One site of volume 1.
    """

    load: float = 0.0
    stiffness: tuple[float, float] = (1.0, 1.0)
    bulk_modulus: float = float("inf")
    multiplier_scale: float = 7.0
    n_unknowns = 2
    n_sites = 1
    site_volumes = np.ones(1)

    def rest_motion(self):
        return mb.Motion(np.zeros(2), np.zeros(2), np.zeros(1))

    def stretch(self, displacement, time):
        return 1.0 + displacement[:1]

    def stretch_rate(self, displacement, velocity, time):
        return velocity[:1]

    def admissible(self, displacement, time=0.0):
        return bool(np.all(displacement > -1.0))

    def balance(self, motion, law, time, *, rate=True, tangent=False):
        (x, y), p = motion.displacement, motion.multiplier[0]
        tension, slope = 0.0, 0.0
        if law is not None:
            answer = law.evaluate(np.array([1.0 + x]), np.zeros(1))
            tension, slope = answer.tension[0], answer.stiffness[0]
        gradient = np.array([[1.0 + y, 1.0 + x]])
        k_x, k_y = self.stiffness
        force = np.array([k_x * x + tension, k_y * y]) + p * gradient[0] - self.external_force(motion.displacement, 0.0)
        stiffness = np.array([[k_x + slope, p], [p, k_y]]) + self.external_stiffness(motion.displacement, 0.0)
        return Balance(
            force,
            stiffness if tangent else None,
            None,
            np.array([(1.0 + x) * (1.0 + y) - 1.0 - p / self.bulk_modulus]),
            gradient,
            np.array([[1.0 / self.bulk_modulus]]),
            magnitude=1.0,
            symmetric=self.load == 0.0,
            constraint_magnitude=1.0,
        )

    def external_force(self, displacement, time):
        return np.array([0.0, self.load * (1.0 + displacement[0])])

    def external_stiffness(self, displacement, time):
        return np.array([[0.0, 0.0], [-self.load, 0.0]])

    def elastic_energy(self, displacement):
        return 0.5 * float(np.dot(self.stiffness, displacement**2))

    def softened(self, bulk_modulus):
        return attrs.evolve(self, bulk_modulus=min(bulk_modulus, self.bulk_modulus))
