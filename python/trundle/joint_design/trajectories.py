"""Candidate trajectories of all joints within limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle.joint_design.curves import Curve, moves, rest, sine
from trundle.joint_design.limits import JointLimits

__all__ = ["Trajectory", "trajectories"]

Floats = NDArray[np.float64]

RANGE_MARGIN = 0.02
"""Share of a joint's range that trajectories keep from its ends."""
SLOW_FACTOR = 1.5
"""Slowest ramp, in speeds below which samples are not compared."""
SLOW_SHARE = 0.02
"""Slowest ramp, as a share of the speed limit."""
SPEEDS = 4
"""Number of speeds of ramps."""
ACCELERATION_SHARE = 0.5
"""Share of the acceleration limit that ramps use to reverse."""
AMPLITUDES = (1.0, 0.5, 0.25)
"""Amplitudes of oscillations, as shares of half the range."""
FREQUENCIES = (1.0, 0.5, 0.25)
"""Frequencies of oscillations, as shares of the largest one within the limits."""
MIN_CYCLES = 2
"""Fewest cycles of an oscillation."""
MAX_POSES = 5
"""Most poses that a joint approaches slowly from both sides."""
SEVERAL_SPEEDS_SHARE = 0.75
"""Share of the duration for ramps at several speeds; the rest is for the moves between them."""
APPROACH_SHARE = 0.06
"""Half of the range of an approach, as a share of the range."""
DETUNING = 0.37
"""Relative spacing of the periods of joints that move together."""


@dataclass(frozen=True)
class Trajectory:
    """Motion of all joints, (T, n) arrays on uniform times from 0.

    Attributes
    ----------
    profile : {"ramps", "ramps_at_several_speeds", "sine", "slow_approaches", "all_joints"}
    joint : str or None
        The joint that moves; None for all.
    dt : float
        In s.
    q, v, a : arrays
    words : str
        Description.
    """

    profile: str
    joint: str | None
    dt: float
    q: Floats
    v: Floats
    a: Floats
    words: str

    @property
    def t(self) -> Floats:
        """Times, (T,), s."""
        times: Floats = np.arange(len(self.q), dtype=np.float64) * self.dt
        return times


def trajectories(
    limits: Sequence[JointLimits],
    moving: Sequence[int],
    poses: Sequence[Sequence[Floats]],
    duration: float,
    dt: float,
) -> list[Trajectory]:
    """Return candidate trajectories.

    Parameters
    ----------
    limits : sequence of JointLimits
        Of all joints.
    moving : sequence of int
        Joints that move, one at a time.
    poses : sequence of sequences of (n,) arrays
        For each moving joint: poses in which the other joints rest.
    duration, dt : float
        In s.
    """
    found = []
    for j, places in zip(moving, poses, strict=True):
        curves = [one for one in _curves(limits[j], duration, dt) if len(one[2].q) * dt <= duration + 2 * dt]
        for pose in places:
            found += [_single(limits, j, pose, *one, dt) for one in curves]
    if len(limits) > 1:
        found += [_together(limits, share, duration, dt) for share in FREQUENCIES]
    return found


def _curves(limit: JointLimits, duration: float, dt: float) -> Iterator[tuple[str, str, Curve]]:
    """Yield profile, description and curve of one joint."""
    margin = RANGE_MARGIN * (limit.high - limit.low)
    low, high = limit.low + margin, limit.high - margin
    slowest = min(max(SLOW_FACTOR * limit.slowest, SLOW_SHARE * limit.speed), limit.speed)
    speeds = np.geomspace(slowest, limit.speed, SPEEDS)
    for speed in speeds:
        points = _there_and_back(low, high, speed, limit.acceleration, duration)
        own = [speed] * (len(points) - 1)
        yield "ramps", f"in ramps at {_number(speed)}", _ramps(points, own, limit, dt)
    yield _several_speeds(low, high, speeds[:-1], limit, duration, dt)
    yield from _sines(limit, low, high, duration, dt)
    yield from _approaches(low, high, speeds, limit, duration, dt)


def _several_speeds(
    low: float, high: float, speeds: Floats, limit: JointLimits, duration: float, dt: float
) -> tuple[str, str, Curve]:
    part = SEVERAL_SPEEDS_SHARE * duration / len(speeds)
    groups = [_there_and_back(low, high, speed, limit.acceleration, part) for speed in speeds]
    points = [point for group in groups for point in group[:-1]] + groups[-1][-1:]
    own = [speed for group, speed in zip(groups, speeds, strict=True) for _ in group[:-1]]
    words = f"in ramps at {', '.join(map(_number, speeds))}"
    return "ramps_at_several_speeds", words, _ramps(points, own, limit, dt)


