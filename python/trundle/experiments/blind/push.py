"""Pushes: grasps with a desired motion or a wrench, and strokes of a free finger."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from trundle.experiments.blind.outline import Outline
from trundle.experiments.sampling import Floats

__all__ = [
    "CONTACT_TIME_S",
    "Finger",
    "Grasp",
    "Kinematics",
    "Push",
    "Stroke",
    "Strokes",
    "Wrench",
    "WrenchPush",
    "draw_grasp",
    "draw_push",
    "low_excitation",
    "servo_wrench",
]

Wrench: TypeAlias = tuple[float, float, float]

CONTACT_TIME_S = 0.5
"""Time at which the gripper takes hold."""
RAMP_DURATION_S = 0.3
"""Time over which the desired twist grows from zero."""
LOW_EXCITATION_FREQUENCY_FACTOR = 0.2
"""Factor of the frequencies where a push does not rotate: same speed, longer paths."""
CLEARANCE_M = 0.03
"""Distance between finger and edge at the start of a stroke."""
SPEED_TIME_CONSTANT_S = 0.15
"""Time constant of the finger's speed."""
LIFT_DURATION_S = 0.3
"""Time between two strokes, in which the finger moves above the object."""
RETRACTION_S, RETRACTION_M_PER_S = 0.3, -0.3
"""Duration and speed of the retraction at the end of a stroke."""


class Kinematics(NamedTuple):
    """Pose and twist of the object's origin, world axes; `c` and `s` are cosine and sine of the heading."""

    x: float
    y: float
    c: float
    s: float
    vx: float
    vy: float
    omega: float
    theta: float

    @classmethod
    def of(cls, state: Sequence[float]) -> Kinematics:
        """Return the pose and twist of a state [x, y, θ, v_x, v_y, ω, …]."""
        x, y, theta, vx, vy, omega = state[:6]
        return cls(x, y, math.cos(theta), math.sin(theta), vx, vy, omega, theta)


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
    velocity error, up to its limit. `amplitude` (3, n) has the units m/s, m/s, rad/s; `frequency` (3, n) Hz.
    """

    start: tuple[float, float, float]
    grasp: Grasp
    amplitude: Floats
    frequency: Floats
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


def draw_grasp(rng: np.random.Generator, shape: Outline) -> Grasp:
    """Return a grasp on the outline with a random orientation."""
    edges, lengths = shape.edges()
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
    amplitude = push.amplitude * np.array([[1.0], [1.0], [0.0]])
    frequency = LOW_EXCITATION_FREQUENCY_FACTOR * push.frequency
    return replace(push, start=first.start, grasp=first.grasp, amplitude=amplitude, frequency=frequency)


def servo_wrench(
    at: Kinematics,
    grasp: Grasp,
    desired: Sequence[float],
    gain: tuple[float, float],
    limit: tuple[float, float],
) -> Wrench:
    """Return the gripper's wrench in its own axes: proportional to the error of its twist, saturated."""
    vx = at.vx - at.omega * (at.s * grasp.x + at.c * grasp.y)
    vy = at.vy + at.omega * (at.c * grasp.x - at.s * grasp.y)
    c, s = math.cos(at.theta + grasp.angle), math.sin(at.theta + grasp.angle)
    (force, torque), (most, turn) = gain, limit
    along = most * math.tanh(force * (desired[0] - c * vx - s * vy) / most)
    across = most * math.tanh(force * (desired[1] + s * vx - c * vy) / most)
    return along, across, turn * math.tanh(torque * (desired[2] - at.omega) / turn)


@dataclass(frozen=True)
class Stroke:
    """One stroke of a finger.

    Attributes
    ----------
    begin, end : float
        Time without the clock offset, s.
    edge : float
        Position of the start along the outline, 0 to 1.
    lean : float
        Angle between the stroke and the inward normal at its start, rad.
    speed, wobble, frequency : float
        Speed, m/s; relative amplitude and frequency (Hz) of its modulation.
    """

    begin: float
    end: float
    edge: float
    lean: float
    speed: float
    wobble: float
    frequency: float

    def desired_speed(self, t: float) -> float:
        """Return the desired speed along the stroke."""
        if t > self.end - RETRACTION_S:
            return RETRACTION_M_PER_S
        wave = math.sin(2 * math.pi * self.frequency * (t - self.begin))
        return self.speed * (1.0 + self.wobble * wave)


@dataclass(frozen=True)
class Strokes:
    """The strokes of an episode, the arm's stiffness (N/m), and the friction coefficient of the fingertip."""

    strokes: tuple[Stroke, ...]
    stiffness: float
    friction: float


@dataclass
class Finger:
    """The desired motion of the finger. The start of a stroke depends on the object's pose at that time."""

    strokes: Strokes
    shape: Outline
    step: float
    number: int = -1
    place: tuple[float, float] = (0.0, 0.0)
    lifted_at: tuple[float, float] = (0.0, 0.0)
    speed: float = 0.0
    way: tuple[float, float] = (1.0, 0.0)

    def at(self, t: float, pose: Sequence[float]) -> tuple[float, float, float, float, bool]:
        """Return x, y, v_x, v_y and whether the finger is down at `t`, one step after the last call."""
        strokes = self.strokes.strokes
        number = max(self.number, 0)
        if number + 1 < len(strokes) and t >= strokes[number + 1].begin:
            number += 1
        stroke = strokes[number]
        if number != self.number:
            self.number, self.speed, self.lifted_at = number, 0.0, self.place
            self.place, self.way = self.start(stroke, pose)
        if number > 0 and t < stroke.begin + LIFT_DURATION_S:
            self.place, self.way = self.start(stroke, pose)
            share = (t - stroke.begin) / LIFT_DURATION_S
            share = share * share * (3.0 - 2.0 * share)
            (ax, ay), (bx, by) = self.lifted_at, self.place
            return ax + share * (bx - ax), ay + share * (by - ay), 0.0, 0.0, False
        self.speed += self.step / SPEED_TIME_CONSTANT_S * (stroke.desired_speed(t) - self.speed)
        vx, vy = self.speed * self.way[0], self.speed * self.way[1]
        self.place = (self.place[0] + self.step * vx, self.place[1] + self.step * vy)
        return *self.place, vx, vy, True

    def start(self, stroke: Stroke, pose: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the start of a stroke, and its direction."""
        edges, lengths = self.shape.edges()
        ends = np.cumsum(lengths)
        k = min(int(np.searchsorted(ends, stroke.edge * ends[-1])), len(edges) - 1)
        share = 0.1 + 0.8 * (1.0 - (ends[k] - stroke.edge * ends[-1]) / lengths[k])
        inward = np.array([-edges[k][1], edges[k][0]]) / lengths[k]
        point = self.shape.outline[k] + share * edges[k] - CLEARANCE_M * inward
        c, s = math.cos(pose[2]), math.sin(pose[2])
        place = (pose[0] + c * point[0] - s * point[1], pose[1] + s * point[0] + c * point[1])
        turn = math.atan2(inward[1], inward[0]) + pose[2] + stroke.lean
        return (float(place[0]), float(place[1])), (math.cos(turn), math.sin(turn))
