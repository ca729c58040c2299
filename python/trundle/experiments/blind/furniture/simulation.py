"""Simulation of furniture in MuJoCo, and its measurement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

import trundle
from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.family import Context, HiddenEffect
from trundle.experiments.blind.push import Push, WrenchPush
from trundle.experiments.blind.readings import (
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

__all__ = ["Motion", "episode_table", "make_recording", "simulate"]

TIME_STEP_S = 5e-4
"""Simulation step."""


@dataclass(frozen=True)
class Motion:
    """True motion of an episode at every step from contact on.

    Attributes
    ----------
    t : array (n,)
        s, as in the table.
    pose : array (n, 3)
        Of the object's frame.
    push : Push or WrenchPush
        The push of the episode.
    wrench : array (n, 3)
        On the object, gripper axes and origin, N, N, N·m.
    """

    t: Floats
    pose: Floats
    push: Push | WrenchPush
    wrench: Floats

    def readings(self, seconds: float) -> Readings:
        """Return the readings of perfect instruments, including the rest before contact."""
        t = episode_grid(seconds)
        pose, wrench = (interpolate(self.t, values, t) for values in (self.pose, self.wrench))
        wrench[t < self.t[0]] = 0.0
        return Readings(t, pose, gripper_poses(pose, self.push.grasp), wrench)


def simulate(scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> Motion:
    """Simulate one episode."""
    push = scene.pushes[episode]
    spec, table = world.new_world(TIME_STEP_S)
    add_body(table, scene)
    world.add_wheel(spec, table, "wheel", scene.wheel)
    world.add_gripper(spec, table, push.grasp)
    model, hooks = world.compile_effects(spec, table, scene, hidden, episode)
    t, poses, wrench = world.simulate_grasp(model, scene, episode, hooks)
    return Motion(t, poses, push, wrench)


def add_body(table: Any, scene: Scene) -> None:
    """Add the object's geometry: boxes of equal density, or a cylinder."""
    contact = {"contype": 1, "conaffinity": 1, "condim": 1}
    if world.add_disc(table, scene, **contact):
        return
    for x, y, w, d in scene.shape.boxes:
        kind, mass = mujoco.mjtGeom.mjGEOM_BOX, scene.mass * 4 * w * d / scene.shape.area
        place = [x, y, world.BODY_HEIGHT_M]
        table.add_geom(type=kind, size=[w, d, 0.1], pos=place, mass=mass, **contact)


def make_recording(
    scene: Scene, hidden: Sequence[HiddenEffect], motions: Sequence[Motion], name: str
) -> trundle.Recording:
    """Measure motions and return the recording. It does not name the hidden effects."""
    tables = {f"episode_{k:02}": episode_table(scene, hidden, k, one) for k, one in enumerate(motions)}
    return trundle.Recording(recording_metadata(scene, name, list(tables), [0.0, PRECONTACT_END_S]), tables)


def episode_table(
    scene: Scene, hidden: Sequence[HiddenEffect], episode: int, true: Motion
) -> dict[str, Floats]:
    """Return the columns of an episode: two noisy streams at their own rates."""
    seconds, instrument = scene.seconds[episode], scene.instrument
    reading, context = true.readings(seconds), Context(scene, episode)
    for one in hidden:
        reading = one.distort(reading, context)
    rng = np.random.default_rng([scene.seed, episode, 2])
    pose_t, force_t = (
        sample_times(rng, rate, 0.0, seconds) for rate in (instrument.tracker, instrument.sensor)
    )
    columns: dict[str, Stream] = {}
    for frame, poses in (("object", reading.pose), ("gripper", reading.gripper)):
        measured = noisy(rng, interpolate(reading.t, poses, pose_t), scene.pose_noise)
        columns |= {f"{frame}_{axis}": (pose_t, measured[:, k]) for k, axis in enumerate(("x", "y", "theta"))}
    wrench = interpolate(reading.t, reading.wrench, force_t) + scene.offset
    measured = noisy(rng, wrench, scene.wrench_noise)
    columns |= {axis: (force_t, measured[:, k]) for k, axis in enumerate(("force_x", "force_y", "torque_z"))}
    return merge_streams(columns)
