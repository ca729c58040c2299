"""Online estimates of the hidden parameters: a particle filter over simulators (Liu and West 2001)."""

from __future__ import annotations

import numpy as np

from trundle.experiments.arena.simulator import ANGLE, Simulator
from trundle.experiments.arena.world import FRICTION_PX_PER_S2, MASS, OFFSET_PX, Hidden, draw
from trundle.experiments.sampling import Floats

__all__ = ["Estimator"]

PARTICLES = 100
SHRINKAGE = 0.95
"""Of particles to their mean when they are resampled; jitter restores the variance."""
ERROR_SCALE_PX = 1.0
LEVER_PX = 50.0
"""Converts errors of the angle to px."""
LOW = np.array([*np.log([MASS[0], FRICTION_PX_PER_S2[0]]), -OFFSET_PX, -OFFSET_PX])
HIGH = np.array([*np.log([MASS[1], FRICTION_PX_PER_S2[1]]), OFFSET_PX, OFFSET_PX])


def to_coordinates(hidden: Hidden) -> Floats:
    """Return log mass, log friction and offsets (4,)."""
    return np.array([np.log(hidden.mass), np.log(hidden.friction), hidden.offset_x, hidden.offset_y])


def from_coordinates(values: Floats) -> Hidden:
    """Return the parameters of coordinates (4,)."""
    mass, friction, x, y = values.tolist()
    return Hidden(float(np.exp(mass)), float(np.exp(friction)), x, y)


class Estimator:
    """Weights simulators, whose parameters are drawn as the hidden ones, by their errors of one action ahead.

    Parameters
    ----------
    physics : {"original", "sliding"}
    state : array of float, shape (10,)
        At the start of the episode.
    seed : int
        Of the particles.
    """

    def __init__(self, physics: str, state: Floats, seed: int) -> None:
        self.rng, self.physics = np.random.default_rng(seed), physics
        self.points = np.stack([to_coordinates(draw(self.rng)) for _ in range(PARTICLES)])
        self.particles = [Simulator(from_coordinates(one), physics, state.copy()) for one in self.points]
        self.log_weights = np.zeros(PARTICLES)

    @property
    def weights(self) -> Floats:
        """The weights of the particles, of sum 1."""
        raw = np.exp(self.log_weights - self.log_weights.max())
        scaled: Floats = raw / raw.sum()
        return scaled

    @property
    def estimate(self) -> Hidden:
        """The weighted mean."""
        return from_coordinates(self.weights @ self.points)

    def track(self, action: Floats, observation: Floats) -> None:
        """Update the weights with one action of the episode.

        The likelihood is that of Cauchy's distribution, because contacts make single errors large.
        """
        errors = np.stack([particle.track(action, observation) for particle in self.particles])
        errors[:, ANGLE] *= LEVER_PX
        self.log_weights -= np.log1p((errors / ERROR_SCALE_PX) ** 2).sum(1)
        if 1.0 / np.sum(self.weights**2) < PARTICLES / 2:
            self.resample()

    def resample(self) -> None:
        """Draw particles by weight, and move them so that mean and variance stay the same."""
        weights = self.weights
        mean = weights @ self.points
        spread = np.sqrt(weights @ (self.points - mean) ** 2)
        drawn = self.rng.choice(PARTICLES, PARTICLES, p=weights)
        noise = self.rng.normal(size=self.points.shape) * spread * np.sqrt(1 - SHRINKAGE**2)
        self.points = np.clip(SHRINKAGE * self.points[drawn] + (1 - SHRINKAGE) * mean + noise, LOW, HIGH)
        states = [self.particles[one].state.copy() for one in drawn]
        self.particles = [
            Simulator(from_coordinates(point), self.physics, state)
            for point, state in zip(self.points, states, strict=True)
        ]
        self.log_weights = np.zeros(PARTICLES)
