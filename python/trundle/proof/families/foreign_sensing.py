"""Instruments with faults that the catalogue does not have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.proof.families.foreign_motion import Foreign
from trundle.proof.family import Family, Site, Values
from trundle.proof.push import CONTACT
from trundle.proof.scene import Scene
from trundle.proof.seen import Seen, sampled

Floats = NDArray[np.float64]


class CrossTalk(Foreign):
    """Each axis of the sensor reads some of the others."""

    name = "cross_talk"
    scales = ("leak",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return how much of each axis every other reads; N·m by N, N by N·m."""
        leak = rng.normal(size=(3, 3)) * [[0.0, 0.15, 0.6], [0.15, 0.0, 0.6], [0.1, 0.1, 0.0]]
        return {"leak": leak.tolist()}

    def sized(self, values: Values, size: float) -> Values:
        """Return it `size` times as strong."""
        return {"leak": (size * np.array(values["leak"])).tolist()}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Mix the axes."""
        return seen.changed(wrench=seen.wrench @ (np.eye(3) + np.array(values["leak"])).T)


class DeadBand(Foreign):
    """Small forces are not read at all, larger ones too low."""

    name = "dead_band"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its width."""
        return {"force": float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Shrink forces towards zero, and the torque by a tenth of it per newton."""
        band = values["force"] * np.array([1.0, 1.0, 0.1])
        return seen.changed(wrench=np.sign(seen.wrench) * np.maximum(np.abs(seen.wrench) - band, 0.0))


class Saturation(Foreign):
    """The sensor reads no more than so much."""

    name = "saturation"
    scales = ("cut",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by which share of its range the reading is cut."""
        return {"cut": float(rng.uniform(0.3, 0.7))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Cut the reading of each axis."""
        most = (1.0 - values["cut"]) * np.max(np.abs(seen.wrench), axis=0)
        return seen.changed(wrench=np.clip(seen.wrench, -most, most))


class ClockDrift(Foreign):
    """The sensor's clock runs at another pace; it is right at contact."""

    name = "clock_drift"
    scales = ("pace",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by how much, either way."""
        return {"pace": float(rng.uniform(0.02, 0.08) * rng.choice([-1.0, 1.0]))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Read what was true before or will be."""
        when = seen.t - values["pace"] * np.maximum(seen.t - CONTACT, 0.0)
        return seen.changed(wrench=sampled(seen.t, seen.wrench, when))


class SensorPlay(Foreign):
    """The reading follows with play: it stays where it is until the force has moved on by so much."""

    name = "sensor_play"
    scales = ("width",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the width, N; a tenth of it in N·m for the torque."""
        return {"width": float(np.exp(rng.uniform(np.log(3.0), np.log(15.0))))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Follow each axis with play."""
        half = values["width"] / 2 * np.array([1.0, 1.0, 0.1])
        followed, last = np.empty_like(seen.wrench), np.zeros(3)
        for k, true in enumerate(seen.wrench):
            last = np.minimum(np.maximum(last, true - half), true + half)
            followed[k] = last
        return seen.changed(wrench=followed)


class SensorLag(Foreign):
    """The sensor's filter is slow: a reading of second order that resonates."""

    name = "sensor_lag"
    scales = ("seconds",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its time constant."""
        return {"seconds": float(rng.uniform(0.05, 0.15))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Filter the reading, damping ratio 0.3."""
        step = float(seen.t[1] - seen.t[0])
        if values["seconds"] < step:
            return seen
        omega = 1.0 / values["seconds"]
        found, rate, last = np.empty_like(seen.wrench), np.zeros(3), np.zeros(3)
        for k, true in enumerate(seen.wrench):
            rate = rate + step * (omega**2 * (true - last) - 0.6 * omega * rate)
            last = last + step * rate
            found[k] = last
        return seen.changed(wrench=found)


class Lens(Foreign):
    """The camera's picture is stretched in one direction of the room; heading is read from it as well."""

    name = "stretched_picture"
    scales = ("stretch",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by how much, and where to."""
        return {"stretch": float(rng.uniform(0.08, 0.3)), "direction": float(rng.uniform(0.0, np.pi))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Stretch all that is tracked."""
        along = np.array([np.cos(values["direction"]), np.sin(values["direction"])])
        matrix = np.eye(2) + values["stretch"] * np.outer(along, along)
        return seen.changed(pose=stretched(seen.pose, matrix), gripper=stretched(seen.gripper, matrix))


def stretched(pose: Floats, matrix: Floats) -> Floats:
    """Return poses (n, 3) as a stretched picture shows them, headings without jumps."""
    ahead = np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])]) @ matrix.T
    turn = np.arctan2(ahead[:, 1], ahead[:, 0])
    off = np.angle(np.exp(1j * (turn - pose[:, 2])))
    return np.column_stack([pose[:, :2] @ matrix.T, pose[:, 2] + off])


SENSINGS: tuple[Family, ...] = (
    CrossTalk(),
    DeadBand(),
    Saturation(),
    ClockDrift(),
    SensorPlay(),
    SensorLag(),
    Lens(),
)
