"""Scenes: an object, its wheel, its instruments and its pushes, without hidden effects."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from trundle.experiments.blind.push import (
    CONTACT_TIME_S,
    EPISODE_DURATION_S,
    Push,
    WrenchPush,
    draw_grasp,
    draw_push,
    low_excitation,
)
from trundle.experiments.blind.shapes import Shape, draw_shape, inside
from trundle.experiments.sampling import Floats

__all__ = ["Scene", "Wheel", "draw_event", "draw_scene"]


SENSOR_RATES_HZ = (125.0, 200.0, 250.0)
"""Sample rates of the force-torque sensor."""


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
    gain : (N·s/m, N·m·s)
        Gain of the gripper: force per velocity error.
    limit : (N, N·m)
        Largest wrench of the gripper.
    offset : (N, N, N·m)
        Offset of the raw sensor.
    rate : float
        Sample rate of the sensor, Hz.
    feet_given, mass_given : bool
        Whether the recording states the feet and the mass.
    """

    seed: int
    shape: Shape
    mass: float
    wheel: Wheel
    pushes: tuple[Push | WrenchPush, ...]
    gain: tuple[float, float]
    limit: tuple[float, float]
    offset: tuple[float, float, float]
    rate: float
    feet_given: bool
    mass_given: bool
    held_out: int = 2
    pose_noise: float = 5e-4
    heading_noise: float = field(default=float(np.radians(0.1)))
    force_noise: float = 0.4
    torque_noise: float = 0.05

    @property
    def friction_points(self) -> Floats:
        """Points with floor friction: the feet if the recording states them, else the corners."""
        return self.shape.feet if self.feet_given else self.shape.corners()


def draw_scene(seed: int, attempt: int = 0, episodes: int = 8, *, alike: bool = False) -> Scene:
    """Return the scene of a seed; each attempt gives another one.

    With `alike`, all pushes have the initial pose and grasp of the first and do not rotate.
    """
    rng = np.random.default_rng([seed, attempt, 1])
    shape = draw_shape(rng)
    mass = round(float(rng.uniform(8.0, 40.0)), 1)
    grasps = [draw_grasp(rng, shape) for _ in range(int(rng.integers(3, 5)))]
    gain = float(rng.uniform(60.0, 200.0))
    wheel = draw_wheel(rng, shape)
    pushes = tuple(draw_push(rng, grasps[k % len(grasps)]) for k in range(episodes))
    return Scene(
        seed=seed,
        shape=shape,
        mass=mass,
        wheel=wheel,
        pushes=tuple(low_excitation(push, pushes[0]) for push in pushes) if alike else pushes,
        gain=(gain, (4.0 if alike else 0.2) * gain),
        limit=(80.0, 120.0 if alike else 25.0),
        offset=tuple(rng.uniform(-1, 1, 3) * (3.0, 3.0, 0.3)),
        rate=float(rng.choice(SENSOR_RATES_HZ)),
        feet_given=bool(rng.random() < 0.7) or shape.disc is not None,
        mass_given=bool(rng.random() < 0.3),
        held_out=min(2, episodes - 1),
    )


def draw_wheel(rng: np.random.Generator, shape: Shape) -> Wheel:
    """Return a wheel at a random position under the object, with low friction along its rolling direction."""
    x, y = draw_point(rng, shape)
    mu_x, mu_y = np.exp(rng.uniform(np.log((4.0, 40.0)), np.log((40.0, 300.0))))
    return Wheel(x, y, float(rng.uniform(-np.pi / 2, np.pi / 2)), float(mu_x), float(mu_y))


def draw_point(rng: np.random.Generator, shape: Shape) -> tuple[float, float]:
    """Return a uniformly distributed point under the object."""
    low, high = shape.outline.min(axis=0), shape.outline.max(axis=0)
    while True:
        point = rng.uniform(low, high)
        if inside(point[None, :], shape.outline)[0]:
            return float(point[0]), float(point[1])


def draw_event(rng: np.random.Generator, scene: Scene) -> dict[str, float]:
    """Return a time in a training episode that has an episode before it and, if possible, one after it."""
    training = len(scene.pushes) - scene.held_out
    first = min(1, training - 1)
    episode = int(rng.integers(first, max(training - 1, first + 1)))
    return {"episode": episode, "time": float(rng.uniform(CONTACT_TIME_S + 1.0, EPISODE_DURATION_S - 1.0))}
