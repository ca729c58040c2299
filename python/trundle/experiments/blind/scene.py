"""Scenes: an object, its wheel, its instruments and its pushes, without hidden effects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.experiments.blind.instrument import Instrument
from trundle.experiments.blind.outline import Outline, inside
from trundle.experiments.blind.push import Push, Strokes, WrenchPush
from trundle.experiments.sampling import Floats

__all__ = ["ENGINES", "Scene", "Wheel", "draw_point", "draw_training_episode", "draw_wheel"]

ENGINES = ("mujoco", "ode")


@dataclass(frozen=True)
class Wheel:
    """A viscous wheel: position m and rolling direction rad in the object's frame, friction N·s/m."""

    x: float
    y: float
    angle: float
    mu_x: float
    mu_y: float

    def damping(self) -> Floats:
        """Return the damping matrix (3, 3) about the object's origin, object axes (x, y, θ)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        slip = np.array([[c, s], [-s, c]]) @ np.array([[1.0, 0.0, -self.y], [0.0, 1.0, self.x]])
        return np.asarray(slip.T @ np.diag([self.mu_x, self.mu_y]) @ slip)


@dataclass(frozen=True)
class Scene:
    """Everything of a case except its effects.

    Attributes
    ----------
    seed : int
        Also seeds the noise of each episode.
    mass : float
        kg.
    seconds : tuple of float
        Duration of each episode.
    gain : (N·s/m, N·m·s)
        Gain of the gripper: force per velocity error.
    limit : (N, N·m)
        Largest wrench of the gripper.
    offset : (N, N, N·m)
        Offset of the raw sensor.
    pose_noise, wrench_noise : (m, m, rad), (N, N, N·m)
        Standard deviations.
    feet_given, mass_given : bool
        Whether the recording states the feet and the mass.
    engine : str
        One of `ENGINES`.
    compliance : (m/N, rad/(N·m))
        Compliance of the grasp.
    strokes : tuple of Strokes
        Strokes of free pushing in each episode; empty for a grasp.
    clock, rest : tuple of float
        Offset of the time of each episode, and start of its recording without that offset, s.
    """

    seed: int
    shape: Outline
    mass: float
    wheel: Wheel
    pushes: tuple[Push | WrenchPush, ...]
    seconds: tuple[float, ...]
    gain: tuple[float, float]
    limit: tuple[float, float]
    offset: tuple[float, float, float]
    instrument: Instrument
    pose_noise: tuple[float, float, float]
    wrench_noise: tuple[float, float, float]
    feet_given: bool
    mass_given: bool
    held_out: int
    engine: str = "mujoco"
    compliance: tuple[float, float] = (0.0, 0.0)
    strokes: tuple[Strokes, ...] = ()
    clock: tuple[float, ...] = ()
    rest: tuple[float, ...] = ()

    @property
    def friction_points(self) -> Floats:
        """Points with floor friction: the feet if the recording states them, else the corners."""
        return self.shape.feet if self.feet_given else self.shape.corners()


def draw_wheel(rng: np.random.Generator, shape: Outline, factor: float = 1.0) -> Wheel:
    """Return a wheel at a random position under the object, with low friction along its rolling direction."""
    x, y = draw_point(rng, shape)
    mu_x, mu_y = np.exp(rng.uniform(np.log((4.0, 40.0)), np.log((40.0, 300.0)))) * factor
    return Wheel(x, y, float(rng.uniform(-np.pi / 2, np.pi / 2)), float(mu_x), float(mu_y))


def draw_point(rng: np.random.Generator, shape: Outline) -> tuple[float, float]:
    """Return a uniformly distributed point under the object."""
    low, high = shape.outline.min(axis=0), shape.outline.max(axis=0)
    while True:
        point = rng.uniform(low, high)
        if inside(point[None, :], shape.outline)[0]:
            return float(point[0]), float(point[1])


def draw_training_episode(rng: np.random.Generator, scene: Scene) -> int:
    """Return a training episode that has an episode before it and, if possible, one after it."""
    training = len(scene.pushes) - scene.held_out
    first = min(1, training - 1)
    return int(rng.integers(first, max(training - 1, first + 1)))