def _approaches(
    low: float, high: float, speeds: Floats, limit: JointLimits, duration: float, dt: float
) -> Iterator[tuple[str, str, Curve]]:
    """Yield slow motion across as many poses as the duration permits."""
    reach = APPROACH_SHARE * (high - low)
    for count in range(MAX_POSES, 0, -1):
        points, own = [low + reach], []
        for pose in np.linspace(low + reach, high - reach, count) if count > 1 else [(low + high) / 2]:
            points += [pose + reach, pose - reach, pose + reach, pose]
            own += [speeds[-2], speeds[0], speeds[0], speeds[0]]
        curve = _ramps(points, own, limit, dt)
        if len(curve.q) * dt <= duration:
            poses = f"{count} poses" if count > 1 else "one pose"
            yield "slow_approaches", f"slowly ({_number(speeds[0])}) to {poses} from both sides", curve
            return


def _sines(
    limit: JointLimits, low: float, high: float, duration: float, dt: float
) -> Iterator[tuple[str, str, Curve]]:
    half = (high - low) / 2
    for share in AMPLITUDES:
        amplitude = share * half
        # The rising amplitude adds to the largest acceleration.
        fastest = 0.9 * min(limit.speed / amplitude, float(np.sqrt(limit.acceleration / amplitude)))
        shift = half - amplitude
        for centre in sorted({(low + high) / 2, (low + high) / 2 - shift, (low + high) / 2 + shift}):
            for part in FREQUENCIES:
                frequency = part * fastest
                if frequency * duration < 2 * np.pi * MIN_CYCLES:
                    continue
                hertz = frequency / (2 * np.pi)
                words = (
                    f"in a sine of amplitude {_number(amplitude)} about {_number(centre)} at {hertz:.3g} Hz"
                )
                yield "sine", words, sine(centre, amplitude, frequency, duration, dt)


def _there_and_back(
    low: float, high: float, speed: float, acceleration: float, duration: float
) -> list[float]:
    """Return points between which a joint moves at a speed for a duration: the whole range, or its middle."""
    overhead = np.pi * speed / (2 * ACCELERATION_SHARE * acceleration)
    cycles = int(duration / (2 * ((high - low) / speed + overhead)))
    if cycles < 1:
        middle, half = (low + high) / 2, max(duration / 2 - overhead, duration / 8) * speed / 2
        low, high, cycles = max(low, middle - half), min(high, middle + half), 1
    return [low, *[high, low] * cycles]


def _ramps(points: Sequence[float], speeds: Sequence[float], limit: JointLimits, dt: float) -> Curve:
    return moves(points, speeds, ACCELERATION_SHARE * limit.acceleration, dt)


def _single(
    limits: Sequence[JointLimits], j: int, pose: Floats, profile: str, words: str, curve: Curve, dt: float
) -> Trajectory:
    columns = [rest(float(position), len(curve.q)) for position in pose]
    columns[j] = curve
    others = [f"{limit.joint} = {_number(pose[k])}" for k, limit in enumerate(limits) if k != j]
    where = f", with {', '.join(others)} at rest" if others else ""
    span = f"between {_number(curve.q.min())} and {_number(curve.q.max())}"
    text = (
        f"Move {limits[j].joint} {words} {span}{where}"
        if profile != "sine"
        else (f"Move {limits[j].joint} {words}{where}")
    )
    q, v, a = (np.stack([getattr(one, key) for one in columns], axis=1) for key in ("q", "v", "a"))
    return Trajectory(profile, limits[j].joint, dt, q, v, a, text)


def _together(limits: Sequence[JointLimits], share: float, duration: float, dt: float) -> Trajectory:
    curves = []
    for k, limit in enumerate(limits):
        amplitude = (0.5 - RANGE_MARGIN) * (limit.high - limit.low)
        fastest = min(limit.speed / amplitude, float(np.sqrt(limit.acceleration / amplitude)))
        frequency = 0.9 * share * fastest / (1 + DETUNING * k)
        curves.append(sine((limit.low + limit.high) / 2, amplitude, frequency, duration, dt))
    q, v, a = (np.stack([getattr(one, key) for one in curves], axis=1) for key in ("q", "v", "a"))
    words = f"Move all joints in sines over their ranges, at {share:.3g} of the largest frequencies"
    return Trajectory("all_joints", None, dt, q, v, a, words)


def _number(value: float) -> str:
    return f"{value:.3g}"
