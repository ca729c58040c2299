"""What is drawn before any effect: an object, its wheel, its instruments, and how it is pushed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

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

__all__ = ["Scene", "Wheel", "draw_event", "draw_scene"]

Floats = NDArray[np.float64]

SENSOR_RATES_HZ = (125.0, 200.0, 250.0)
"""Of the force-torque sensor, Hz."""


@dataclass(frozen=True)
class Wheel:
    """A viscous wheel: place m and rolling direction rad in the object's frame, friction N·s/m."""

    x: float
    y: float
    angle: float
    mu_x: float
    mu_y: float

    def damping(self) -> Floats:
        """Return its damping (3, 3) about the object's origin, object axes (x, y, θ)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        slip = np.array([[c, s], [-s, c]]) @ np.array([[1.0, 0.0, -self.y], [0.0, 1.0, self.x]])
        return np.asarray(slip.T @ np.diag([self.mu_x, self.mu_y]) @ slip)


@dataclass(frozen=True)
class Scene:
    """Everything of a case but its effects.

    Attributes
    ----------
    seed : int
        From which the noise of each episode is drawn too.
    mass : float
        kg.
    gain : (N·s/m, N·m·s)
        Of the gripper: force by missing velocity.
    limit : (N, N·m)
        What the gripper exerts at most.
    offset : (N, N, N·m)
        The raw sensor's.
    rate : float
        Of the sensor, Hz.
    feet_told, mass_told : bool
        Whether the recording says where the object stands, and what it weighs.
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
        """Where the floor can drag: the feet if the recording tells them, else the corners."""
        return self.shape.feet if self.feet_given else self.shape.corners()


def draw_scene(seed: int, attempt: int = 0, episodes: int = 8, *, alike: bool = False) -> Scene:
    """Return the scene of a seed; another one for each attempt. Pushes that are `alike` are `levelled`."""
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
    """Return a wheel somewhere under the object, that rolls more or less easily and resists sideways."""
    x, y = draw_point(rng, shape)
    mu_x, mu_y = np.exp(rng.uniform(np.log((4.0, 40.0)), np.log((40.0, 300.0))))
    return Wheel(x, y, float(rng.uniform(-np.pi / 2, np.pi / 2)), float(mu_x), float(mu_y))


def draw_point(rng: np.random.Generator, shape: Shape) -> tuple[float, float]:
    """Return a point under the object, evenly."""
    low, high = shape.outline.min(axis=0), shape.outline.max(axis=0)
    while True:
        point = rng.uniform(low, high)
        if inside(point[None, :], shape.outline)[0]:
            return float(point[0]), float(point[1])


def draw_event(rng: np.random.Generator, scene: Scene) -> dict[str, float]:
    """Return a moment of a training episode that has another before and, if there are enough, after it."""
    training = len(scene.pushes) - scene.held_out
    first = min(1, training - 1)
    episode = int(rng.integers(first, max(training - 1, first + 1)))
    return {"episode": episode, "time": float(rng.uniform(CONTACT_TIME_S + 1.0, EPISODE_DURATION_S - 1.0))}
