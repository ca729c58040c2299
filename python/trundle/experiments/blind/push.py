"""A push: where the object stands, where it is held, and what the gripper wants or exerts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.shapes import Shape

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

Floats = NDArray[np.float64]

EPISODE_DURATION_S = 6.0
"""Length of an episode, s."""
CONTACT_TIME_S = 0.5
"""When the gripper takes hold, s."""
RAMP_DURATION_S = 0.3
"""Over which a push sets in, s."""
NO_ROTATION = np.array([[1.0], [1.0], [0.0]])
"""What is left of a wanted twist that does not turn."""
LOW_EXCITATION_FREQUENCY_FACTOR = 0.2
"""The same speed over longer ways, where a push does not turn."""


@dataclass(frozen=True)
class Grasp:
    """Where the gripper holds the object: m, m, rad, object frame."""

    x: float
    y: float
    angle: float


@dataclass(frozen=True)
class Push:
    """One episode: where the object starts, where it is held, and the motion that the gripper wants.

    The wanted twist of the gripper, in its own axes, is a sum of sines; a force in proportion to what is
    missing of it is what the gripper exerts, up to its limit, so that speeds stay those of a room.
    """

    start: tuple[float, float, float]
    grasp: Grasp
    amplitude: Floats
    """(3, n): m/s, m/s, rad/s."""
    frequency: Floats
    """(3, n), Hz."""
    phase: Floats

    def desired_twist(self, t: Floats) -> Floats:
        """Return the wanted twist (len(t), 3) at times of the table."""
        s = t - CONTACT_TIME_S
        on = np.clip(s / RAMP_DURATION_S, 0.0, 1.0)
        waves = np.sin(2 * np.pi * self.frequency * s[:, None, None] + self.phase)
        return np.asarray(on[:, None] * np.sum(self.amplitude * waves, axis=2))


@dataclass(frozen=True)
class WrenchPush:
    """An episode in which the gripper exerts a wrench, whatever moves: what `trundle design` asks for.

    `knots` are rows [t, f_x, f_y, τ]: s from contact on, N, N, N·m, gripper axes, straight lines between.
    """

    start: tuple[float, float, float]
    grasp: Grasp
    knots: Floats

    def wrench(self, t: Floats) -> Floats:
        """Return the wrench (len(t), 3) at times of the table; none after the last knot."""
        when, *courses = self.knots.T
        return np.column_stack([np.interp(t - CONTACT_TIME_S, when, course, right=0.0) for course in courses])


def draw_grasp(rng: np.random.Generator, shape: Shape) -> Grasp:
    """Return a grasp on the outline, its axes turned at random."""
    edges = np.roll(shape.outline, -1, axis=0) - shape.outline
    lengths = np.hypot(*edges.T)
    k = int(rng.choice(len(edges), p=lengths / lengths.sum()))
    x, y = shape.outline[k] + rng.uniform(0.1, 0.9) * edges[k]
    return Grasp(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))


def draw_push(rng: np.random.Generator, grasp: Grasp, waves: int = 4) -> Push:
    """Return an episode that moves and turns the object to and fro."""
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
    """Return a push that begins as the first does, by its grasp, slower, and that turns nothing."""
    amplitude, frequency = push.amplitude * NO_ROTATION, LOW_EXCITATION_FREQUENCY_FACTOR * push.frequency
    return replace(push, start=first.start, grasp=first.grasp, amplitude=amplitude, frequency=frequency)
