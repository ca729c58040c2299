"""Pushes: initial pose, grasp, and the desired motion or the wrench of the gripper."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trundle.experiments.blind.shapes import Shape
from trundle.experiments.sampling import Floats

__all__ = [
    "CONTACT_TIME_S",
    "EPISODE_DURATION_S",
    "Grasp",
    "Push",
    "WrenchPush",
    "draw_grasp",
    "draw_push",
    "low_excitation",
]


EPISODE_DURATION_S = 6.0
"""Duration of an episode."""
CONTACT_TIME_S = 0.5
"""Time at which the gripper takes hold."""
RAMP_DURATION_S = 0.3
"""Time over which the desired twist grows from zero."""
NO_ROTATION = np.array([[1.0], [1.0], [0.0]])
"""Factor that removes the rotation from a desired twist."""
LOW_EXCITATION_FREQUENCY_FACTOR = 0.2
"""Factor of the frequencies where a push does not rotate: same speed, longer paths."""


@dataclass(frozen=True)
class Grasp:
    """Pose of the gripper in the object's frame: m, m, rad."""

    x: float
    y: float
    angle: float


@dataclass(frozen=True)
class Push:
    """One episode: initial pose, grasp, and desired motion of the gripper.

    The desired twist in gripper axes is a sum of sines. The gripper exerts a force proportional to the
    velocity error, up to its limit.
    """

    start: tuple[float, float, float]
    grasp: Grasp
    amplitude: Floats
    """(3, n): m/s, m/s, rad/s."""
    frequency: Floats
    """(3, n), Hz."""
    phase: Floats

    def desired_twist(self, t: Floats) -> Floats:
        """Return the desired twist (len(t), 3) at times of the table."""
        s = t - CONTACT_TIME_S
        on = np.clip(s / RAMP_DURATION_S, 0.0, 1.0)
        waves = np.sin(2 * np.pi * self.frequency * s[:, None, None] + self.phase)
        return np.asarray(on[:, None] * np.sum(self.amplitude * waves, axis=2))


@dataclass(frozen=True)
class WrenchPush:
    """An episode with a commanded wrench, as `trundle design` returns it.

    `knots` are rows [t, f_x, f_y, τ]: s from contact on, N, N, N·m, gripper axes, with linear interpolation.
    """

    start: tuple[float, float, float]
    grasp: Grasp
    knots: Floats

    def wrench(self, t: Floats) -> Floats:
        """Return the wrench (len(t), 3) at times of the table; zero after the last knot."""
        when, *courses = self.knots.T
        return np.column_stack([np.interp(t - CONTACT_TIME_S, when, course, right=0.0) for course in courses])


def draw_grasp(rng: np.random.Generator, shape: Shape) -> Grasp:
    """Return a grasp on the outline with a random orientation."""
    edges = np.roll(shape.outline, -1, axis=0) - shape.outline
    lengths = np.hypot(*edges.T)
    k = int(rng.choice(len(edges), p=lengths / lengths.sum()))
    x, y = shape.outline[k] + rng.uniform(0.1, 0.9) * edges[k]
    return Grasp(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))


def draw_push(rng: np.random.Generator, grasp: Grasp, waves: int = 4) -> Push:
    """Return an episode that translates and rotates the object back and forth."""
    size = np.array([0.35, 0.35, 0.6]) * rng.uniform(0.6, 1.2)
    share = rng.dirichlet(np.ones(waves), size=3) ** 0.5
    x, y = rng.uniform(-0.4, 0.4, 2)
    return Push(
        start=(float(x), float(y), float(rng.uniform(-np.pi, np.pi))),
        grasp=grasp,
        amplitude=size[:, None] * share,
        frequency=rng.uniform(0.12, 0.9, (3, waves)),
        phase=rng.uniform(-np.pi, np.pi, (3, waves)),
    )


def low_excitation(push: Push, first: Push | WrenchPush) -> Push:
    """Return a push with the initial pose and grasp of `first`, lower frequencies and no rotation."""
    amplitude, frequency = push.amplitude * NO_ROTATION, LOW_EXCITATION_FREQUENCY_FACTOR * push.frequency
    return replace(push, start=first.start, grasp=first.grasp, amplitude=amplitude, frequency=frequency)
