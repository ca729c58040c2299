"""Measure a motion and write it as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import EpisodeContext, HiddenEffect
from trundle.experiments.blind.instruments import (
    GRID_STEP_S,
    merge_streams,
    recording_metadata,
    sample_times,
    stated_noise,
)
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings, interpolate
from trundle.experiments.sampling import Floats
from trundle.experiments.wide import mujoco_engine, ode_engine
from trundle.experiments.wide.scene import WideScene

__all__ = ["make_recording", "simulate_case"]


PRECONTACT_S = (0.2, CONTACT_TIME_S - 0.05)
"""Stated interval without contact, before the clock offset is added."""
SENSING_ORDER = ("gripper_inertia", "force_scale", "force_bias", "latency", "tracker_offset")
"""Order in which instrument effects apply: mechanics, sensor, clock, tracker."""
MEAN_BURST_S = 0.25
"""Mean duration of a burst of lost poses."""


def simulate_case(scene: WideScene, hidden: Sequence[HiddenEffect]) -> list[Readings]:
    """Return the readings of perfect instruments in every episode."""
    engine = mujoco_engine if scene.engine == "mujoco" else ode_engine
    return [engine.simulate(scene, hidden, k) for k in range(len(scene.pushes))]


def make_recording(
    scene: WideScene, hidden: Sequence[HiddenEffect], seen: Sequence[Readings], name: str
) -> trundle.Recording:
    """Measure motions and return the recording. It does not name the hidden effects."""
    tables = {f"episode_{k:02}": episode_table(scene, hidden, k, one) for k, one in enumerate(seen)}
    return trundle.Recording(metadata(scene, name, list(tables)), tables)


def episode_table(
    scene: WideScene, hidden: Sequence[HiddenEffect], episode: int, seen: Readings
) -> dict[str, Floats]:
    """Return an episode's columns."""
    context = EpisodeContext(None, None, scene, episode)
    for one in sorted(hidden, key=lambda one: sensing_order(one.family.name)):
        seen = one.family.distort(seen, context, one.values)
    rng = np.random.default_rng([scene.seed, episode, 14])
    columns: dict[str, tuple[Floats, Floats]] = {}
    frames = (("object", seen.pose), ("gripper", seen.gripper))
    for frame, poses in frames:
        t, measured = tracker_samples(rng, scene, episode, seen.t, poses)
        columns |= {f"{frame}_{axis}": (t, measured[:, k]) for k, axis in enumerate(("x", "y", "theta"))}
    t, wrench = sensor_samples(rng, scene, episode, seen)
    names = (
        ("force_x", "force_y", "torque_z") if instrument_of(scene).torque_given else ("force_x", "force_y")
    )
    columns |= {axis: (t, wrench[:, k]) for k, axis in enumerate(names)}
    return merge_streams(
        {axis: (np.round(t + scene.clock[episode], 6), values) for axis, (t, values) in columns.items()}
    )


def sensing_order(name: str) -> int:
    """Return the sort key of an instrument effect."""
    return SENSING_ORDER.index(name) if name in SENSING_ORDER else -1


def instrument_of(scene: WideScene) -> Any:
    """Return the instrument of a scene."""
    return scene.instrument


def tracker_samples(
    rng: np.random.Generator, scene: WideScene, episode: int, grid: Floats, poses: Floats
) -> tuple[Floats, Floats]:
    """Return time stamps and noisy poses after drop-outs."""
    instrument = instrument_of(scene)
    t = sample_times(rng, instrument.tracker, scene.rest[episode], float(grid[-1]))
    t = t[~dropout_mask(rng, len(t), instrument)]
    when = np.clip(t + instrument.jitter * rng.normal(size=len(t)), 0.0, grid[-1])
    spread = np.array([scene.pose_noise, scene.pose_noise, scene.heading_noise])
    return t, interpolate(grid, poses, when) + rng.normal(size=(len(t), 3)) * spread


