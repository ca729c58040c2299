"""What the instruments make of a motion: a tracker, and a force-torque sensor with an offset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import EpisodeContext, HiddenEffect
from trundle.experiments.blind.push import CONTACT_TIME_S, EPISODE_DURATION_S
from trundle.experiments.blind.readings import Readings, gripper_poses, interpolate
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.world import Motion, simulate

__all__ = ["ideal_readings", "make_recording"]

Floats = NDArray[np.float64]

POSE_RATE_HZ = 60.0
"""Hz."""
GRID_STEP_S = 5e-4
"""Of what is seen before it is sampled, s."""


def ideal_readings(true: Motion) -> Readings:
    """Return what perfect instruments would say of a motion, rest before contact included."""
    t: Floats = GRID_STEP_S * np.arange(round(EPISODE_DURATION_S / GRID_STEP_S) + 1, dtype=np.float64)
    rest = t < CONTACT_TIME_S
    pose = np.column_stack([np.interp(t, true.t, true.pose[:, k]) for k in range(3)])
    wrench = np.column_stack([np.interp(t, true.t, true.wrench[:, k]) for k in range(3)])
    wrench[rest] = 0.0
    return Readings(t, pose, gripper_poses(pose, true.push.grasp), wrench)


def make_recording(
    scene: Scene, hidden: Sequence[HiddenEffect], motions: Sequence[Motion] | None = None, name: str = "case"
) -> trundle.Recording:
    """Push, measure, and return the recording; nothing in it names what is hidden."""
    found = [simulate(scene, hidden, k) for k in range(len(scene.pushes))] if motions is None else motions
    tables = {f"episode_{k:02}": episode_table(scene, hidden, k, one) for k, one in enumerate(found)}
    return trundle.Recording(metadata(scene, name, list(tables)), tables)


def episode_table(
    scene: Scene, hidden: Sequence[HiddenEffect], episode: int, true: Motion
) -> dict[str, Floats]:
    """Return an episode's columns: two streams at their own rates, with noise."""
    reading, context = ideal_readings(true), EpisodeContext(None, None, scene, episode)
    for one in hidden:
        reading = one.family.distort(reading, context, one.values)
    rng = np.random.default_rng([scene.seed, episode, 2])
    pose_t, force_t = sample_times(rng, POSE_RATE_HZ), sample_times(rng, scene.rate)
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


def sample_times(rng: np.random.Generator, rate: float) -> Floats:
    """Return sample times that begin anywhere within a period, to the microsecond."""
    first = rng.uniform(0.0, 1.0 / rate)
    return np.round(first + np.arange(int((EPISODE_DURATION_S - first) * rate)) / rate, 6)


def merge_streams(columns: dict[str, tuple[Floats, Floats]]) -> dict[str, Floats]:
    """Return one table of all streams, empty where a stream has no sample."""
    t = np.unique(np.concatenate([when for when, _ in columns.values()]))
    whole = {"t": t}
    for name, (when, values) in columns.items():
        whole[name] = np.full(len(t), np.nan)
        whole[name][np.searchsorted(t, when)] = values
    return whole


def metadata(scene: Scene, name: str, episodes: list[str]) -> dict[str, Any]:
    """Return the recording's metadata."""
    told = scene.shape.described(with_feet=scene.feet_given)
    return {
        "format": "trundle-recording/1",
        "name": name,
        "object": {**told, **({"mass": scene.mass} if scene.mass_given else {})},
        "wrench": {
            "frame": "sensor",
            "reference": "sensor",
            "sign": "on_object",
            "raw": True,
            "precontact": [0.0, CONTACT_TIME_S - 0.05],
            "contact": "grasp",
        },
        "noise": {
            "pose": [scene.pose_noise, scene.pose_noise, scene.heading_noise],
            "force": scene.force_noise,
            "torque": scene.torque_noise,
        },
        "split": {"held_out": episodes[-scene.held_out :]},
    }
