"""Readings of simulated motions, and their measurement with random instruments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import Context, HiddenEffect
from trundle.experiments.blind.instrument import Instrument
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import (
    GRID_STEP_S,
    PRECONTACT_END_S,
    Readings,
    Stream,
    episode_grid,
    gripper_poses,
    interpolate,
    merge_streams,
    noisy,
    recording_metadata,
    sample_times,
)
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats

__all__ = ["grasp_readings", "grid_readings", "make_recording", "rotated"]

PRECONTACT_S = (0.2, PRECONTACT_END_S)
"""Stated interval without contact, before the clock offset is added."""
SENSING_ORDER = ("gripper_inertia", "force_scale", "force_bias", "latency", "tracker_offset")
"""Order in which instrument effects apply: mechanics, sensor, clock, tracker. Other effects come first."""
MEAN_BURST_S = 0.25
"""Mean duration of a burst of lost poses."""


def rotated(vectors: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """Return the components of vectors (n, 2 or more) rotated by angles (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    return c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]


def grasp_readings(scene: Scene, episode: int, t: Floats, pose: Floats, wrench: Floats) -> Readings:
    """Return the readings of a grasp whose wrench is given in its axes about its origin.

    A compliant grasp has no mass: the gripper is displaced in proportion to the wrench.
    """
    grasp = gripper_poses(pose, scene.pushes[episode].grasp)
    along, turn = scene.compliance
    force = np.column_stack(rotated(wrench, grasp[:, 2]))
    gripper = np.column_stack([grasp[:, :2] + along * force, grasp[:, 2] + turn * wrench[:, 2]])
    # The gripper is shifted along the force, so the moment about its origin is that about the grasp.
    return grid_readings(scene, episode, t, pose, gripper, np.column_stack([force, wrench[:, 2]]))


def grid_readings(
    scene: Scene, episode: int, t: Floats, pose: Floats, gripper: Floats, wrench: Floats
) -> Readings:
    """Return readings on the grid, with the rest before contact.

    Parameters
    ----------
    t, pose, gripper : array
        From contact on.
    wrench : array (n, 3)
        On the object: force in world axes, moment about the gripper's origin.
    """
    grid = episode_grid(scene.seconds[episode])
    poses, grippers, world = (interpolate(t, values, grid) for values in (pose, gripper, wrench))
    reading = np.column_stack([*rotated(world, -grippers[:, 2]), world[:, 2]])
    before = grid < CONTACT_TIME_S
    reading[before] = 0.0
    grasp = scene.pushes[episode].grasp
    grippers[before] = gripper[0] if scene.strokes else gripper_poses(pose[None, 0], grasp)[0]
    return Readings(grid, poses, grippers, reading)


def make_recording(
    scene: Scene, hidden: Sequence[HiddenEffect], seen: Sequence[Readings], name: str
) -> trundle.Recording:
    """Measure motions and return the recording. It does not name the hidden effects."""
    tables = {f"episode_{k:02}": episode_table(scene, hidden, k, one) for k, one in enumerate(seen)}
    precontact: object = list(PRECONTACT_S)
    if scene.instrument.shifted:
        late = zip(tables, scene.clock, strict=True)
        precontact = {one: [end + by for end in PRECONTACT_S] for one, by in late}
    metadata = recording_metadata(scene, name, list(tables), precontact, time=scene.instrument.jitter)
    return trundle.Recording(metadata, tables)


def episode_table(
    scene: Scene, hidden: Sequence[HiddenEffect], episode: int, seen: Readings
) -> dict[str, Floats]:
    """Return an episode's columns."""
    for one in sorted(hidden, key=sensing_order):
        seen = one.distort(seen, Context(scene, episode))
    rng = np.random.default_rng([scene.seed, episode, 14])
    columns: dict[str, Stream] = {}
    for frame, poses in (("object", seen.pose), ("gripper", seen.gripper)):
        t, measured = tracker_samples(rng, scene, episode, seen.t, poses)
        columns |= {f"{frame}_{axis}": (t, measured[:, k]) for k, axis in enumerate(("x", "y", "theta"))}
    t, wrench = sensor_samples(rng, scene, episode, seen)
    axes = ("force_x", "force_y", "torque_z")[: 3 if scene.instrument.torque_given else 2]
    columns |= {axis: (t, wrench[:, k]) for k, axis in enumerate(axes)}
    late = scene.clock[episode]
    return merge_streams({axis: (np.round(t + late, 6), values) for axis, (t, values) in columns.items()})