def dropout_mask(rng: np.random.Generator, n: int, instrument: Any) -> NDArray[np.bool_]:
    """Return which of `n` samples are lost, independently or in bursts."""
    if not instrument.burst:
        return np.asarray(rng.random(n) < instrument.dropout)
    length = max(MEAN_BURST_S * instrument.tracker, 1.0)
    leave, enter = 1.0 / length, 0.0
    if instrument.dropout > 0.0:
        enter = leave * instrument.dropout / (1.0 - instrument.dropout)
    gone, state = np.zeros(n, dtype=bool), bool(rng.random() < instrument.dropout)
    for k, chance in enumerate(rng.random(n)):
        state = chance >= leave if state else chance < enter
        gone[k] = state
    return gone


def sensor_samples(
    rng: np.random.Generator, scene: WideScene, episode: int, seen: Readings
) -> tuple[Floats, Floats]:
    """Return time stamps and readings, in the published frame and sign."""
    instrument = instrument_of(scene)
    t = sample_times(rng, instrument.sensor, scene.rest[episode], float(seen.t[-1]))
    wrench = (
        window_means(seen, t, 1.0 / instrument.sensor)
        if instrument.filtered
        else interpolate(seen.t, seen.wrench, t)
    )
    spread = np.array([scene.force_noise, scene.force_noise, scene.torque_noise])
    wrench = wrench + np.array(scene.offset) + rng.normal(size=(len(t), 3)) * spread
    if not instrument.raw:
        wrench = wrench - wrench[t < PRECONTACT_S[1]].mean(axis=0)
    published = in_frame(
        wrench, interpolate(seen.t, seen.pose, t), interpolate(seen.t, seen.gripper, t), instrument
    )
    return t, published if instrument.sign == "on_object" else -published


def window_means(seen: Readings, t: Floats, period: float) -> Floats:
    """Return means over a period around each time: an anti-alias filter without delay."""
    total = np.vstack(
        [np.zeros(3), np.cumsum((seen.wrench[1:] + seen.wrench[:-1]) / 2 * GRID_STEP_S, axis=0)]
    )
    ends = [np.clip(t + side * period / 2, 0.0, seen.t[-1]) for side in (-1.0, 1.0)]
    early, late = (interpolate(seen.t, total, end) for end in ends)
    return np.asarray((late - early) / (ends[1] - ends[0])[:, None])


def in_frame(wrench: Floats, pose: Floats, gripper: Floats, instrument: Any) -> Floats:
    """Convert readings (n, 3) from the sensor's axes and origin to other axes and another reference point."""
    c, s = np.cos(gripper[:, 2]), np.sin(gripper[:, 2])
    fx, fy = c * wrench[:, 0] - s * wrench[:, 1], s * wrench[:, 0] + c * wrench[:, 1]
    torque = wrench[:, 2]
    if instrument.reference == "object":
        rx, ry = gripper[:, 0] - pose[:, 0], gripper[:, 1] - pose[:, 1]
        torque = torque + rx * fy - ry * fx
    turn = {"sensor": gripper[:, 2], "object": pose[:, 2], "world": np.zeros(len(pose))}[instrument.frame]
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([c * fx + s * fy, c * fy - s * fx, torque])


def metadata(scene: WideScene, name: str, episodes: list[str]) -> dict[str, Any]:
    """Return the recording's metadata."""
    instrument = instrument_of(scene)
    wrench = {
        "frame": instrument.frame,
        "reference": instrument.reference,
        "sign": instrument.sign,
        "raw": instrument.raw,
        "contact": "point" if instrument.contact == "point" else "grasp",
    }
    if instrument.raw:
        wrench["precontact"] = list(PRECONTACT_S)
        if instrument.shifted:
            late = zip(episodes, scene.clock, strict=True)
            wrench["precontact"] = {one: [end + by for end in PRECONTACT_S] for one, by in late}
    noise = {**stated_noise(scene), "time": instrument.jitter} if instrument.noise_given else None
    return recording_metadata(scene, name, episodes, wrench, noise)
