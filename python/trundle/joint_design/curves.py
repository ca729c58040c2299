"""Smooth motions of one joint that begin and end at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Curve", "moves", "rest", "sine"]

Floats = NDArray[np.float64]

MAX_FADE_SHARE = 0.2
"""Share of a sine's duration in which its amplitude rises, and falls again at the end."""


@dataclass(frozen=True)
class Curve:
    """Position, velocity and acceleration of a joint, (T,) each, on uniform times from 0."""

    q: Floats
    v: Floats
    a: Floats


def rest(position: float, count: int) -> Curve:
    """Return a curve of `count` samples at one position."""
    return Curve(np.full(count, position), np.zeros(count), np.zeros(count))


def moves(points: Sequence[float], speeds: Sequence[float], acceleration: float, dt: float) -> Curve:
    """Return motion through points, at rest in each of them.

    Parameters
    ----------
    points : sequence of n + 1 floats
    speeds : sequence of n floats
        Largest speed of each move: constant except in smooth transitions, lower in a short move.
    acceleration : float
        Largest acceleration.
    dt : float
        Interval of the samples, s.
    """
    starts, own = [0.0], []
    for first, last, speed in zip(points[:-1], points[1:], speeds, strict=True):
        way = abs(last - first)
        # The transition v(s) = V/2·(1 - cos(πs/T)) has the largest acceleration πV/(2T) and covers VT/2.
        speed = min(speed, float(np.sqrt(2 * acceleration * way / np.pi)))
        transition = np.pi * speed / (2 * acceleration)
        own.append((first, np.sign(last - first), speed, transition, way))
        starts.append(starts[-1] + (way / speed + transition if way > 0 else 0.0))
    t: Floats = np.arange(int(np.ceil(starts[-1] / dt)) + 1, dtype=np.float64) * float(dt)
    found = rest(points[-1], len(t))
    for start, end, one in zip(starts[:-1], starts[1:], own, strict=True):
        rows = (t >= start) & (t < end)
        found.q[rows], found.v[rows], found.a[rows] = _move(t[rows] - start, end - start, *one)
    return found


def _move(
    s: Floats, duration: float, first: float, sign: float, speed: float, transition: float, way: float
) -> tuple[Floats, Floats, Floats]:
    """Return a move at times `s` after its start: it is symmetric about its middle."""
    late = s > duration / 2
    s = np.where(late, duration - s, s)
    phase = np.pi * np.minimum(s, transition) / transition
    covered = speed / 2 * (np.minimum(s, transition) - transition / np.pi * np.sin(phase))
    covered = covered + speed * np.maximum(s - transition, 0.0)
    q = first + sign * np.where(late, way - covered, covered)
    v = sign * speed / 2 * (1 - np.cos(phase))
    a = sign * np.where(late, -1, 1) * np.pi * speed / (2 * transition) * np.sin(phase)
    return q, v, a


def sine(centre: float, amplitude: float, frequency: float, duration: float, dt: float) -> Curve:
    """Return an oscillation about a position, whose amplitude rises at the start and falls at the end.

    Parameters
    ----------
    centre, amplitude : float
    frequency : float
        Angular frequency, rad/s.
    duration, dt : float
        In s.
    """
    t = np.arange(int(duration / dt) + 1) * dt
    fade = min(MAX_FADE_SHARE * duration, 2 * np.pi / frequency)
    edge = np.minimum(t, t[-1] - t) / fade
    x, sign = np.clip(edge, 0.0, 1.0), np.where(t < t[-1] / 2, 1.0, -1.0)
    w = x**3 * (10 - 15 * x + 6 * x**2)
    slope = sign * 30 * x**2 * (1 - x) ** 2 / fade
    curvature = 60 * x * (1 - x) * (1 - 2 * x) / fade**2
    s, c = np.sin(frequency * t), np.cos(frequency * t)
    q = centre + amplitude * w * s
    v = amplitude * (slope * s + w * frequency * c)
    a = amplitude * (curvature * s + 2 * slope * frequency * c - w * frequency**2 * s)
    return Curve(q, v, a)
