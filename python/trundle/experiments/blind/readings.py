"""Readings of perfect instruments, and the table and metadata of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trundle.experiments.blind.outline import CELL_SIZE_M, to_world
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats

__all__ = [
    "GRID_STEP_S",
    "PRECONTACT_END_S",
    "Readings",
    "Stream",
    "episode_grid",
    "gripper_poses",
    "interpolate",
    "merge_streams",
    "noisy",
    "recording_metadata",
    "sample_times",
    "step_averages",
    "visited_cells",
    "world_friction_points",
]

Stream = tuple[Floats, Floats]
"""Times and values of one column."""

GRID_STEP_S = 5e-4
"""Step of the grid of ideal readings."""
PRECONTACT_END_S = CONTACT_TIME_S - 0.05
"""End of the stated interval without contact."""


@dataclass(frozen=True)
class Readings:
    """Readings without noise, on a fine grid over the whole episode.

    Attributes
    ----------
    t : array (n,)
        s.
    pose, gripper : array (n, 3)
        Of the tracked frames in the world.
    wrench : array (n, 3)
        Reading without the sensor's offset, gripper axes; zero before contact.
    """

    t: Floats
    pose: Floats
    gripper: Floats
    wrench: Floats

    def changed(self, **arrays: Floats) -> Readings:
        """Return the readings with some arrays replaced."""
        return replace(self, **arrays)


def episode_grid(seconds: float) -> Floats:
    """Return the times of ideal readings in an episode."""
    return np.asarray(GRID_STEP_S * np.arange(round(seconds / GRID_STEP_S) + 1, dtype=np.float64))


def interpolate(t: Floats, values: Floats, at: Floats) -> Floats:
    """Return the columns of `values` interpolated at other times."""
    return np.column_stack([np.interp(at, t, column) for column in values.T])


def step_averages(forces: Floats) -> Floats:
    """Return forces (n, 3) at the times of the steps. Each given force is constant over one step."""
    return np.vstack([forces[:1], (forces[1:] + forces[:-1]) / 2])


def gripper_poses(pose: Floats, grasp: Grasp) -> Floats:
    """Return the poses of the gripper on an object at `pose` (n, 3)."""
    return np.column_stack([to_world(np.array([grasp.x, grasp.y]), pose), pose[:, 2] + grasp.angle])


def world_friction_points(scene: Scene, path: Floats) -> Floats:
    """Return the world positions (n, m, 2) of the points with floor friction along a path (n, 3)."""
    return np.stack([to_world(point, path) for point in scene.friction_points], axis=1)


def visited_cells(scene: Scene, paths: Sequence[Floats]) -> list[list[int]]:
    """Return the grid cells of the floor that a friction point visited."""
    points = np.concatenate([world_friction_points(scene, path[::20]).reshape(-1, 2) for path in paths])
    cells = np.unique(np.floor(points / CELL_SIZE_M).astype(int), axis=0)
    return [[int(x), int(y)] for x, y in cells]


def sample_times(rng: np.random.Generator, rate: float, begin: float, end: float) -> Floats:
    """Return sample times between two times, rounded to 1 µs. The first lies within one period of `begin`."""
    first = begin + rng.uniform(0.0, 1.0 / rate)
    return np.round(first + np.arange(int((end - first) * rate)) / rate, 6)


def noisy(rng: np.random.Generator, values: Floats, spread: Sequence[float]) -> Floats:
    """Return values (n, 3) with independent normal noise."""
    return np.asarray(values + rng.normal(size=values.shape) * np.array(spread))


def merge_streams(columns: dict[str, Stream]) -> dict[str, Floats]:
    """Return one table of all streams, NaN where a stream has no sample."""
    t = np.unique(np.concatenate([when for when, _ in columns.values()]))
    whole = {"t": t}
    for name, (when, values) in columns.items():
        whole[name] = np.full(len(t), np.nan)
        whole[name][np.searchsorted(t, when)] = values
    return whole


def recording_metadata(
    scene: Scene, name: str, episodes: list[str], precontact: object, **noise: float
) -> dict[str, Any]:
    """Return the metadata of a recording, with further stated noise. It does not name hidden effects."""
    instrument, (force, _, torque) = scene.instrument, scene.wrench_noise
    found: dict[str, Any] = {
        "format": "trundle-recording/1",
        "name": name,
        "object": scene.shape.described(with_feet=scene.feet_given),
        "wrench": {key: getattr(instrument, key) for key in ("frame", "reference", "sign", "raw")},
        "split": {"held_out": episodes[-scene.held_out :]},
    }
    found["wrench"]["contact"] = "point" if instrument.contact == "point" else "grasp"
    if instrument.raw:
        found["wrench"]["precontact"] = precontact
    if scene.mass_given:
        found["object"]["mass"] = scene.mass
    if instrument.noise_given:
        found["noise"] = {"pose": list(scene.pose_noise), "force": force, "torque": torque, **noise}
    return found
