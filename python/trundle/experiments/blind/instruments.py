"""Instruments of the first benchmark: a pose tracker, and a force-torque sensor with an offset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import trundle
from trundle.experiments.blind.family import EpisodeContext, HiddenEffect
from trundle.experiments.blind.push import CONTACT_TIME_S, EPISODE_DURATION_S
from trundle.experiments.blind.readings import Readings, gripper_poses, interpolate
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.world import Motion, simulate
from trundle.experiments.sampling import Floats

__all__ = ["ideal_readings", "make_recording"]


POSE_RATE_HZ = 60.0
"""Sample rate of the tracker."""
GRID_STEP_S = 5e-4
"""Step of the grid of ideal readings."""


def ideal_readings(true: Motion) -> Readings:
    """Return the readings of perfect instruments, including the rest before contact."""
    t: Floats = GRID_STEP_S * np.arange(round(EPISODE_DURATION_S / GRID_STEP_S) + 1, dtype=np.float64)
    rest = t < CONTACT_TIME_S
    pose = np.column_stack([np.interp(t, true.t, true.pose[:, k]) for k in range(3)])
    wrench = np.column_stack([np.interp(t, true.t, true.wrench[:, k]) for k in range(3)])
    wrench[rest] = 0.0
    return Readings(t, pose, gripper_poses(pose, true.push.grasp), wrench)


def make_recording(
    scene: Scene, hidden: Sequence[HiddenEffect], motions: Sequence[Motion] | None = None, name: str = "case"
) -> trundle.Recording:
    """Simulate and measure all episodes. The recording does not name the hidden effects."""
    found = [simulate(scene, hidden, k) for k in range(len(scene.pushes))] if motions is None else motions
    tables = {f"episode_{k:02}": episode_table(scene, hidden, k, one) for k, one in enumerate(found)}
    return trundle.Recording(metadata(scene, name, list(tables)), tables)


def episode_table(
    scene: Scene, hidden: Sequence[HiddenEffect], episode: int, true: Motion
) -> dict[str, Floats]:
    """Return the columns of an episode: two noisy streams at their own rates."""
    reading, context = ideal_readings(true), EpisodeContext(None, None, scene, episode)
    for one in hidden:
        reading = one.family.distort(reading, context, one.values)
    rng = np.random.default_rng([scene.seed, episode, 2])
    pose_t, force_t = (
        sample_times(rng, rate, 0.0, EPISODE_DURATION_S) for rate in (POSE_RATE_HZ, scene.rate)
    )
    spread = np.array([scene.pose_noise, scene.pose_noise, scene.heading_noise])
    columns: dict[str, tuple[Floats, Floats]] = {}
    for frame, poses in (("object", reading.pose), ("gripper", reading.gripper)):
        noisy = interpolate(reading.t, poses, pose_t) + rng.normal(size=(len(pose_t), 3)) * spread
        columns |= {f"{frame}_{axis}": (pose_t, noisy[:, k]) for k, axis in enumerate(("x", "y", "theta"))}
    spread = np.array([scene.force_noise, scene.force_noise, scene.torque_noise])
    noisy = interpolate(reading.t, reading.wrench, force_t) + scene.offset
    noisy = noisy + rng.normal(size=(len(force_t), 3)) * spread
    for k, axis in enumerate(("force_x", "force_y", "torque_z")):
        columns[axis] = (force_t, noisy[:, k])
    return merge_streams(columns)


def sample_times(rng: np.random.Generator, rate: float, begin: float, end: float) -> Floats:
    """Return sample times between two times, rounded to 1 µs. The first lies within one period of `begin`."""
    first = begin + rng.uniform(0.0, 1.0 / rate)
    return np.round(first + np.arange(int((end - first) * rate)) / rate, 6)


def merge_streams(columns: dict[str, tuple[Floats, Floats]]) -> dict[str, Floats]:
    """Return one table of all streams, NaN where a stream has no sample."""
    t = np.unique(np.concatenate([when for when, _ in columns.values()]))
    whole = {"t": t}
    for name, (when, values) in columns.items():
        whole[name] = np.full(len(t), np.nan)
        whole[name][np.searchsorted(t, when)] = values
    return whole


def metadata(scene: Scene, name: str, episodes: list[str]) -> dict[str, Any]:
    """Return the recording's metadata."""
    wrench = {
        "frame": "sensor",
        "reference": "sensor",
        "sign": "on_object",
        "raw": True,
        "precontact": [0.0, CONTACT_TIME_S - 0.05],
        "contact": "grasp",
    }
    return recording_metadata(scene, name, episodes, wrench, stated_noise(scene))


def stated_noise(scene: Scene) -> dict[str, Any]:
    """Return the table `[noise]` of a recording."""
    return {
        "pose": [scene.pose_noise, scene.pose_noise, scene.heading_noise],
        "force": scene.force_noise,
        "torque": scene.torque_noise,
    }


def recording_metadata(
    scene: Scene, name: str, episodes: list[str], wrench: dict[str, Any], noise: dict[str, Any] | None
) -> dict[str, Any]:
    """Return the metadata of a recording with these tables `[wrench]` and `[noise]`."""
    described = scene.shape.described(with_feet=scene.feet_given)
    return {
        "format": "trundle-recording/1",
        "name": name,
        "object": {**described, **({"mass": scene.mass} if scene.mass_given else {})},
        "wrench": wrench,
        **({"noise": noise} if noise is not None else {}),
        "split": {"held_out": episodes[-scene.held_out :]},
    }