def sensing_order(one: HiddenEffect) -> int:
    """Return the sort key of an effect."""
    name = one.family.name
    return SENSING_ORDER.index(name) if name in SENSING_ORDER else -1


def tracker_samples(
    rng: np.random.Generator, scene: Scene, episode: int, grid: Floats, poses: Floats
) -> Stream:
    """Return time stamps and noisy poses after drop-outs."""
    instrument = scene.instrument
    t = sample_times(rng, instrument.tracker, scene.rest[episode], float(grid[-1]))
    t = t[~dropout_mask(rng, len(t), instrument)]
    when = np.clip(t + instrument.jitter * rng.normal(size=len(t)), 0.0, grid[-1])
    return t, noisy(rng, interpolate(grid, poses, when), scene.pose_noise)


def dropout_mask(rng: np.random.Generator, n: int, instrument: Instrument) -> NDArray[np.bool_]:
    """Return which of `n` samples are lost, independently or in bursts."""
    if not instrument.burst:
        return np.asarray(rng.random(n) < instrument.dropout)
    leave = 1.0 / max(MEAN_BURST_S * instrument.tracker, 1.0)
    enter = leave * instrument.dropout / (1.0 - instrument.dropout)
    gone, state = np.zeros(n, dtype=bool), bool(rng.random() < instrument.dropout)
    for k, chance in enumerate(rng.random(n)):
        state = chance >= leave if state else chance < enter
        gone[k] = state
    return gone


def sensor_samples(rng: np.random.Generator, scene: Scene, episode: int, seen: Readings) -> Stream:
    """Return time stamps and readings, in the published frame and sign."""
    instrument = scene.instrument
    t = sample_times(rng, instrument.sensor, scene.rest[episode], float(seen.t[-1]))
    means = window_means(seen, t, 1.0 / instrument.sensor) if instrument.filtered else None
    wrench = interpolate(seen.t, seen.wrench, t) if means is None else means
    wrench = noisy(rng, wrench + np.array(scene.offset), scene.wrench_noise)
    if not instrument.raw:
        wrench = wrench - wrench[t < PRECONTACT_S[1]].mean(axis=0)
    pose, gripper = (interpolate(seen.t, values, t) for values in (seen.pose, seen.gripper))
    published = in_frame(wrench, pose, gripper, instrument)
    return t, published if instrument.sign == "on_object" else -published


def window_means(seen: Readings, t: Floats, period: float) -> Floats:
    """Return means over a period around each time: an anti-alias filter without delay."""
    middles = (seen.wrench[1:] + seen.wrench[:-1]) / 2
    total = np.vstack([np.zeros(3), np.cumsum(middles * GRID_STEP_S, axis=0)])
    ends = [np.clip(t + side * period / 2, 0.0, seen.t[-1]) for side in (-1.0, 1.0)]
    early, late = (interpolate(seen.t, total, end) for end in ends)
    return np.asarray((late - early) / (ends[1] - ends[0])[:, None])


def in_frame(wrench: Floats, pose: Floats, gripper: Floats, instrument: Instrument) -> Floats:
    """Convert readings (n, 3) from the sensor's axes and origin to other axes and another reference point."""
    fx, fy = rotated(wrench, gripper[:, 2])
    torque = wrench[:, 2]
    if instrument.reference == "object":
        rx, ry = gripper[:, 0] - pose[:, 0], gripper[:, 1] - pose[:, 1]
        torque = torque + rx * fy - ry * fx
    turn = {"sensor": gripper[:, 2], "object": pose[:, 2], "world": np.zeros(len(pose))}[instrument.frame]
    return np.column_stack([*rotated(np.column_stack([fx, fy]), -turn), torque])
