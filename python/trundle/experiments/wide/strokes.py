"""Free pushing: a finger makes contact, pushes, retracts, and starts again at another place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.shapes import Shape
from trundle.experiments.sampling import log_uniform

__all__ = ["Finger", "Stroke", "Strokes", "draw_strokes"]


CLEARANCE_M = 0.03
"""Distance between finger and edge at the start of a stroke."""
SPEED_TIME_CONSTANT_S = 0.15
"""Time constant of the finger's speed."""
LIFT_DURATION_S = 0.3
"""Time between two strokes, in which the finger moves above the object."""


@dataclass(frozen=True)
class Stroke:
    """One stroke.

    Attributes
    ----------
    begin, end : float
        Internal time, s.
    back : float
        Duration of the retraction before `end`, s.
    edge : float
        Position of the start along the outline, 0 to 1.
    lean : float
        Angle between the stroke and the inward normal at its start, rad.
    speed, wobble, frequency : float
        Speed, m/s; relative amplitude and frequency (Hz) of its modulation.
    """

    begin: float
    end: float
    back: float
    edge: float
    lean: float
    speed: float
    wobble: float
    frequency: float


@dataclass(frozen=True)
class Strokes:
    """The strokes of an episode, the arm's stiffness (N/m), and the friction coefficient of the fingertip."""

    strokes: tuple[Stroke, ...]
    stiffness: float
    friction: float


def draw_strokes(rng: np.random.Generator, seconds: float) -> Strokes:
    """Return strokes that fill an episode."""
    strokes, t = [], CONTACT_TIME_S
    while seconds - t > 1.2:
        end = min(t + float(rng.uniform(1.2, 3.5)), seconds)
        end = seconds if seconds - end < 1.2 else end
        strokes.append(
            Stroke(
                begin=t,
                end=end,
                back=0.3,
                edge=float(rng.uniform()),
                lean=float(rng.uniform(-0.4, 0.4)),
                speed=float(rng.uniform(0.08, 0.35)),
                wobble=float(rng.uniform(0.0, 1.2)),
                frequency=float(rng.uniform(0.4, 1.5)),
            )
        )
        t = end
    stiffness = log_uniform(rng, 3e3, 3e4)
    return Strokes(tuple(strokes), stiffness, float(rng.choice([0.0, 0.15, 0.3])))


@dataclass
class Finger:
    """The desired motion of the finger. The start of a stroke depends on the object's pose at that time."""

    strokes: Strokes
    shape: Shape
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
        self.speed += self.step / SPEED_TIME_CONSTANT_S * (desired_speed(stroke, t) - self.speed)
        vx, vy = self.speed * self.way[0], self.speed * self.way[1]
        self.place = (self.place[0] + self.step * vx, self.place[1] + self.step * vy)
        return *self.place, vx, vy, True

    def start(self, stroke: Stroke, pose: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the start of a stroke, and its direction."""
        ring = self.shape.outline
        edges = np.roll(ring, -1, axis=0) - ring
        lengths = np.hypot(*edges.T)
        ends = np.cumsum(lengths)
        k = min(int(np.searchsorted(ends, stroke.edge * ends[-1])), len(ring) - 1)
        share = 0.1 + 0.8 * (1.0 - (ends[k] - stroke.edge * ends[-1]) / lengths[k])
        inward = np.array([-edges[k][1], edges[k][0]]) / lengths[k]
        point = ring[k] + share * edges[k] - CLEARANCE_M * inward
        c, s = math.cos(pose[2]), math.sin(pose[2])
        place = (pose[0] + c * point[0] - s * point[1], pose[1] + s * point[0] + c * point[1])
        turn = math.atan2(inward[1], inward[0]) + pose[2] + stroke.lean
        return (float(place[0]), float(place[1])), (math.cos(turn), math.sin(turn))


def desired_speed(stroke: Stroke, t: float) -> float:
    """Return the desired speed along the stroke."""
    if t > stroke.end - stroke.back:
        return -0.3
    return stroke.speed * (
        1.0 + stroke.wobble * math.sin(2 * math.pi * stroke.frequency * (t - stroke.begin))
    )
