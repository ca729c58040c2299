"""Effects of instruments: offsets, gains, delays, play, filters and stretched poses."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.family import (
    Context,
    Draw,
    Family,
    Values,
    by_name,
    draws,
    log,
    uniform,
)
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp
from trundle.experiments.blind.readings import Readings, gripper_poses, interpolate
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats

__all__ = ["OUT_OF_CATALOGUE_SENSING", "SENSING"]

AXES = ("x", "y", "torque")
GAINS = ("log_x", "log_y", "log_torque")
TORQUE_ARM_M = 0.1
"""Ratio of the torque's thresholds to those of the forces."""
THRESHOLDS = np.array([1.0, 1.0, TORQUE_ARM_M])
CROSS_TALK_SPREAD = [[0.0, 0.15, 0.6], [0.15, 0.0, 0.6], [0.1, 0.1, 0.0]]
"""Standard deviations of the gains between axes; N·m per N, N per N·m."""
RESONANT_DAMPING_RATIO = 0.3


def draw_bias(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return an offset of 1 to 8 N, with a drift in every second case."""
    size = np.exp(rng.uniform(np.log(1.0), np.log(8.0)))
    turn, drifts = rng.uniform(-np.pi, np.pi), rng.random() < 0.5
    drift = rng.normal(size=2) * 0.15 * size * drifts
    return {
        "force_x": float(size * np.cos(turn)),
        "force_y": float(size * np.sin(turn)),
        "torque_z": float(rng.normal() * 0.1 * size),
        "drift_x": float(drift[0]),
        "drift_y": float(drift[1]),
    }


def add_offset(seen: Readings, context: Context, values: Values) -> Readings:
    """Add an offset that begins with contact and may drift."""
    since = np.maximum(seen.t - CONTACT_TIME_S, 0.0)
    offset = np.array([values["force_x"], values["force_y"], values["torque_z"]])
    drift = np.array([values["drift_x"], values["drift_y"], 0.0])
    added = (seen.t >= CONTACT_TIME_S)[:, None] * (offset + since[:, None] * drift)
    return seen.changed(wrench=seen.wrench + added)


def bias_laws(scene: Scene, values: Values) -> list[Values]:
    """Return the offset, and the drift if it is not zero."""
    drifts = values["drift_x"] != 0.0 or values["drift_y"] != 0.0
    kept = {name: value for name, value in values.items() if drifts or not name.startswith("drift")}
    return [{"kind": "force_bias", **kept}]


def draw_gains(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return gains between 0.6 and 1.6. Equal gains are indistinguishable from another mass."""
    return {name: float(rng.uniform(np.log(0.6), np.log(1.6))) for name in GAINS}


def gains(values: Values, common: float = 0.0) -> Values:
    """Return the gains relative to a common one."""
    return {name.replace("log", "gain"): float(np.exp(values[name] - common)) for name in GAINS}


def build_tool(context: Context, values: Values) -> None:
    """Fix the gripper's mass to the object at the grasp."""
    grasp = context.scene.pushes[context.episode].grasp
    world.add_point_mass(context.table, "tool", (grasp.x, grasp.y), values["mass"])


def draw_frame(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return an offset of 5 cm to 25 cm with a small rotation."""
    size, turn = rng.uniform(0.05, 0.25), rng.uniform(-np.pi, np.pi)
    x, y, theta = size * np.cos(turn), size * np.sin(turn), rng.normal() * 0.05
    return {"offset_x": float(x), "offset_y": float(y), "offset_theta": float(theta)}


def report_frame(seen: Readings, context: Context, values: Values) -> Readings:
    """Report the poses of the tracked frame, which differs from the footprint's frame."""
    frame = Grasp(values["offset_x"], values["offset_y"], values["offset_theta"])
    return seen.changed(pose=gripper_poses(seen.pose, frame))


def mix_axes(seen: Readings, context: Context, values: Values) -> Readings:
    """Add to each axis of the sensor a part of the others."""
    return seen.changed(wrench=seen.wrench @ (np.eye(3) + np.array(values["leak"])).T)


def cross_talk_parameters(scene: Scene, values: Values) -> Values:
    """Return the gains between axes by the catalogue's names."""
    pairs = [(i, k) for i in range(3) for k in range(3) if i != k]
    return {f"{AXES[i]}_from_{AXES[k]}": float(values["leak"][i][k]) for i, k in pairs}


def shrink(seen: Readings, context: Context, values: Values) -> Readings:
    """Shrink forces and torque towards zero by half the width of the dead band."""
    band = values["force"] * THRESHOLDS
    return seen.changed(wrench=np.sign(seen.wrench) * np.maximum(np.abs(seen.wrench) - band, 0.0))


def limit_axes(seen: Readings, context: Context, values: Values) -> Readings:
    """Cut a share of the range of each axis in each episode."""
    most = (1.0 - values["cut"]) * np.max(np.abs(seen.wrench), axis=0)
    return seen.changed(wrench=np.clip(seen.wrench, -most, most))


def draw_pace(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return the relative rate error of a clock, of either sign."""
    return {"pace": float(rng.uniform(0.02, 0.08) * rng.choice([-1.0, 1.0]))}


def read_other_times(seen: Readings, context: Context, values: Values) -> Readings:
    """Read the wrench by a clock of another rate, which is correct at contact."""
    when = seen.t - values["pace"] * np.maximum(seen.t - CONTACT_TIME_S, 0.0)
    return seen.changed(wrench=interpolate(seen.t, seen.wrench, when))


def filtered(seen: Readings, follow: Callable[[Floats, Floats], ArrayLike]) -> Readings:
    """Return the wrench filtered by a function of the last output and the input."""
    found, last = np.empty_like(seen.wrench), np.zeros(3)
    for k, true in enumerate(seen.wrench):
        found[k] = last = np.asarray(follow(last, true))
    return seen.changed(wrench=found)


def add_play(seen: Readings, context: Context, values: Values) -> Readings:
    """Change the reading of each axis only after the force has moved by the width."""
    half = values["width"] / 2 * THRESHOLDS
    return filtered(seen, lambda last, true: np.minimum(np.maximum(last, true - half), true + half))


def low_pass(seen: Readings, context: Context, values: Values) -> Readings:
    """Apply a low-pass filter of first order."""
    step = float(seen.t[1] - seen.t[0])
    if values["time_constant"] < 1e-3 * step:
        return seen
    share = -np.expm1(-step / values["time_constant"])
    return filtered(seen, lambda last, true: last + share * (true - last))


def resonate(seen: Readings, context: Context, values: Values) -> Readings:
    """Apply a resonant filter of second order."""
    step = float(seen.t[1] - seen.t[0])
    if values["seconds"] < step:
        return seen
    omega, rate = 1.0 / values["seconds"], np.zeros(3)

    def follow(last: Floats, true: Floats) -> ArrayLike:
        rate[:] = rate + step * (omega**2 * (true - last) - 2 * RESONANT_DAMPING_RATIO * omega * rate)
        return last + step * rate

    return filtered(seen, follow)


def stretch(seen: Readings, context: Context, values: Values) -> Readings:
    """Stretch all tracked poses in one direction of the room, which also changes headings."""
    along = np.array([np.cos(values["direction"]), np.sin(values["direction"])])
    matrix = np.eye(2) + values["stretch"] * np.outer(along, along)

    def stretched(pose: Floats) -> Floats:
        ahead = np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])]) @ matrix.T
        off = np.angle(np.exp(1j * (np.arctan2(ahead[:, 1], ahead[:, 0]) - pose[:, 2])))
        return np.column_stack([pose[:, :2] @ matrix.T, pose[:, 2] + off])

    return seen.changed(pose=stretched(seen.pose), gripper=stretched(seen.gripper))


DRAW_LEAK: Draw = lambda rng, scene, paths: (rng.normal(size=(3, 3)) * CROSS_TALK_SPREAD).tolist()  # noqa: E731

SENSING = by_name(
    Family(
        "force_bias",
        draw_bias,
        ("force_x", "force_y", "torque_z", "drift_x", "drift_y"),
        distort=add_offset,
        laws=bias_laws,
    ),
    Family(
        "force_scale",
        draw_gains,
        GAINS,
        distort=lambda seen, context, v: seen.changed(
            wrench=seen.wrench * np.exp([v[name] for name in GAINS])
        ),
        # Without a given mass only ratios of gains are identifiable.
        parameters=lambda scene, v: gains(v) if scene.mass_given else {},
        laws=lambda scene, v: [{"kind": "force_scale", **gains(v, 0.0 if scene.mass_given else v["log_x"])}],
    ),
    Family(
        "latency",
        draws(delay=log(0.02, 0.15)),
        ("delay",),
        distort=lambda seen, context, v: seen.changed(
            wrench=interpolate(seen.t, seen.wrench, seen.t - v["delay"])
        ),
    ),
    Family("gripper_inertia", draws(mass=log(1.5, 12.0)), ("mass",), build=build_tool),
    Family("tracker_offset", draw_frame, ("offset_x", "offset_y", "offset_theta"), distort=report_frame),
    Family(
        "cross_talk",
        draws(leak=DRAW_LEAK),
        resize=lambda v, size: {"leak": (size * np.array(v["leak"])).tolist()},
        distort=mix_axes,
        parameters=cross_talk_parameters,
    ),
    Family(
        "saturation",
        draws(cut=uniform(0.3, 0.7)),
        ("cut",),
        distort=limit_axes,
        # The catalogue's law has one range for all episodes.
        parameters=lambda scene, v: {},
        laws=lambda scene, v: [],
    ),
    Family(
        "dead_band",
        draws(force=log(2.0, 12.0)),
        ("force",),
        distort=shrink,
        parameters=lambda scene, v: {"force": v["force"], "torque": TORQUE_ARM_M * v["force"]},
    ),
    Family(
        "sensor_play",
        draws(width=log(3.0, 15.0)),
        ("width",),
        distort=add_play,
        parameters=lambda scene, v: {"force": v["width"], "torque": TORQUE_ARM_M * v["width"]},
    ),
    Family(
        "clock_drift",
        draw_pace,
        ("pace",),
        distort=read_other_times,
        # Seconds of the sensor's clock per true second, minus one.
        parameters=lambda scene, v: {"drift": float(v["pace"] / (1.0 - v["pace"]))},
    ),
    Family("sensor_lag", draws(time_constant=log(0.02, 0.12)), ("time_constant",), distort=low_pass),
)
OUT_OF_CATALOGUE_SENSING = by_name(
    Family(
        "resonant_sensor",
        draws(seconds=uniform(0.05, 0.15)),
        ("seconds",),
        out_of_catalogue=True,
        distort=resonate,
    ),
    Family(
        "stretched_picture",
        draws(stretch=uniform(0.08, 0.3), direction=uniform(0.0, np.pi)),
        ("stretch",),
        out_of_catalogue=True,
        distort=stretch,
    ),
)
