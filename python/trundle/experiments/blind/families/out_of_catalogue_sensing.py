"""Faults of instruments without a law in the catalogue."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.blind.families.out_of_catalogue_motion import OutOfCatalogueFamily
from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats


class ResonantSensor(OutOfCatalogueFamily):
    """The reading is filtered by a resonant filter of second order."""

    name = "resonant_sensor"
    scales = ("seconds",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its time constant."""
        return {"seconds": float(rng.uniform(0.05, 0.15))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Filter the reading, with damping ratio 0.3."""
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


class StretchedPicture(OutOfCatalogueFamily):
    """The camera's picture is stretched in one direction of the room, which also changes headings."""

    name = "stretched_picture"
    scales = ("stretch",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return stretch and direction."""
        return {"stretch": float(rng.uniform(0.08, 0.3)), "direction": float(rng.uniform(0.0, np.pi))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Stretch all tracked poses."""
        along = np.array([np.cos(values["direction"]), np.sin(values["direction"])])
        matrix = np.eye(2) + values["stretch"] * np.outer(along, along)
        return seen.changed(
            pose=stretch_poses(seen.pose, matrix), gripper=stretch_poses(seen.gripper, matrix)
        )


def stretch_poses(pose: Floats, matrix: Floats) -> Floats:
    """Return poses (n, 3) as a stretched picture shows them, headings without jumps."""
    ahead = np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])]) @ matrix.T
    turn = np.arctan2(ahead[:, 1], ahead[:, 0])
    off = np.angle(np.exp(1j * (turn - pose[:, 2])))
    return np.column_stack([pose[:, :2] @ matrix.T, pose[:, 2] + off])


SENSINGS: tuple[Family, ...] = (
    ResonantSensor(),
    StretchedPicture(),
)
